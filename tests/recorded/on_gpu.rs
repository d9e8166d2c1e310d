//! Recorded truths and recordings on a GPU: lists that are the same as on the CPU, sorted, exactly.
//!
//! They run with `--features recorded,gpu`, on the best adapter; without any they fail, and say what to
//! install. `data.rs` says where the data is looked for.
//!
//! `PFRONT_GPU_FULL=1` asks about every frame of every recording, among them all 121 of `cloth/kick`,
//! and about a swarm of bodies in its own size. This takes a real GPU; without the variable the frames are
//! as many as an adapter that computes on the CPU bears in a minute.

use super::data::{self, Case, NASTY_PAIRS, NASTY_SELVES, cases, mesh, vectors};
use pfront::executor::Backend;
use pfront::gpu::{Budget, Deforming, Gpu, GpuModel, GpuQuery, GpuQuestion, GpuSettings};
use pfront::pfront_core::bvtt::PairBvtt;
use pfront::{Executor, Model, PairQuery, Pose, Pose64, SceneQuery, SelfQuery, TrianglePair};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::Scene;
use std::path::Path;
use std::sync::OnceLock;

/// One device for all tests.
fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::new().unwrap_or_else(|error| panic!("{error}")))
}

/// Whether the adapter is asked for all that there is.
fn full() -> bool {
    std::env::var_os("PFRONT_GPU_FULL").is_some_and(|value| value == "1")
}

/// All of `count` frames, or else about `few`, the last among them.
fn frames(count: usize, few: usize) -> impl Iterator<Item = usize> {
    (0..count).rev().step_by(if full() { 1 } else { count.div_ceil(few) })
}

/// A model in both memories.
struct Both {
    cpu: Model,
    gpu: GpuModel,
}

impl Both {
    fn new(soup: MeshData) -> Self {
        let cpu = Model::new(soup.positions, soup.triangles).unwrap();
        Self { gpu: GpuModel::new(gpu(), cpu.bvh()).unwrap(), cpu }
    }

    fn file(file: impl AsRef<Path>) -> Self {
        Self::new(mesh(file.as_ref().to_str().unwrap()))
    }
}

/// Queries of both backends.
struct Asker {
    pairs: PairQuery,
    within: SelfQuery,
    gpu: GpuQuery,
}

impl Asker {
    fn new(settings: GpuSettings) -> Self {
        Self {
            pairs: PairQuery::new(),
            within: SelfQuery::new(),
            gpu: GpuQuery::with_settings(gpu(), settings).unwrap(),
        }
    }

    /// The pairs that both find.
    fn found(&mut self, what: &str, a: &Both, b: &Both, a_from_b: &Pose) -> &[TrianglePair] {
        let truth = self.pairs.all(&a.cpu, &b.cpu, a_from_b).unwrap();
        let found = self.gpu.all(&GpuQuestion::pair(&a.gpu, &b.gpu, a_from_b)).unwrap();
        assert!(found == truth, "{what}: {} pairs, not {}", found.len(), truth.len());
        truth
    }

    /// The same in f64, the pairs that the device leaves open decided by the CPU; returns how many these are.
    fn in_f64(&mut self, what: &str, a: &Both, b: &Both, a_from_b: &Pose64) -> usize {
        let truth = self.pairs.all(&a.cpu, &b.cpu, a_from_b).unwrap();
        let core = PairBvtt::in_f64(a.cpu.bvh(), b.cpu.bvh(), a_from_b).unwrap();
        let question = GpuQuestion::shadows(&a.gpu, &b.gpu, &core.shadows().unwrap());
        let mut found = self.gpu.all(&question).unwrap().to_vec();
        found.extend(self.gpu.open().iter().filter(|pair| core.intersects(**pair)));
        found.sort_unstable();
        assert!(found == truth, "{what} in f64: {} pairs, not {}", found.len(), truth.len());
        self.gpu.open().len()
    }

    /// How many both find within a model, which on the GPU may be one that moves.
    fn within(&mut self, what: &str, cpu: &Model, gpu: &GpuModel) -> usize {
        let truth = self.within.all(cpu).unwrap();
        let found = self.gpu.all(&GpuQuestion::itself(gpu)).unwrap();
        assert!(found == truth, "{what}: {} pairs, not {}", found.len(), truth.len());
        truth.len()
    }
}

impl Default for Asker {
    fn default() -> Self {
        Self::new(gpu().settings())
    }
}

#[test]
fn every_recorded_case() {
    let mut asker = Asker::default();
    for Case { name, a, b, a_from_b, b_world, pairs } in cases() {
        let (a, b) = (Both::new(a), Both::new(b));
        let open = asker.in_f64(&name, &a, &b, &a_from_b.into());
        let kept = asker.gpu.report().triangle_pairs;
        assert_eq!(asker.gpu.report().on_cpu as usize, open);
        println!("{name} in f64: {open} of {kept} triangle pairs were left open");
        let posed = asker.found(&name, &a, &b, &a_from_b);
        match b_world {
            Some(world) => {
                let found = asker.found(&name, &a, &Both::new(world), &Pose::IDENTITY);
                assert!(found == pairs, "{name}");
            }
            None => assert!(posed == pairs, "{name}"),
        }
    }
}

#[test]
fn nasty_pairs() {
    let mut asker = Asker::default();
    for (a, b, count) in NASTY_PAIRS {
        let [s, t] = [a, b].map(|file| Both::file(Path::new("nasty").join(file)));
        let found = asker.found(a, &s, &t, &Pose::IDENTITY).len();
        assert_eq!(count.unwrap_or(found), found, "{a} and {b}");
    }
}

#[test]
fn nasty_pairs_in_f64() {
    let executor = Executor::gpu(gpu(), gpu().settings());
    for (a, b, count) in data::NASTY_PAIRS_IN_F64 {
        let [s, t] = [a, b].map(data::model_in_f64);
        let mut query = PairQuery::new().on(&executor);
        assert_eq!(query.count(&s, &t, Pose::IDENTITY).unwrap(), count, "{a} and {b}");
        assert_eq!(query.all(&s, &t, Pose::IDENTITY).unwrap().len() as u64, count);
        assert_eq!(query.plan().unwrap().backend, Backend::Gpu);
    }
}

#[test]
fn nasty_meshes_with_themselves() {
    let mut asker = Asker::default();
    for file in NASTY_SELVES {
        let both = Both::file(Path::new("nasty").join(file));
        asker.within(file, &both.cpu, &both.gpu);
    }
}

/// 48,184,455 pairs of overlapping boxes for 1,239 pairs that meet, which is more than lists hold. A fourth of the triangles
/// of each mesh, which have a sixteenth of that, are asked about within a sixteenth of the memory.
#[test]
fn twin_in_bounded_memory() {
    let all = gpu().settings().budget.bytes;
    let cases = if full() { vec![(1, all), (1, all / 16)] } else { vec![(4, all / 16)] };
    for (every, bytes) in cases {
        let [a, b] = ["left", "right"].map(|side| {
            let file = format!("nasty/Generic_Twin_7081.1.t0_{side}.obj");
            let mut soup = mesh(&file);
            soup.triangles = soup.triangles.into_iter().step_by(every).collect();
            Both::new(soup)
        });
        let mut asker = Asker::new(GpuSettings { budget: Budget { bytes }, ..gpu().settings() });
        let found = asker.found("twin", &a, &b, &Pose::IDENTITY).len();
        assert!(if every == 1 { found == 1239 } else { found > 20 }, "{found}");
        assert!(asker.gpu.report().runs > 1);
    }
}

#[test]
fn every_depth_bound_and_budget() {
    let [a, b] = ["ballA.off", "ballB.off"].map(|file| Both::file(Path::new("nasty").join(file)));
    let [s, t] = [1, 2].map(|gear| Both::file(format!("gears/bevel/gear45_{gear}.stl")));
    let sliding = Both::file("nasty/same_mesh_far_from_origin.obj");
    for depth in 1..=4 {
        for bytes in [Budget::LEAST.bytes, 100_000, 1 << 20, 64 << 20] {
            let settings = GpuSettings { depth, budget: Budget { bytes }, ..gpu().settings() };
            let (mut asker, what) = (Asker::new(settings), format!("{depth}, {bytes} bytes"));
            assert_eq!(asker.found(&what, &a, &b, &Pose::IDENTITY).len(), 276);
            assert_eq!(asker.found(&what, &s, &t, &Pose::IDENTITY).len(), 62);
            asker.within(&what, &sliding.cpu, &sliding.gpu);
        }
    }
}

#[test]
fn worm_gear() {
    let scene = Scene::by_name("worm-gear", None).unwrap();
    let [a, b] = [0, 1].map(|object| Both::new(object_of(&scene, object)));
    let (mut asker, mut poses) = (Asker::default(), Vec::new());
    for frame in frames(scene.frames(), 6) {
        scene.poses(frame, &mut poses);
        let found = asker.found(&format!("frame {frame}"), &a, &b, &Pose::new(poses[1]));
        assert!(found.len() > 800);
    }
}

/// Every pair of bodies whose boxes overlap, posed in the world by the host.
#[test]
fn swarm() {
    let scene = Scene::by_name("swarm", (!full()).then_some(20_000)).unwrap();
    let soups: Vec<MeshData> =
        (0..scene.objects.len()).map(|object| object_of(&scene, object)).collect();
    let (mut asker, mut poses, mut touching) = (Asker::default(), Vec::new(), 0);
    for frame in frames(scene.frames(), 3) {
        scene.poses(frame, &mut poses);
        let mut query = SceneQuery::new();
        let bodies = soups.iter().zip(&poses).map(|(soup, &rows)| {
            let (model, pose) = (Both::new(soup.clone()).cpu, Pose::new(rows));
            let id = query.add(model, pose).unwrap();
            (id, Both::new(soup.clone().map(|p| pose.apply(p))))
        });
        let bodies: Vec<_> = bodies.collect();
        let mut hits = query.all().unwrap().to_vec();
        let aabb = |id| query.body(id).unwrap().aabb().unwrap();
        for (i, (first, a)) in bodies.iter().enumerate() {
            for (second, b) in &bodies[i + 1..] {
                if !aabb(*first).overlaps(&aabb(*second)) {
                    continue;
                }
                let found = asker.found(&format!("frame {frame}"), a, b, &Pose::IDENTITY);
                let own = hits.extract_if(.., |hit| hit.bodies == [*first, *second]);
                assert!(own.map(|hit| hit.pair).eq(found.iter().copied()));
                touching += usize::from(!found.is_empty());
            }
        }
        assert!(hits.is_empty());
    }
    assert!(touching > 0);
}

/// Ring, sun and planets, which are clear of each other until the sun is moved.
#[test]
fn epicyclic_parts() {
    let name = |part: &str| format!("gears/epicyclic/epicyclic_{part}.ply");
    let sun = Both::file(name("sun"));
    let ring = Both::file(name("ring"));
    let planets = [0, 1, 2, 3, 4].map(|i| Both::file(name(&format!("planet{i}"))));
    let mut asker = Asker::default();
    let mut meet = 0;
    for planet in &planets {
        assert!(asker.found("ring", &ring, planet, &Pose::IDENTITY).is_empty());
        assert!(asker.found("sun", planet, &sun, &Pose::IDENTITY).is_empty());
        let moved = Pose::from_translation([0.4, 0.1, 0.0]);
        meet += asker.found("moved sun", planet, &sun, &moved).len();
    }
    assert!(meet > 0);
}

#[test]
fn cloth_ball() {
    let frames = [92, 93].map(|frame| mesh(&format!("cloth/cloth_ball/cloth_ball{frame}.ply")));
    let [first, second] = frames;
    assert_eq!(first.triangles, second.triangles);
    let mut cpu = Model::new(first.positions.clone(), first.triangles).unwrap();
    let mut moving = Deforming::new(gpu(), cpu.bvh()).unwrap();
    let mut asker = Asker::default();
    let still = asker.within("frame 92", &cpu, &moving);
    let moved = [(93, second.positions), (92, first.positions)].map(|(frame, positions)| {
        cpu.set_positions(&positions).unwrap();
        moving.set_positions(&positions).unwrap();
        asker.within(&format!("frame {frame}"), &cpu, &moving)
    });
    assert!(moved[0] > 0 && moved[1] == still);
}

#[test]
fn kick() {
    let garment = mesh("cloth/kick/kick_frame000.ply");
    let all = vectors("cloth/kick/kick_positions_121x12811x3.f32le");
    let poses: Vec<_> = all.chunks_exact(garment.positions.len()).collect();
    assert_eq!(poses.len(), 121);
    let mut cpu = Model::new(garment.positions, garment.triangles).unwrap();
    let mut moving = Deforming::new(gpu(), cpu.bvh()).unwrap();
    let mut asker = Asker::default();
    for frame in frames(poses.len(), 16) {
        cpu.set_positions(poses[frame]).unwrap();
        moving.set_positions(poses[frame]).unwrap();
        assert!(asker.within(&format!("frame {frame}"), &cpu, &moving) > 0);
    }
}

fn object_of(scene: &Scene, object: usize) -> MeshData {
    let mesh = &scene.meshes[scene.objects[object]];
    MeshData { positions: mesh.positions.clone(), triangles: mesh.triangles.clone() }
}
