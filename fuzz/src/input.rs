//! Meshes, poses and calls, as they are made from bytes.

use crate::body::Builder;
use arbitrary::Arbitrary;
use pfront::threads::{Schedule, Settings, Traversal};
use pfront::{Accuracy, Adjacency, Pose};
use pfront_oracle::generate::soup::{Soup, sheet};

/// A sequence of calls.
#[derive(Arbitrary, Debug)]
pub struct Calls {
    palette: Palette,
    steps: Vec<Step>,
}

impl Calls {
    /// The numbers that all steps pick from, and the steps, of which the first few say enough.
    #[must_use]
    pub fn parts(&self) -> (&Palette, &[Step]) {
        (&self.palette, &self.steps[..self.steps.len().min(32)])
    }
}

/// Coordinates of any bit pattern, to pick from: independent ones would never coincide.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub struct Palette([u32; 8]);

impl Palette {
    /// Even picks lie on a small lattice, so that things touch.
    #[must_use]
    pub fn number(&self, pick: u8) -> f32 {
        match (pick / 2, pick % 2) {
            (k, 0) => f32::from(k % 16) - 8.0,
            (k, _) => f32::from_bits(self.0[usize::from(k) % 8]),
        }
    }

    /// A point for each pick.
    #[must_use]
    pub fn points(&self, picks: &[[u8; 3]]) -> Vec<[f32; 3]> {
        picks.iter().map(|p| p.map(|pick| self.number(pick))).collect()
    }
}

/// A mesh of at most [`MOST`] triangles, perhaps a broken one.
#[derive(Arbitrary, Clone, Debug)]
pub enum Shape {
    /// Any triangles: without area, twice the same, sharing what they like.
    Soup { positions: Vec<[u8; 3]>, triangles: Vec<[u8; 3]>, stray: Option<u32> },
    /// A sheet over −1 ..= 1, stretched, at any heights, which are used over and over.
    Sheet { cells: u8, heights: Vec<u8>, size: u8 },
    /// Triangles about the first of some points.
    Fan { points: Vec<[u8; 3]>, closed: bool },
}

/// Brute force in big integers takes its time.
const MOST: usize = 50;

impl Shape {
    /// Its vertices and triangles, whether or not they are a mesh.
    #[must_use]
    pub fn soup(&self, palette: &Palette) -> Soup {
        match self {
            Shape::Soup { positions, triangles, stray } => {
                let positions = palette.points(positions);
                let range = positions.len().max(1) as u32;
                let corners = |t: &[u8; 3]| t.map(|v| u32::from(v) % range);
                let mut triangles: Vec<_> = triangles.iter().take(MOST).map(corners).collect();
                if let (Some(stray), Some(last)) = (*stray, triangles.last_mut()) {
                    last[1] = stray;
                }
                Soup { positions, triangles }
            }
            Shape::Sheet { cells, heights, size } => {
                let mut heights = heights.iter().cycle();
                let size = palette.number(*size);
                // Two triangles a cell.
                sheet(u32::from(cells % 5) + 1, |_, _| 0.0).map(|[x, y, _]| {
                    let z = heights.next().map_or(0.0, |&pick| palette.number(pick));
                    [x * size, y * size, z]
                })
            }
            Shape::Fan { points, closed } => {
                let positions = palette.points(&points[..points.len().min(18)]);
                let rim = positions.len().saturating_sub(1) as u32;
                let sectors = if *closed { rim } else { rim.saturating_sub(1) };
                let triangles = (0..sectors).map(|i| [0, i + 1, (i + 1) % rim + 1]).collect();
                Soup { positions, triangles }
            }
        }
    }
}

/// A pose, perhaps one that is refused.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub enum Placing {
    /// The identity.
    Here,
    /// Moved.
    Moved([u8; 3]),
    /// Turned by a quaternion and moved.
    Turned([i8; 4], [u8; 3]),
    /// Any bits.
    Any([[u32; 4]; 3]),
}

impl Placing {
    /// The pose.
    #[must_use]
    pub fn pose(&self, palette: &Palette) -> Pose {
        let translation = |t: [u8; 3]| t.map(|pick| palette.number(pick));
        match *self {
            Placing::Here => Pose::IDENTITY,
            Placing::Moved(t) => Pose::from_translation(translation(t)),
            Placing::Turned(q, t) => turned(q.map(f64::from), translation(t)),
            Placing::Any(rows) => Pose::new(rows.map(|row| row.map(f32::from_bits))),
        }
    }
}

/// A quaternion without length turns into NaN, which is for the library to refuse.
fn turned([w, x, y, z]: [f64; 4], t: [f32; 3]) -> Pose {
    let s = 2.0 / (w * w + x * x + y * y + z * z);
    let rows = [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ];
    let row = |i: usize| [rows[i][0] as f32, rows[i][1] as f32, rows[i][2] as f32, t[i]];
    Pose::new([0, 1, 2].map(row))
}

/// One call, or a few that belong together. Bodies are named by their place, modulo their number.
#[derive(Arbitrary, Debug)]
pub enum Step {
    /// A new body.
    Add(Shape, Placing, Build),
    /// Another body with the model of one.
    Again(u8, Placing),
    /// A body goes.
    Remove(u8),
    /// A body breaks.
    Split(u8, u8),
    /// A body moves.
    Move(u8, Placing),
    /// The vertices of a body move, those named, or all by a number that may be wrong.
    Deform(u8, Vec<(u8, [u8; 3])>, Option<Vec<[u8; 3]>>),
    /// A body gets another BVH.
    Rebuild(u8, Build),
    /// The threads are others from now on.
    Divide(Crew),
    /// Two bodies, the second posed into the frame of the first.
    Pair([u8; 2], Placing, Ask),
    /// Two bodies where they are.
    World([u8; 2], Ask),
    /// One body with itself.
    Within(u8, bool, Ask),
    /// All bodies.
    Scene(Ask),
}

/// How BVHs are built.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub struct Build {
    pub(crate) leaf_size: u8,
    pub(crate) builder: Builder,
}

/// How a question is asked.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub struct Ask {
    accuracy: u8,
    page: u8,
    /// After how many hits to stop.
    pub(crate) stop: u8,
}

impl Ask {
    pub(crate) fn accuracy(self) -> Accuracy {
        // Mostly what promises most.
        [Accuracy::Exact, Accuracy::Exact, Accuracy::Conservative, Accuracy::Fast]
            [usize::from(self.accuracy % 4)]
    }

    pub(crate) fn page(self) -> usize {
        usize::from(self.page).max(1)
    }
}

pub(crate) fn adjacency(skip: bool) -> Adjacency {
    if skip { Adjacency::SkipNeighbours } else { Adjacency::SharedIndexRule }
}

/// Who walks.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub struct Crew {
    workers: u8,
    schedule: u8,
    coherence: bool,
    most_nodes: Option<u8>,
}

impl Crew {
    pub(crate) fn traversal(self) -> Traversal {
        let schedules = [Schedule::Static, Schedule::Stealing, Schedule::Hybrid];
        let mut settings = Settings {
            schedule: schedules[usize::from(self.schedule % 3)],
            coherence: self.coherence,
            ..Settings::default()
        };
        if let Some(most) = self.most_nodes {
            settings.most_nodes = most.into();
        }
        Traversal::new(usize::from(self.workers % 65)).with_settings(settings)
    }
}
