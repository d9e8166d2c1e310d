//! The frames that benches run, and who runs them on the CPU.

use pfront::threads::{Pool, Schedule, Settings};
use pfront::{Executor, Model, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_testkit::scenes::{Kind, Scene};
use rayon::ThreadPoolBuilder;
use std::num::NonZero;
use std::sync::{Arc, LazyLock};
use std::thread::available_parallelism;

/// Frames that a bench goes to and fro over.
pub(crate) const FRAMES: usize = 16;

/// Consecutive frames of two models, or of one that deforms.
#[expect(clippy::large_enum_variant, reason = "there are few cases, each for the whole run")]
pub(crate) enum Case {
    Pair { name: &'static str, a: Model, b: Model, poses: Vec<Pose> },
    Within { name: &'static str, model: Model, frames: Vec<Model> },
}

/// Built once.
pub(crate) static CASES: LazyLock<Vec<Case>> = LazyLock::new(cases);

fn cases() -> Vec<Case> {
    let mut cases = vec![
        generated("worm-gear", None, 60),
        generated("torus-knots", Some(1_000_000), 60),
        generated("sheet", None, 100),
    ];
    cases.extend(dragon().map(|model| {
        let sway = |i: usize| Pose::from_translation([0.02 + 0.0002 * i as f32, 0.0, 0.0]);
        let poses = (0..FRAMES).map(sway).collect();
        Case::Pair { name: "dragons", a: model.clone(), b: model, poses }
    }));
    cases
}

fn generated(name: &'static str, size: Option<usize>, from: usize) -> Case {
    let scene = Scene::by_name(name, size).unwrap();
    let model = |object: usize| {
        let mesh = &scene.meshes[scene.objects[object]];
        Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
    };
    let frames = from..from + FRAMES;
    if scene.kind() == Kind::Pair {
        let mut rows = Vec::new();
        let pose = |frame| {
            scene.poses(frame, &mut rows);
            Pose::new(rows[1])
        };
        return Case::Pair { name, a: model(0), b: model(1), poses: frames.map(pose).collect() };
    }
    let mut positions = Vec::new();
    let mut moved = model(0);
    let frame = |frame| {
        scene.positions(frame, &mut positions);
        moved.set_positions(&positions).unwrap();
        moved.clone()
    };
    Case::Within { name, frames: frames.map(frame).collect(), model: model(0) }
}

fn dragon() -> Option<Model> {
    let folder = std::env::var_os("PFRONT_DATA")?;
    let path = std::path::Path::new(&folder).join("classic/dragon_871414.ply");
    let mesh = pfront_files::read_f32(&path).unwrap_or_else(|e| panic!("{e}"));
    Some(Model::new(mesh.positions, mesh.triangles).unwrap())
}

/// The number of the frame that comes next, to and fro; never twice the same, whose answer a query would have kept.
pub(crate) fn turn(number: usize) -> usize {
    let turn = number % (2 * FRAMES - 2);
    turn.min(2 * FRAMES - 2 - turn)
}

impl Case {
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Pair { name, .. } | Self::Within { name, .. } => name,
        }
    }

    /// The pairs of a frame.
    pub(crate) fn found<'q>(&self, query: &'q mut Asker, frame: usize) -> &'q [TrianglePair] {
        match self {
            Self::Pair { a, b, poses, .. } => query.pair.all(a, b, poses[frame]).unwrap(),
            Self::Within { frames, .. } => query.within.all(&frames[frame]).unwrap(),
        }
    }
}

/// A query of either kind.
#[derive(Clone, Default)]
pub(crate) struct Asker {
    pub(crate) pair: PairQuery,
    pub(crate) within: SelfQuery,
}

impl Asker {
    pub(crate) fn on(pool: &Pool) -> Self {
        let executor = Executor::from(pool.clone());
        Self { pair: PairQuery::new().on(&executor), within: SelfQuery::new().on(&executor) }
    }
}

/// A pool of `threads`, and a worker for each.
pub(crate) fn pool(threads: usize, schedule: Schedule) -> Pool {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let settings = Settings { schedule, ..Settings::default() };
    Pool::from(Arc::new(pool)).with_settings(settings)
}

/// Threads of this machine.
pub(crate) fn all_threads() -> usize {
    available_parallelism().map_or(1, NonZero::get)
}
