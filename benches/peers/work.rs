//! The same task for every library: bodies that move, and which of their triangles meet.

use pfront::{Model, PairQuery, Pose, TrianglePair};
use pfront_core::triangle::intersects;
use pfront_testkit::MeshData;
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::scenes::{Kind, Scene, torus_knot};
use std::collections::HashSet;

/// Two bodies, the first of them first, and a triangle of each. Both bodies are the same within one mesh,
/// and the triangles ascend.
pub(crate) type Hit = ([u32; 2], TrianglePair);

/// A library that is asked for the hits of a work.
pub(crate) trait Finder {
    /// Moves everything to a frame: poses vertices, refits BVHs.
    fn place(&mut self, _frame: usize) {}

    /// Adds the hits, in any order, of the frame that everything was moved to.
    fn find(&mut self, frame: usize, found: &mut Vec<Hit>);
}

/// A query that takes poses has nothing to place.
impl<F: FnMut(usize, &mut Vec<Hit>)> Finder for F {
    fn find(&mut self, frame: usize, found: &mut Vec<Hit>) {
        self(frame, found);
    }
}

/// Bodies and where they are in each frame.
pub(crate) struct Work {
    pub(crate) name: String,
    /// A mesh for each body.
    pub(crate) meshes: Vec<MeshData>,
    motion: Motion,
}

enum Motion {
    /// Poses of the bodies in each frame.
    Rigid(Vec<Vec<Pose>>),
    /// Positions of the only body in each frame.
    Deforming(Vec<Vec<[f32; 3]>>),
}

/// Frames of the sheet and of the crowd.
const FRAMES: usize = 5;
const SEED: u64 = 5;

impl Work {
    /// Two torus knots of so many triangles each, the second in random poses in which coarse ones meet.
    pub(crate) fn course(name: &str, triangles: usize, frames: usize) -> Self {
        let (scene, coarse) = (knots(triangles), knots(2000));
        let meet = meet(&coarse);
        let met = (0..).filter(|&frame| meet(poses(&coarse, frame)[1]));
        let motion = Motion::Rigid(met.take(frames).map(|frame| poses(&scene, frame)).collect());
        Self { name: name.to_owned(), meshes: scene.meshes, motion }
    }

    /// Two torus knots of so many triangles each, the second in random poses in which they do not meet,
    /// but would if it were 1 % larger.
    pub(crate) fn near_miss(name: &str, triangles: usize, frames: usize) -> Self {
        let scene = knots(triangles);
        let meet = meet(&scene);
        let larger = |pose: Pose| pose.rows.map(|[x, y, z, t]| [1.01 * x, 1.01 * y, 1.01 * z, t]);
        let missed = (0..)
            .map(|frame| poses(&scene, frame))
            .filter(|poses| !meet(poses[1]) && meet(Pose::new(larger(poses[1]))));
        let motion = Motion::Rigid(missed.take(frames).collect());
        Self { name: name.to_owned(), meshes: scene.meshes, motion }
    }

    /// The folded sheet, in consecutive frames in which its pleats meet.
    pub(crate) fn sheet(name: &str, triangles: usize) -> Self {
        let scene = Scene::by_name("sheet", Some(triangles)).unwrap();
        assert_eq!(scene.kind(), Kind::SelfMesh);
        let frame = |frame| {
            let mut positions = Vec::new();
            scene.positions(frame, &mut positions);
            positions
        };
        let frames = (100..100 + FRAMES).map(frame).collect();
        Self { name: name.to_owned(), meshes: scene.meshes, motion: Motion::Deforming(frames) }
    }

    /// Two recorded dragons, the second in random poses in which they meet, or `None` where the data are missing.
    pub(crate) fn dragons(name: &str, frames: usize) -> Option<Self> {
        let dragon = recorded(name, "classic/dragon_871414.ply")?;
        let scene = Scene::course(dragon.clone(), dragon, usize::MAX, SEED);
        let meet = meet(&scene);
        let all = (0..).map(|frame| poses(&scene, frame));
        let motion = Motion::Rigid(all.filter(|poses| meet(poses[1])).take(frames).collect());
        Some(Self { name: name.to_owned(), meshes: scene.meshes, motion })
    }

    /// Two recorded frames of the cloth-ball, or `None` where the data are missing.
    pub(crate) fn cloth_ball(name: &str) -> Option<Self> {
        let [first, second] = [92, 93]
            .map(|frame| recorded(name, &format!("cloth/cloth_ball/cloth_ball{frame}.ply")));
        let first = first?;
        let motion = Motion::Deforming(vec![first.positions.clone(), second?.positions]);
        Some(Self { name: name.to_owned(), meshes: vec![first], motion })
    }

    /// So many bodies that turn and sway among their neighbours, each with a mesh of its own.
    pub(crate) fn crowd(name: &str, count: usize) -> Self {
        let scene = Scene::by_name("crowd", Some(1600 * count)).unwrap();
        let motion = Motion::Rigid((0..FRAMES).map(|frame| poses(&scene, frame)).collect());
        Self { name: name.to_owned(), meshes: scene.meshes, motion }
    }

    /// Two solids of unit cubes, of so many triangles each. The second is posed by the 24 rotations of
    /// a cube and random whole numbers, so that faces and edges coincide.
    pub(crate) fn voxels(name: &str, triangles: usize) -> Self {
        let mut random = seeded(SEED);
        let meshes = vec![voxels(triangles, &mut random), voxels(triangles, &mut random)];
        let axis = |i| [0, 1, 2].map(|k| if k == i % 3 { 1.0 - 2.0 * (i / 3) as f32 } else { 0.0 });
        let pose = |(i, j)| {
            let ([a, b, c], [d, e, f]) = (axis(i), axis(j));
            let rows = [[a, b, c], [d, e, f], [b * f - c * e, c * d - a * f, a * e - b * d]];
            let mut row = |[x, y, z]: [f32; 3]| [x, y, z, random.random_range(-9..=9) as f32];
            vec![Pose::IDENTITY, Pose::new(rows.map(&mut row))]
        };
        let two_axes = (0..36).map(|n| (n / 6, n % 6)).filter(|(i, j)| i % 3 != j % 3);
        let frames = two_axes.map(pose).collect();
        Self { name: name.to_owned(), meshes, motion: Motion::Rigid(frames) }
    }

    pub(crate) fn frames(&self) -> usize {
        match &self.motion {
            Motion::Rigid(frames) => frames.len(),
            Motion::Deforming(frames) => frames.len(),
        }
    }

    /// The pose of a body in a frame.
    pub(crate) fn pose(&self, frame: usize, body: usize) -> Pose {
        match &self.motion {
            Motion::Rigid(frames) => frames[frame][body],
            Motion::Deforming(_) => Pose::IDENTITY,
        }
    }

    /// The vertices of a body in a frame, before they are posed.
    pub(crate) fn shape(&self, frame: usize, body: usize) -> &[[f32; 3]] {
        match &self.motion {
            Motion::Rigid(_) => &self.meshes[body].positions,
            Motion::Deforming(frames) => &frames[frame],
        }
    }

    /// The vertices of a body in a frame, posed: to the bit where pfront has them.
    pub(crate) fn positions(
        &self,
        frame: usize,
        body: usize,
    ) -> impl Iterator<Item = [f32; 3]> + use<'_> {
        let pose = self.pose(frame, body);
        let posed = move |&p| if pose == Pose::IDENTITY { p } else { pose.apply(p) };
        self.shape(frame, body).iter().map(posed)
    }

    /// Whether a body never moves.
    pub(crate) fn rests(&self, body: usize) -> bool {
        let rests = |poses: &Vec<Pose>| poses[body] == Pose::IDENTITY;
        matches!(&self.motion, Motion::Rigid(frames) if frames.iter().all(rests))
    }

    /// Whether no vertex of one body belongs to both triangles.
    pub(crate) fn apart(&self, &([a, b], pair): &Hit) -> bool {
        let [ta, tb] = [(a, pair.a), (b, pair.b)]
            .map(|(body, triangle)| self.meshes[body as usize].triangles[triangle as usize]);
        a != b || !ta.iter().any(|vertex| tb.contains(vertex))
    }

    /// The candidates that pass an exact test.
    pub(crate) fn exact(&self, frame: usize, mut candidates: Vec<Hit>) -> Vec<Hit> {
        let bodies = 0..self.meshes.len();
        let positions: Vec<Vec<_>> =
            bodies.map(|body| self.positions(frame, body).collect()).collect();
        let triangle = |body: u32, triangle: u32| {
            let of = &self.meshes[body as usize].triangles[triangle as usize];
            of.map(|vertex| positions[body as usize][vertex as usize])
        };
        candidates.retain(|&([a, b], pair)| intersects(&triangle(a, pair.a), &triangle(b, pair.b)));
        candidates
    }
}

pub(crate) fn model(mesh: &MeshData) -> Model {
    Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
}

/// The surface of unit cubes, each beside a random one before it: closed, welded, turned outward.
fn voxels(triangles: usize, random: &mut impl Rng) -> MeshData {
    let beside = |cube: [i32; 3], side: usize| {
        let mut cube = cube;
        cube[side / 2] += 2 * (side % 2) as i32 - 1;
        cube
    };
    let (mut cubes, mut solid) = (vec![[0; 3]], HashSet::from([[0; 3]]));
    let mut faces = 6;
    while 2 * faces < triangles {
        let cube = beside(cubes[random.random_range(0..cubes.len())], random.random_range(0..6));
        if solid.insert(cube) {
            cubes.push(cube);
            faces += 6;
            faces -= 2 * (0..6).filter(|&side| solid.contains(&beside(cube, side))).count();
        }
    }
    let faces = cubes.iter().flat_map(|&cube| (0..6).map(move |side| (cube, side)));
    let outside = faces.filter(|&(cube, side)| !solid.contains(&beside(cube, side)));
    let halves = outside.flat_map(|(cube, side)| {
        let corner = |[u, v]: [i32; 2]| {
            let (mut p, k) = (cube, side / 2);
            p[k] += (side % 2) as i32;
            p[(k + 1) % 3] += u;
            p[(k + 2) % 3] += v;
            p.map(|x| x as f32)
        };
        let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(corner);
        if side % 2 == 1 { [[a, b, c], [a, c, d]] } else { [[c, b, a], [d, c, a]] }
    });
    MeshData::of(halves).welded()
}

/// A recorded mesh, or a message where the data are missing.
fn recorded(name: &str, file: &str) -> Option<MeshData> {
    let read = pfront_files::read_f32(&pfront_testkit::data_folder().join(file));
    let mesh = read.map(|read| MeshData { positions: read.positions, triangles: read.triangles });
    mesh.inspect_err(|error| {
        eprintln!("{name} is left out: {error} (set PFRONT_DATA to the folder with {file})");
    })
    .ok()
}

/// Two torus knots of so many triangles each, the second in random poses.
fn knots(triangles: usize) -> Scene {
    let knot = torus_knot(triangles);
    Scene::course(knot.clone(), knot, usize::MAX, SEED)
}

/// Whether two bodies meet in a pose of the second.
fn meet(scene: &Scene) -> impl Fn(Pose) -> bool + use<> {
    let [a, b] = [0, 1].map(|i| model(&scene.meshes[i]));
    move |pose| PairQuery::new().any(&a, &b, pose).unwrap().is_some()
}

/// All poses in a frame of a scene.
fn poses(scene: &Scene, frame: usize) -> Vec<Pose> {
    let mut rows = Vec::new();
    scene.poses(frame, &mut rows);
    rows.into_iter().map(Pose::new).collect()
}
