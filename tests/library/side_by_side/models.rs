//! Small models that touch, overlap and deform, each with a twin that was just built.

use pfront::{AnyPose, Executor, Model, Pose, Pose64};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::scenes::icosphere;
use pfront_testkit::shapes::{sheet, sphere, strip, tangle, union};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Positions of either precision.
#[derive(Clone, Debug)]
pub(crate) enum Points {
    F32(Vec<[f32; 3]>),
    F64(Vec<[f64; 3]>),
}

impl Points {
    pub(crate) fn of(model: &Model) -> Self {
        let mesh = model.mesh();
        match mesh.positions_f64() {
            Some(positions) => Self::F64(positions.to_vec()),
            None if mesh.is_f64() => Self::F64(widened(mesh.shadow())),
            None => Self::F32(mesh.shadow().to_vec()),
        }
    }

    pub(crate) fn build(&self, triangles: &[[u32; 3]]) -> Model {
        match self {
            Self::F32(points) => Model::new(points.clone(), triangles.to_vec()).unwrap(),
            Self::F64(points) => Model::from_f64(points.clone(), triangles.to_vec()).unwrap(),
        }
    }

    fn map(&self, mut change: impl FnMut([f64; 3]) -> [f64; 3]) -> Self {
        match self {
            Self::F32(points) => {
                let changed = points.iter().map(|p| change(p.map(f64::from)).map(|x| x as f32));
                Self::F32(changed.collect())
            }
            Self::F64(points) => Self::F64(points.iter().map(|p| change(*p)).collect()),
        }
    }

    /// The points posed into the world.
    pub(crate) fn posed(&self, pose: &AnyPose, is_in_f64: bool) -> Self {
        let in_f64 = |points: &[[f64; 3]]| {
            let pose = pose.to_f64();
            Self::F64(points.iter().map(|p| pose.apply(*p)).collect())
        };
        match (self, pose) {
            (Self::F32(points), AnyPose::F32(pose)) if !is_in_f64 => {
                Self::F32(points.iter().map(|p| pose.apply(*p)).collect())
            }
            (Self::F32(points), _) => in_f64(&widened(points)),
            (Self::F64(points), _) => in_f64(points),
        }
    }
}

fn widened(points: &[[f32; 3]]) -> Vec<[f64; 3]> {
    points.iter().map(|p| p.map(f64::from)).collect()
}

/// A model that was built from its present positions and never deforms.
pub(crate) struct Fresh {
    /// Tells it from all others.
    pub(crate) number: u64,
    pub(crate) model: Model,
    pub(crate) points: Points,
    /// The positions of which every deformation is made.
    start: Rc<Points>,
}

impl Fresh {
    pub(crate) fn new(points: Points, triangles: &[[u32; 3]]) -> Rc<Self> {
        Self::from_start(Rc::new(points.clone()), points, triangles)
    }

    fn from_start(start: Rc<Points>, points: Points, triangles: &[[u32; 3]]) -> Rc<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let (number, model) = (NEXT.fetch_add(1, Relaxed), points.build(triangles));
        Rc::new(Self { number, model, points, start })
    }

    /// The same triangles elsewhere.
    pub(crate) fn with(&self, points: Points) -> Rc<Self> {
        Self::from_start(self.start.clone(), points, self.model.mesh().triangles())
    }

    /// Other positions: those of the start, scaled, flat, or with a vertex moved.
    pub(crate) fn deformed(&self, rng: &mut impl Rng) -> Points {
        let scale = f64::from(rng.random_range(2..=5_u8)) * 0.25;
        match rng.random_range(0..5) {
            0 => self.points.clone(),
            1 => self.start.map(|[x, y, _]| [scale * x, y, 0.0]),
            2 => self.points.map(|p| match rng.random_range(0..8) {
                0 => p.map(|x| (x + 0.25).clamp(-2.0, 2.0)),
                _ => p,
            }),
            3 => self.start.map(|[x, y, z]| [x, scale * y, z - 0.25 * x]),
            _ => self.start.map(|p| p.map(|x| scale * x)),
        }
    }
}

/// A model with a history, and its twin.
pub(crate) struct Shape {
    pub(crate) model: Arc<Model>,
    pub(crate) fresh: Rc<Fresh>,
}

impl Shape {
    fn new(points: Points, triangles: &[[u32; 3]]) -> Self {
        Self { model: Arc::new(points.build(triangles)), fresh: Fresh::new(points, triangles) }
    }

    /// Deforms the model by a function that takes positions in f32; copies that scenes and tickets have stay as they are.
    pub(crate) fn deform(
        &mut self,
        rng: &mut impl Rng,
        set_positions: impl FnOnce(&mut Model, &[[f32; 3]]),
    ) {
        let points = self.fresh.deformed(rng);
        let model = Arc::make_mut(&mut self.model);
        match &points {
            Points::F64(points) => model.set_positions(points).unwrap(),
            Points::F32(points) => {
                if rng.random_range(0..20) == 0 {
                    let refused = model.set_positions(&vec![[f32::NAN; 3]; points.len()]);
                    assert_eq!(refused.is_err(), !points.is_empty());
                }
                set_positions(model, points);
            }
        }
        self.fresh = self.fresh.with(points);
    }
}

/// Deforms a model in any of the ways that need no query.
pub(crate) fn set_positions(way: u8) -> impl FnOnce(&mut Model, &[[f32; 3]]) {
    move |model, points| match way {
        0 => model.set_positions_unfitted(points).unwrap(),
        1 => {
            model.set_positions_unfitted(points).unwrap();
            model.fit();
        }
        2 => Executor::sequential().refit(model, points).unwrap(),
        _ => model.set_positions(points).unwrap(),
    }
}

/// Triangles of which almost all pairs meet.
fn heap(triangles: usize) -> MeshData {
    let mut rng = seeded(7);
    MeshData::of((0..triangles).map(|_| {
        let [p, q] = [0; 2].map(|_| [0; 3].map(|_| f32::from(rng.random_range(-8..=8_i8)) / 4.0));
        // The centre of each is near the origin.
        [p, q, [0, 1, 2].map(|k| f32::from(rng.random_range(-1..=1_i8)) / 4.0 - p[k] - q[k])]
    }))
}

/// Models in f32 and in f64, of which f32 holds some.
pub(crate) fn shapes() -> Vec<Shape> {
    let quarters = |p: [f32; 3]| p.map(|x| (4.0 * x).round() / 4.0);
    let flat = sheet(3, |_, _| 0.0);
    let ball = icosphere(20).map(quarters);
    let meshes = [
        flat.clone(),
        sheet(4, |x, y| x * y),
        union(&[ball.clone(), flat]),
        ball,
        sphere(4).map(quarters),
        tangle(24, 40, 2, &mut seeded(3)),
        strip(8),
        heap(24),
        heap(60),
    ];
    let mut shapes = Vec::new();
    for (i, MeshData { positions, triangles }) in meshes.into_iter().enumerate() {
        let noise = [0.0, 1e-9][i % 2];
        let in_f64 = widened(&positions).into_iter().zip((0..).map(f64::from));
        let in_f64 = in_f64.map(|(p, i)| p.map(|x| x + noise * i)).collect();
        shapes.push(Shape::new(Points::F64(in_f64), &triangles));
        shapes.push(Shape::new(Points::F32(positions), &triangles));
    }
    shapes.push(Shape::new(Points::F32(Vec::new()), &[]));
    shapes
}

/// A pose on a lattice, so that models often touch.
pub(crate) fn somewhere(rng: &mut impl Rng) -> AnyPose {
    let at = [0; 3].map(|_| f64::from(rng.random_range(-3..=3_i8)) * 0.5);
    let turn = [0.0, 0.0, f64::from(rng.random_range(0..3_u8)), 1.0];
    match rng.random_range(0..8) {
        0 => Pose64::from_rotation_translation(turn, at).into(),
        1 => Pose::from_rotation_translation(turn.map(|x| x as f32), at.map(|x| x as f32)).into(),
        2 => Pose64::from_translation(at.map(|x| x + 1e-9)).into(),
        // Zeros of either sign.
        3 => Pose::from_translation([-0.0, 0.0, -0.0]).into(),
        4 => Pose::IDENTITY.into(),
        _ => Pose::from_translation(at.map(|x| x as f32)).into(),
    }
}
