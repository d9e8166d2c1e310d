//! Meshes, poses and steps, as they are made from bytes.

use arbitrary::{Arbitrary, Result, Unstructured};
use pfront::threads::{Pool, Schedule, Settings};
use pfront::{Adjacency, Pose};
use pfront_testkit::MeshData;
use pfront_testkit::shapes::sheet;

/// Up to `N` of something. The number comes first, so that many are as likely as few.
#[derive(Clone, Debug)]
pub struct Few<T, const N: usize>(Vec<T>);

impl<'a, T: Arbitrary<'a>, const N: usize> Arbitrary<'a> for Few<T, N> {
    fn arbitrary(bytes: &mut Unstructured<'a>) -> Result<Self> {
        let count = usize::from(bytes.arbitrary::<u8>()?) % (N + 1);
        (0..count).map(|_| bytes.arbitrary()).collect::<Result<_>>().map(Self)
    }
}

/// Coordinates to pick from: independent ones would never coincide.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub struct Palette([u32; 8]);

impl Palette {
    /// Most picks lie on a small lattice, so that things touch; some within a few bits of it; and few are any
    /// bits, which the oracle needs long integers for.
    #[must_use]
    pub fn number(&self, pick: u8) -> f32 {
        let bits = self.0[usize::from(pick / 32)];
        let lattice = |k: u32| (k % 16) as f32 / 2.0 - 4.0;
        match pick % 32 {
            31 => f32::from_bits(bits),
            k @ 28..31 => f32::from_bits(lattice(bits >> k).to_bits() ^ (bits & 7)),
            k => lattice(k.into()),
        }
    }

    /// A point for each pick.
    #[must_use]
    pub fn points(&self, picks: &[[u8; 3]]) -> Vec<[f32; 3]> {
        picks.iter().map(|p| p.map(|pick| self.number(pick))).collect()
    }
}

/// A mesh of at most `MOST` triangles, perhaps a broken one.
#[derive(Arbitrary, Clone, Debug)]
pub enum Shape {
    /// Any triangles: without area, twice the same, sharing what they like.
    MeshData {
        positions: Few<[u8; 3], 16>,
        triangles: Few<[u8; 3], MOST>,
        stray: Option<Option<u32>>,
    },
    /// A sheet over −1 ..= 1, stretched, at any heights, which are used over and over.
    Sheet { cells: u8, heights: Few<u8, 16>, size: u8 },
    /// Triangles about the first of some points.
    Fan { points: Few<[u8; 3], 18>, closed: bool },
}

/// Brute force in big integers takes its time.
const MOST: usize = 32;

impl Shape {
    /// Its vertices and triangles, whether or not they are a mesh.
    #[must_use]
    pub fn soup(&self, palette: &Palette) -> MeshData {
        match self {
            Shape::MeshData { positions, triangles, stray } => {
                let positions = palette.points(&positions.0);
                let range = positions.len().max(1) as u32;
                let corners = |t: &[u8; 3]| t.map(|v| u32::from(v) % range);
                let mut triangles: Vec<_> = triangles.0.iter().map(corners).collect();
                if let (Some(Some(stray)), Some(last)) = (*stray, triangles.last_mut()) {
                    last[1] = stray;
                }
                MeshData { positions, triangles }
            }
            Shape::Sheet { cells, heights, size } => {
                let mut heights = heights.0.iter().cycle();
                let size = palette.number(*size);
                // Two triangles a cell.
                sheet(u32::from(cells % 4) + 1, |_, _| 0.0).map(|[x, y, _]| {
                    let z = heights.next().map_or(0.0, |&pick| palette.number(pick));
                    [x * size, y * size, z]
                })
            }
            Shape::Fan { points, closed } => {
                let positions = palette.points(&points.0);
                let rim = positions.len().saturating_sub(1) as u32;
                let sectors = if *closed { rim } else { rim.saturating_sub(1) };
                let triangles = (0..sectors).map(|i| [0, i + 1, (i + 1) % rim + 1]).collect();
                MeshData { positions, triangles }
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
    /// Moved so far that bodies lie apart as often as not.
    Away([u8; 3]),
    /// Turned by a quaternion and moved.
    Turned([i8; 4], [u8; 3]),
    /// Any bits.
    Any([[u32; 4]; 3]),
}

impl<T, const N: usize> Few<T, N> {
    pub(crate) fn all(&self) -> &[T] {
        &self.0
    }
}

impl Placing {
    /// The pose.
    #[must_use]
    pub fn pose(&self, palette: &Palette) -> Pose {
        let translation = |t: [u8; 3]| t.map(|pick| palette.number(pick));
        match *self {
            Placing::Here => Pose::IDENTITY,
            Placing::Moved(t) => Pose::from_translation(translation(t)),
            Placing::Away(t) => Pose::from_translation(translation(t).map(|x| 3.0 * x)),
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

/// Something happens, and a question is asked. Bodies are named by their place, modulo their number.
#[derive(Arbitrary, Debug)]
pub struct Step {
    pub(crate) change: Change,
    pub(crate) question: Question,
    pub(crate) ask: Ask,
}

/// A change between questions.
#[derive(Arbitrary, Debug)]
pub enum Change {
    /// Nothing.
    Nothing,
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
    /// Some vertices of a body move, or now and then all, by a number that may be wrong.
    Deform(u8, Few<(u8, [u8; 3]), 6>, Option<Option<Few<[u8; 3], 16>>>),
    /// A body gets another BVH.
    Rebuild(u8, Build),
    /// The threads are others from now on.
    Divide(Crew),
}

/// A question.
#[derive(Arbitrary, Debug)]
pub enum Question {
    /// No more than of all bodies, which is asked every time.
    Scene,
    /// Two bodies, the second posed into the frame of the first.
    Pair([u8; 2], Placing),
    /// Two bodies where they are.
    World([u8; 2]),
    /// One body with itself.
    Within(u8, bool),
}

/// How BVHs are built.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub struct Build {
    pub(crate) leaf_size: u8,
    pub(crate) builder: Builder,
}

/// The builder of a tree.
#[derive(Arbitrary, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Builder {
    /// By surface area.
    Sah,
    /// The same, on threads.
    SahThreads,
    /// Along a Morton curve.
    Morton,
    /// The same, on threads.
    MortonThreads,
}

/// How a question is asked.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub struct Ask {
    page: u8,
    stop: u8,
}

impl Ask {
    /// How many pairs a page holds.
    pub(crate) fn page(self) -> usize {
        usize::from(self.page).max(1)
    }

    /// After how many hits a visitor breaks off: it has seen one at least.
    pub(crate) fn stop(self) -> usize {
        usize::from(self.stop).max(1)
    }
}

pub(crate) fn adjacency(skip: bool) -> Adjacency {
    if skip { Adjacency::SkipNeighbours } else { Adjacency::SharedIndexRule }
}

/// The backend that traverses.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub struct Crew {
    workers: u8,
    schedule: u8,
    coherence: bool,
    max_nodes: Option<u8>,
}

impl Crew {
    pub(crate) fn pool(self) -> Pool {
        let schedules = [Schedule::Static, Schedule::Hybrid];
        let mut settings = Settings {
            schedule: schedules[usize::from(self.schedule % 2)],
            coherence: self.coherence,
            ..Settings::default()
        };
        if let Some(most) = self.max_nodes {
            settings.max_nodes = most.into();
        }
        Pool::new(usize::from(self.workers % 65)).with_settings(settings)
    }
}
