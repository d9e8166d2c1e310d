//! Four scenes that move slowly, each made in f64 and rounded once to f32, and the triangle pairs in them that
//! are worth watching.

use anyhow::{Context, Result, bail};
use glam::{DAffine3, DQuat, DVec3};
use pfront::{Adjacency, Model, SelfQuery, TrianglePair};
use pfront_testkit::oracle::intersect;
use pfront_testkit::scenes::Scene;
use std::collections::BTreeSet;

/// The slides that [`Slide::by_name`] knows.
pub const NAMES: [&str; 4] = ["face on face", "corner into face", "gears meshing", "cloth closing"];

/// One mesh of all bodies of a scene, where each of them is when something has moved by a given length; and
/// pairs of its triangles.
pub struct Slide {
    /// One of [`NAMES`].
    pub name: &'static str,
    triangles: Vec<[u32; 3]>,
    positions: Box<dyn Fn(f64) -> Vec<[f32; 3]> + Send + Sync>,
    watched: Vec<[u32; 2]>,
    /// Where the contact of a pair begins or ends.
    event: f64,
}

/// Bounds the work; in a scene of thousands, those that change first.
const MOST_WATCHED: usize = 64;
/// The length over which a scene is searched for pairs that change.
const REACH: f64 = 0.01;

impl Slide {
    /// A slide; the lengths of its scene are about 1.
    ///
    /// # Errors
    /// For a name not in [`NAMES`].
    pub fn by_name(name: &str) -> Result<Self> {
        match name {
            "face on face" => Ok(face_on_face()),
            "corner into face" => Ok(corner_into_face()),
            "gears meshing" => gears_meshing(),
            "cloth closing" => cloth_closing(),
            _ => bail!("no slide is called '{name}'; there are {}", NAMES.join(", ")),
        }
    }

    /// The corners of the watched pairs when the scene has moved by `length` beyond the event.
    #[must_use]
    pub fn pairs(&self, length: f64) -> Vec<[[[f32; 3]; 3]; 2]> {
        let positions = self.positions(length);
        let corners = |t: u32| self.triangles[t as usize].map(|v| positions[v as usize]);
        self.watched.iter().map(|pair| pair.map(corners)).collect()
    }

    /// All vertices, at the same moment.
    #[must_use]
    pub fn positions(&self, length: f64) -> Vec<[f32; 3]> {
        (self.positions)(self.event + length)
    }

    /// The triangles of all bodies.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The watched pairs, as indices into [`Slide::triangles`].
    #[must_use]
    pub fn watched(&self) -> &[[u32; 2]] {
        &self.watched
    }

    /// All pairs of a triangle before `first` and one from there on.
    fn all_across(mut self, first: u32) -> Self {
        let count = self.triangles.len() as u32;
        self.watched = (0..first).flat_map(|a| (first..count).map(move |b| [a, b])).collect();
        self
    }

    /// Those pairs that meet at some moments of a short way and not at others, and the moment at which the
    /// first of them changes, by bisection.
    fn those_that_change(mut self) -> Result<Self> {
        let moments = [-REACH, 0.0, REACH];
        let found = moments.map(|length| self.meeting(length));
        let [before, between, after] = found;
        let (before, between, after) = (before?, between?, after?);
        let some: BTreeSet<_> = before.union(&between).chain(&after).copied().collect();
        let all =
            |pair: &_| before.contains(pair) && between.contains(pair) && after.contains(pair);
        let changing = some.into_iter().filter(|pair| !all(pair));
        self.watched = changing.take(MOST_WATCHED).map(|pair| [pair.a, pair.b]).collect();
        let meets = |length: f64| self.pairs(length).first().map(|[a, b]| intersect(a, b));
        let ends = moments.windows(2).find(|ends| meets(ends[0]) != meets(ends[1]));
        let [mut from, mut to] = ends.and_then(|ends| ends.try_into().ok()).with_context(|| {
            let name = self.name;
            format!(
                "nothing begins or ceases to meet in '{name}': choose another moment of its scene"
            )
        })?;
        let start = meets(from);
        while to - from > f64::EPSILON {
            let middle = f64::midpoint(from, to);
            if meets(middle) == start { from = middle } else { to = middle }
        }
        self.event = to;
        Ok(self)
    }

    fn meeting(&self, length: f64) -> Result<BTreeSet<TrianglePair>> {
        let model = Model::new(self.positions(length), self.triangles.clone())?;
        let mut query = SelfQuery::new().with_adjacency(Adjacency::SkipNeighbours);
        Ok(query.all(&model)?.iter().copied().collect())
    }
}

/// A plane that no axis is parallel to, so that rounding to f32 moves points off it.
fn tilt() -> DQuat {
    DQuat::from_scaled_axis(DVec3::new(0.61, -0.37, 0.83))
}

/// A square from −1 to 1 of n × n cells at z = 0.
fn square(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| DVec3::new(at(i), at(j), 0.0)));
    let corners = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let cells = corners.flat_map(|o| {
        let [x, y, xy] = [o + 1, o + n + 1, o + n + 2];
        [[o, x, xy], [o, xy, y]]
    });
    (points.collect(), cells.collect())
}

/// A still body and one that moves, in one mesh.
fn of_two(
    name: &'static str,
    still: (Vec<DVec3>, Vec<[u32; 3]>),
    moving: (Vec<DVec3>, Vec<[u32; 3]>),
    pose: impl Fn(f64) -> DAffine3 + Send + Sync + 'static,
) -> Slide {
    let first = still.0.len() as u32;
    let mut triangles = still.1;
    triangles.extend(moving.1.iter().map(|t| t.map(|v| v + first)));
    let positions = move |length: f64| {
        let pose = pose(length);
        let moved = moving.0.iter().map(|&p| pose.transform_point3(p));
        still.0.iter().copied().chain(moved).map(rounded).collect()
    };
    Slide { name, triangles, positions: Box::new(positions), watched: Vec::new(), event: 0.0 }
}

fn rounded(p: DVec3) -> [f32; 3] {
    p.to_array().map(|x| x as f32)
}

/// A smaller square slides over a larger one in its plane.
fn face_on_face() -> Slide {
    let (below, above) = (square(2), square(2));
    let (below, count) = (turned(below, tilt()), 8);
    let along = DVec3::new(0.8, 0.6, 0.0);
    let spin = DQuat::from_rotation_z(0.4);
    of_two(NAMES[0], below, above, move |length| {
        let move_by = tilt() * (along * length + DVec3::new(0.11, 0.07, 0.0));
        DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), tilt() * spin, move_by)
    })
    .all_across(count)
}

fn turned(
    (points, triangles): (Vec<DVec3>, Vec<[u32; 3]>),
    by: DQuat,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    (points.into_iter().map(|p| by * p).collect(), triangles)
}

/// A cube comes down on a face along its normal, corner first.
fn corner_into_face() -> Slide {
    let bit = |corner: u32, axis: u32| f64::from(corner >> axis & 1);
    let points = (0..8).map(|k| DVec3::new(bit(k, 0), bit(k, 1), bit(k, 2))).collect();
    // A face is the four corners with one bit in common; which way it is turned decides nothing.
    let faces =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles = faces.into_iter().flat_map(|[p, q, r, s]| [[p, q, r], [p, r, s]]).collect();
    // On its corner 0, with the diagonal upright.
    let upright = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::Z);
    of_two(NAMES[1], turned(square(2), tilt()), (points, triangles), move |length| {
        let corner = tilt() * DVec3::new(0.21, 0.13, -length);
        DAffine3::from_rotation_translation(tilt() * upright, corner)
    })
    .all_across(8)
}

/// The first sun of the epicyclic train and a planet, which turns on its own from where it meshes.
fn gears_meshing() -> Result<Slide> {
    let scene = Scene::by_name("epicyclic", Some(0))?;
    let mut poses = Vec::new();
    scene.poses(0, &mut poses);
    let gear = |object: usize| {
        let mesh = &scene.meshes[scene.objects[object]];
        let points = mesh.positions.iter().map(|p| DVec3::from(p.map(f64::from)));
        (points.collect::<Vec<_>>(), mesh.triangles.clone())
    };
    let world = |object: usize| {
        let rows = poses[object].map(|row| row.map(f64::from));
        let column = |k: usize| DVec3::new(rows[0][k], rows[1][k], rows[2][k]);
        DAffine3::from_cols(column(0), column(1), column(2), column(3))
    };
    let (sun, planet) = (world(0), world(1));
    let (points, triangles) = gear(0);
    let still = (points.into_iter().map(|p| sun.transform_point3(p)).collect(), triangles);
    // By an angle, which at the planet's pitch circle of radius 15 is a length.
    let turn = move |length: f64| planet * DAffine3::from_rotation_z(length / 15.0);
    of_two(NAMES[2], still, gear(1), turn).those_that_change()
}

/// Two frames of the sheet as its pleats close, and the way from one to the other.
fn cloth_closing() -> Result<Slide> {
    let scene = Scene::by_name("sheet", Some(4_000))?;
    let frame = |number: usize| {
        let mut positions = Vec::new();
        scene.positions(number, &mut positions);
        positions.into_iter().map(|p| DVec3::from(p.map(f64::from))).collect::<Vec<_>>()
    };
    let (from, to) = (frame(CLOSING), frame(CLOSING + 1));
    let ways: Vec<_> = from.iter().zip(&to).map(|(p, q)| *q - *p).collect();
    // The vertex that moves most moves by the length.
    let most = ways.iter().map(|way| way.length()).fold(f64::MIN_POSITIVE, f64::max);
    let positions = move |length: f64| {
        let points = from.iter().zip(&ways);
        points.map(|(p, way)| rounded(*p + *way * (length / most))).collect()
    };
    let triangles = scene.meshes[0].triangles.clone();
    let positions = Box::new(positions);
    let slide = Slide { name: NAMES[3], triangles, positions, watched: Vec::new(), event: 0.0 };
    slide.those_that_change()
}

/// The frame of the sheet at which pleats begin to meet.
const CLOSING: usize = 38;
