//! A GPU as an executor has it.

mod device;
mod gathered;
mod hidden;
mod measure;
mod meshes;
mod mirror;
mod question;
mod reader;

pub(crate) use device::{Device, Slot, merge_open, read};
pub(crate) use gathered::Gathered;
pub(crate) use hidden::Hidden;
pub(crate) use mirror::Mirrors;
pub(crate) use reader::{Reader, Seat, Work};

use super::Executor;
use super::choice::Line;
use crate::environment::with_default;
use crate::gpu::{Gpu, GpuError, GpuSettings, wgpu};
use std::sync::Arc;

impl Executor {
    /// A GPU, which answers all that a GPU can: `any`, `all` and `count`, but of a model in f64 with itself, and within a distance of two models
    /// only. The calling thread does the rest ([`Executor::behind_gpu`] has others for it). Where the GPU fails, the verb returns its error.
    ///
    /// A query keeps the models of its last question there, and shares them with others that ask about the same. Models that no
    /// query or ticket holds any more stay there within [`GpuSettings::mesh_bytes`], the least recently used going first; so
    /// the next question about them uploads nothing. All are given back when the executor goes. A mesh that
    /// deforms has a tree of its own there, which is built anew as soon as the box tests beyond those of a new tree have taken as long as
    /// a build does.
    ///
    /// Lists take [`GpuSettings::budget`] of device memory each: as many as questions are asked at once by threads that wait
    /// for them, one for each scene, and for tickets at most two for batches of pairs and four for others, however many
    /// are in flight (see [`crate::batch`]).
    ///
    /// # Examples
    /// ```no_run
    /// use pfront::gpu::Gpu;
    /// use pfront::{Executor, PairQuery};
    /// let gpu = Gpu::new()?;
    /// let query = PairQuery::new().on(&Executor::gpu(&gpu, gpu.settings()));
    /// # Ok::<(), pfront::gpu::GpuError>(())
    /// ```
    #[must_use]
    pub fn gpu(gpu: &Gpu, settings: GpuSettings) -> Self {
        Self::sequential().behind_gpu(gpu, settings)
    }

    /// The same CPU behind a GPU, which answers what it does for [`Executor::gpu`]; the rest, such as contacts and distances, all threads of this
    /// executor do, and not the calling one alone.
    ///
    /// # Examples
    /// ```no_run
    /// use pfront::gpu::Gpu;
    /// use pfront::{Executor, SceneQuery};
    /// let gpu = Gpu::new()?;
    /// let scene = SceneQuery::new().on(&Executor::threads(8).behind_gpu(&gpu, gpu.settings()));
    /// # Ok::<(), pfront::gpu::GpuError>(())
    /// ```
    #[must_use]
    pub fn behind_gpu(mut self, gpu: &Gpu, settings: GpuSettings) -> Self {
        self.device = Some(Arc::new(Device::new(gpu, settings, None)));
        self.reader = Some(Arc::new(Reader::new(gpu)));
        self
    }

    /// The same CPU and a GPU, which answers where that pays. Measures both, which takes about two seconds.
    ///
    /// After an error of the GPU, the CPU answers the next question of that query, and after each further error twice as many,
    /// at most 1,024; then the GPU is asked again. After the loss of the device it is not. [`Plan::failure`](super::Plan::failure) tells why.
    ///
    /// # Errors
    /// As [`crate::PairQuery::all`] on a GPU, while it is measured.
    pub fn and_gpu(self, gpu: &Gpu, settings: GpuSettings) -> Result<Self, GpuError> {
        let line = with_default(|| measure::measure(&self, gpu))?;
        Ok(self.with_line(gpu, settings, line))
    }

    /// The same and the best GPU, if there is one that does not compute on the CPU and can be used.
    pub(super) fn and_best_gpu(self) -> Self {
        if let Ok(gpu) = with_default(Gpu::new)
            && gpu.device().adapter_info().device_type != wgpu::DeviceType::Cpu
            && let Ok(both) = self.clone().and_gpu(&gpu, gpu.settings())
        {
            return both;
        }
        self
    }

    fn with_line(mut self, gpu: &Gpu, settings: GpuSettings, line: Line) -> Self {
        self.device = Some(Arc::new(Device::new(gpu, settings, Some(line))));
        self
    }
}

#[cfg(test)]
mod tests {
    use crate::executor::choice::Line;
    use crate::executor::{Backend, Reason};
    use crate::{AnyPose, Executor, Model, PairQuery, Pose, Pose64, SceneQuery, SelfQuery};

    /// A CPU and a GPU that promises to be faster. Lavapipe is slower than the CPU that it runs on, so that queries change
    /// to it and back.
    fn promising() -> Executor {
        let gpu = crate::gpu::Gpu::new().unwrap();
        let line = Line { latency: 0.0, slope: 0.0, setup: 0.0, upload: 0.0 };
        Executor::sequential().with_line(&gpu, gpu.settings(), line)
    }

    fn ball() -> Model {
        let ball = pfront_testkit::scenes::icosphere(500);
        Model::new(ball.positions, ball.triangles).unwrap()
    }

    #[test]
    fn pairs_are_the_same_while_the_query_changes_sides() {
        let (ball, mut query, mut truth) =
            (ball(), PairQuery::new().on(&promising()), PairQuery::new());
        let mut seen = Vec::new();
        for frame in 0..60 {
            let pose = Pose::from_translation([0.1 + 0.02 * frame as f32, 0.0, 0.0]);
            assert_eq!(
                query.all(&ball, &ball, pose).unwrap(),
                truth.all(&ball, &ball, pose).unwrap()
            );
            seen.push(query.plan().unwrap().backend);
        }
        assert!(
            [Backend::Sequential, Backend::Gpu].iter().all(|one| seen.contains(one)),
            "{seen:?}"
        );
    }

    /// A GPU does not pose coordinates of more than half the range of f32.
    #[test]
    fn a_gpu_that_failed_is_asked_again() {
        let ball = pfront_testkit::scenes::icosphere(80);
        let most = ball.positions.iter().flatten().fold(0.0_f32, |most, x| most.max(x.abs()));
        let scaled = ball.positions.iter().map(|p| p.map(|x| x / most * 2e38)).collect();
        let ball = Model::new(scaled, ball.triangles).unwrap();
        let mut query = PairQuery::new().on(&promising());
        let mut ask = |scale: f32| {
            query.forget();
            let rows = [0, 1, 2].map(|k| [0, 1, 2, 3].map(|i| if i == k { scale } else { 0.0 }));
            query.count(&ball, &ball, Pose::new(rows)).unwrap();
            let plan = query.plan().unwrap();
            (plan.backend, plan.reason, plan.failure.is_some())
        };
        // Some frames on the CPU come first.
        let failed = (Backend::Sequential, Reason::GpuFailed, true);
        assert!((0..40).any(|_| ask(0.1) == failed));
        assert_eq!(ask(1.0), failed);
        let (backend, _, has_failed) = ask(1.0);
        assert_eq!((backend, has_failed), (Backend::Gpu, false));
    }

    #[test]
    fn deforming_meshes_and_scenes_are_the_same_while_queries_change_sides() {
        let executor = promising();
        let (mut own, mut other, start) = (ball(), ball(), ball());
        let (mut query, mut truth) = (SelfQuery::new().on(&executor), SelfQuery::new());
        let scenes = || [SceneQuery::new().on(&executor), SceneQuery::new()];
        let mut scenes = scenes();
        let shared = std::sync::Arc::new(ball());
        let bodies = scenes.each_mut().map(|scene| {
            [0.0, 0.7, 1.4]
                .map(|x| scene.add(shared.clone(), Pose::from_translation([x, 0.0, 0.0])).unwrap())
        });
        let mut seen = Vec::new();
        for frame in 0..40 {
            let fold = 0.02 * frame as f32;
            let folded: Vec<_> = start
                .mesh()
                .shadow()
                .iter()
                .map(|&[x, y, z]| [x, y, z * (1.0 - 3.0 * fold * x)])
                .collect();
            query.set_positions(&mut own, &folded).unwrap();
            truth.set_positions(&mut other, &folded).unwrap();
            assert_eq!(query.all(&own).unwrap(), truth.all(&other).unwrap(), "{frame}");
            seen.push(query.plan().unwrap().backend);
            for (scene, bodies) in scenes.iter_mut().zip(&bodies) {
                scene.set_pose(bodies[1], Pose::from_translation([0.7, fold, 0.0])).unwrap();
                if frame % 7 == 3 {
                    scene.set_positions(bodies[2], &folded).unwrap();
                }
                if frame % 11 == 5 {
                    scene
                        .add(shared.clone(), Pose::from_translation([0.3, 0.1 * fold, 0.5]))
                        .unwrap();
                }
            }
            let [scene, truth] = &mut scenes;
            assert_eq!(scene.all().unwrap(), truth.all().unwrap(), "{frame}");
            seen.push(scene.plan().unwrap().backend);
        }
        for parity in 0..2 {
            let of = |backend| seen.iter().skip(parity).step_by(2).any(|&one| one == backend);
            assert!(of(Backend::Sequential) && of(Backend::Gpu), "{seen:?}");
        }
    }

    #[test]
    fn queries_on_a_gpu_fit_no_bvh_and_make_no_certificates() {
        let gpu = crate::gpu::Gpu::new().unwrap();
        let executor = Executor::gpu(&gpu, gpu.settings());
        let (still, mut moving) = (ball(), ball());
        let scaled =
            |by: f32| still.mesh().shadow().iter().map(|p| p.map(|x| by * x)).collect::<Vec<_>>();
        let (mut query, mut within) =
            (PairQuery::new().on(&executor), SelfQuery::new().on(&executor));
        // The first question brings the BVH there.
        query.count(&still, &moving, Pose::IDENTITY).unwrap();
        for frame in 1..4 {
            moving.set_positions_unfitted(&scaled(1.0 + 0.01 * frame as f32)).unwrap();
            let mut fitted = moving.clone();
            fitted.fit();
            let bytes = moving.bytes();
            for pose in [
                AnyPose::F32(Pose::from_translation([0.3, 0.1, 0.0])),
                AnyPose::F64(Pose64::from_translation([0.3, 0.1, 0.0])),
            ] {
                let mut truth = PairQuery::new();
                let expected = truth.contacts(&still, &fitted, pose).unwrap();
                assert!(!expected.is_empty());
                assert_eq!(query.contacts(&still, &moving, pose).unwrap(), expected);
                assert!(query.any(&still, &moving, pose).unwrap().is_some());
                query.forget();
                assert_eq!(query.count(&still, &moving, pose).unwrap(), expected.len() as u64);
            }
            assert!(within.contacts(&moving).unwrap().is_empty());
            assert!(!moving.is_fitted() && moving.bytes() == bytes, "frame {frame}");
        }
    }
}
