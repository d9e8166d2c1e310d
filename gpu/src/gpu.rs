//! A device with the passes compiled for it.

use crate::device::{Scopes, WEB, outcome, poll, scoped};
use crate::moving::MovingPasses;
use crate::pass::{Arithmetic, Pass, Target};
use crate::totals::Totals;
use crate::untold::Untold;
use crate::{GpuError, GpuSettings, GpuTotals, probe};
use pfront_shaders::{
    BRING, CERTIFY, DEAL, DECIDE, DECIDE_INSTANCES, DIVE, EXPAND, EXPAND_INSTANCES, GATHER, NARROW,
    NARROW_DIRECT, NARROW_INSTANCES, ORDER, POSE, SAMPLE, SEED, SETTLE,
};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use wgpu::{Device, Features, Queue};

/// Features that a device needs to keep time.
pub(crate) const TIMESTAMPS: Features =
    Features::TIMESTAMP_QUERY.union(Features::TIMESTAMP_QUERY_INSIDE_PASSES);

/// A feature with which passes read parameters and write results where the host maps them. Without it, as in a browser, these are
/// copied.
///
/// wgpu warns of it for discrete GPUs, which reach such memory over PCIe: copies do so as well.
const MAPPED: Features = Features::MAPPABLE_PRIMARY_BUFFERS;

/// A device, its queue, and the passes compiled for it. Copying is free and shares them.
///
/// # Examples
/// ```no_run
/// let gpu = pfront_gpu::Gpu::new()?;
/// println!("{}", gpu.device().adapter_info().name);
/// # Ok::<(), pfront_gpu::GpuError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Gpu {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    /// Number of the device: buffers of one device look to wgpu like those of another.
    id: u64,
    device: Device,
    queue: Queue,
    passes: Passes,
    certifying: OnceLock<Result<Arc<Certifying>, GpuError>>,
    instances: OnceLock<Result<Arc<Instances>, GpuError>>,
    moving: OnceLock<Result<Arc<MovingPasses>, GpuError>>,
    target: Target,
    failure: Failure,
    totals: Arc<Totals>,
    untold: Untold,
}

/// The loss of the device, once it has been told.
type Failure = Arc<Mutex<Option<GpuError>>>;

/// The passes of queries.
#[derive(Debug)]
pub(crate) struct Passes {
    /// About two meshes or one.
    pub(crate) meshes: Arc<Descent>,
    pub(crate) bring: Pass,
    pub(crate) order: Pass,
    pub(crate) sample: Pass,
    pub(crate) deal: Pass,
    pub(crate) settle: Pass,
    pub(crate) gather: Pass,
}

/// The passes that read meshes.
#[derive(Debug)]
pub(crate) struct Descent {
    /// `seed`; `dive` about instances.
    pub(crate) first: Pass,
    pub(crate) expand: Pass,
    pub(crate) narrow: Pass,
    pub(crate) decide: Pass,
    /// In place of `narrow` and `decide` where f32 leaves few pairs of two meshes open.
    pub(crate) direct: Option<Pass>,
}

/// The passes in place of two of [`Descent`] where the host decides what f32 leaves open: about shadows of meshes in f64, and pairs
/// within a distance. They take the same bind groups.
#[derive(Debug)]
pub(crate) struct Certifying {
    pub(crate) narrow: Pass,
    pub(crate) certify: Pass,
}

/// The passes about instances.
#[derive(Debug)]
pub(crate) struct Instances {
    /// Goes before those of each question.
    pub(crate) pose: Pass,
    pub(crate) descent: Arc<Descent>,
}

impl Descent {
    fn new(
        device: &Device,
        target: Target,
        passes: [&pfront_shaders::Pass; 4],
        direct: Option<&pfront_shaders::Pass>,
    ) -> Result<Arc<Self>, GpuError> {
        let [first, expand, narrow, decide] = passes.map(|pass| Pass::new(device, pass, target));
        let direct = direct.map(|pass| Pass::new(device, pass, target)).transpose()?;
        let (first, expand, narrow, decide) = (first?, expand?, narrow?, decide?);
        Ok(Arc::new(Self { first, expand, narrow, decide, direct }))
    }
}

impl Gpu {
    /// The best adapter of this machine: a discrete GPU before an integrated one, and what runs on
    /// the CPU last. WGPU_BACKEND and WGPU_ADAPTER_NAME choose another.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NoDevice`], and those of [`Gpu::from_device`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn new() -> Result<Self, GpuError> {
        pollster::block_on(Self::open())
    }

    /// The same in a browser; natively the future blocks. Shaders are compiled in the background there: the first answer
    /// waits for them.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NoDevice`]; [`GpuError::Device`].
    ///
    /// # Examples
    /// ```no_run
    /// # async fn demo() -> Result<(), pfront_gpu::GpuError> {
    /// let gpu = pfront_gpu::Gpu::open().await?;
    /// println!("{:?}", gpu.arithmetic());
    /// # Ok(()) }
    /// ```
    pub async fn open() -> Result<Self, GpuError> {
        // wgpu would panic outside of a page and a Worker.
        if WEB && !wgpu::util::is_browser_webgpu_supported().await {
            let reason = "open a page, or a Worker of it, in a browser that has WebGPU".to_owned();
            return Err(GpuError::NoAdapter { reason });
        }
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = adapter(&instance).await?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("pfront"),
            // All the memory that there is; everything else stays within the defaults.
            required_limits: adapter.limits(),
            required_features: adapter.features() & (TIMESTAMPS | MAPPED),
            ..Default::default()
        };
        let refused = |error: wgpu::RequestDeviceError| GpuError::NoDevice {
            adapter: adapter.get_info().name,
            reason: error.to_string(),
        };
        let (device, queue) = adapter.request_device(&descriptor).await.map_err(refused)?;
        let failure = Failure::default();
        let seen = failure.clone();
        device.set_device_lost_callback(move |_, reason| {
            // Any other failure is a consequence of this one.
            *seen.lock().unwrap_or_else(PoisonError::into_inner) =
                Some(GpuError::DeviceLost { reason });
        });
        Self::with_failure(device, queue, failure).await
    }

    /// Works on a device of the caller's. Errors of its own calls are returned; those of the caller's go to
    /// the handlers of the device.
    ///
    /// # Errors
    /// [`GpuError::Limit`] if it was requested with less than the default limits of WebGPU;
    /// [`GpuError::Device`] if its integer arithmetic is wrong or a shader does not compile.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn from_device(device: Device, queue: Queue) -> Result<Self, GpuError> {
        pollster::block_on(Self::with_failure(device, queue, Failure::default()))
    }

    async fn with_failure(
        device: Device,
        queue: Queue,
        failure: Failure,
    ) -> Result<Self, GpuError> {
        check_limits(&device.limits())?;
        let arithmetic = probe::arithmetic(&device, &queue).await?;
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let id = NEXT.fetch_add(1, Ordering::Relaxed);
        let target = Target::new(&device, arithmetic);
        let assemble =
            || Self::assemble(id, device.clone(), queue, target, failure, Arc::default());
        scoped(&device, assemble).await
    }

    fn assemble(
        id: u64,
        device: Device,
        queue: Queue,
        target: Target,
        failure: Failure,
        totals: Arc<Totals>,
    ) -> Result<Self, GpuError> {
        let pass = |pass| Pass::new(&device, pass, target);
        let passes = Passes {
            meshes: Descent::new(
                &device,
                target,
                [&SEED, &EXPAND, &NARROW, &DECIDE],
                Some(&NARROW_DIRECT),
            )?,
            bring: pass(&BRING)?,
            order: pass(&ORDER)?,
            sample: pass(&SAMPLE)?,
            deal: pass(&DEAL)?,
            settle: pass(&SETTLE)?,
            gather: pass(&GATHER)?,
        };
        let gpu = Self {
            shared: Arc::new(Shared {
                id,
                device,
                queue,
                passes,
                certifying: OnceLock::new(),
                instances: OnceLock::new(),
                moving: OnceLock::new(),
                target,
                failure,
                totals,
                untold: Default::default(),
            }),
        };
        gpu.check()?;
        Ok(gpu)
    }

    /// The same device, with posed positions computed otherwise. Integers are right on every adapter; what
    /// the test of the adapter has refused is not, and serves to try it.
    ///
    /// # Errors
    /// [`GpuError::Device`] if a shader does not compile.
    pub fn with_arithmetic(&self, arithmetic: Arithmetic) -> Result<Self, GpuError> {
        self.with_target(Target { arithmetic, ..self.shared.target })
    }

    /// The same device, with passes compiled for another target.
    pub(crate) fn with_target(&self, target: Target) -> Result<Self, GpuError> {
        let Shared { id, device, queue, failure, totals, .. } = &*self.shared;
        let (failure, totals) = (failure.clone(), totals.clone());
        Self::assemble(*id, device.clone(), queue.clone(), target, failure, totals)
    }

    /// The device.
    #[must_use]
    pub fn device(&self) -> &Device {
        &self.shared.device
    }

    /// Its queue.
    #[must_use]
    pub fn queue(&self) -> &Queue {
        &self.shared.queue
    }

    /// Whether passes read parameters and write results where the host maps them.
    pub(crate) fn is_mapped(&self) -> bool {
        self.device().features().contains(MAPPED)
    }

    /// How posed positions are computed on this adapter.
    #[must_use]
    pub fn arithmetic(&self) -> Arithmetic {
        self.shared.target.arithmetic
    }

    /// GpuSettings that suit this device.
    #[must_use]
    pub fn settings(&self) -> GpuSettings {
        let cpu = self.device().adapter_info().device_type == wgpu::DeviceType::Cpu;
        // On a GPU, enough to fill the largest; on a CPU, a few for each core.
        let groups = if cpu { 64 } else { 512 };
        GpuSettings { depth: 7, groups, ..GpuSettings::default() }
    }

    /// Counts of what has been submitted through this `Gpu` and its copies.
    #[must_use]
    pub fn totals(&self) -> GpuTotals {
        self.shared.totals.now()
    }

    pub(crate) fn counted(&self) -> &Totals {
        &self.shared.totals
    }

    /// Whether the device is lost, with everything on it.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.check().is_err()
    }

    pub(crate) fn passes(&self) -> &Passes {
        &self.shared.passes
    }

    /// The passes where the host decides what f32 leaves open, compiled for the first such question.
    pub(crate) fn certifying(&self) -> Result<Arc<Certifying>, GpuError> {
        let compile = || {
            let target = Target { certify: true, ..self.shared.target };
            let pass = |pass| Pass::new(self.device(), pass, target);
            let passes = Certifying { narrow: pass(&NARROW)?, certify: pass(&CERTIFY)? };
            self.check().map(|()| Arc::new(passes))
        };
        self.shared.certifying.get_or_init(compile).clone()
    }

    /// The passes about instances, compiled when the first of them is made.
    pub(crate) fn instances(&self) -> Result<Arc<Instances>, GpuError> {
        let compile = || {
            let (device, target) = (self.device(), self.shared.target);
            let passes = [&DIVE, &EXPAND_INSTANCES, &NARROW_INSTANCES, &DECIDE_INSTANCES];
            let descent = Descent::new(device, target, passes, None)?;
            let passes = Instances { pose: Pass::new(device, &POSE, target)?, descent };
            self.check().map(|()| Arc::new(passes))
        };
        self.shared.instances.get_or_init(compile).clone()
    }

    /// Compiles the passes for scenes and for meshes that move, which the first of them does otherwise: some half a
    /// second.
    ///
    /// # Errors
    /// [`GpuError::Device`], [`GpuError::DeviceLost`], [`GpuError::OutOfMemory`].
    pub fn warm_up(&self) -> Result<(), GpuError> {
        self.instances()?;
        self.moving().map(drop)
    }

    /// Whether these passes are compiled.
    #[must_use]
    pub fn is_warm(&self) -> bool {
        self.shared.moving.get().is_some() && self.shared.instances.get().is_some()
    }

    /// The passes for meshes that move, compiled when the first of them is made.
    pub(crate) fn moving(&self) -> Result<Arc<MovingPasses>, GpuError> {
        let compile = || {
            let passes = MovingPasses::new(self.device(), self.shared.target)?;
            self.check().map(|()| Arc::new(passes))
        };
        self.shared.moving.get_or_init(compile).clone()
    }

    /// Number of this device among those of the process.
    pub(crate) fn id(&self) -> u64 {
        self.shared.id
    }

    /// Reports what has gone wrong on the device, if anything has.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        let failure = self.shared.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.clone().map_or(Ok(()), Err)
    }

    /// The loss of the device, if that is what an error comes from, else the error.
    pub(crate) fn cause_of(&self, error: GpuError) -> GpuError {
        if let GpuError::Map { .. } = error {
            // The loss is told by a poll.
            let _ = poll(self.device());
        }
        self.check().err().unwrap_or(error)
    }

    /// Makes calls of wgpu, and returns the error that they report, if any; on the web [`Gpu::settle`] does.
    pub(crate) fn checked<T>(
        &self,
        call: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let scopes = Scopes::begin(self.device());
        let result = call();
        outcome(result, self.untold().add(scopes.end()))
    }

    pub(crate) fn untold(&self) -> &Untold {
        &self.shared.untold
    }

    /// Waits until a browser has told what was wrong with any call so far, and returns the first error. A model or a query that
    /// was made since the last time is not to be used after an error. Reading an answer begins so. Natively calls return their
    /// own errors, and there is nothing to wait for.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Device`], [`GpuError::DeviceLost`].
    pub async fn settle(&self) -> Result<(), GpuError> {
        let first = self.untold().first().await;
        self.check().and(first)
    }
}

/// The adapter that WGPU_ADAPTER_NAME names a part of, or the best.
async fn adapter(instance: &wgpu::Instance) -> Result<wgpu::Adapter, GpuError> {
    let refused = |reason: String| GpuError::NoAdapter { reason };
    if let Ok(backends) = std::env::var("WGPU_BACKEND")
        && wgpu::Backends::from_comma_list(&backends).is_empty()
    {
        let there = "there are vulkan, metal and dx12";
        return Err(refused(format!("WGPU_BACKEND={backends} names no backend; {there}")));
    }
    let Ok(name) = std::env::var("WGPU_ADAPTER_NAME") else {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let found = instance.request_adapter(&options).await;
        let advice = match std::env::var("WGPU_BACKEND") {
            Ok(backends) => format!("WGPU_BACKEND={backends} admits no other backend"),
            Err(_) => "Install a Vulkan driver; the package mesa-vulkan-drivers (with libvulkan1) \
                       brings one that runs on the CPU"
                .to_owned(),
        };
        return found.map_err(|error| refused(format!("{error}. {advice}")));
    };
    let mut there = instance.enumerate_adapters(wgpu::Backends::all()).await;
    let names: Vec<_> = there.iter().map(|adapter| adapter.get_info().name).collect();
    let part = name.to_lowercase();
    match names.iter().position(|name| name.to_lowercase().contains(&part)) {
        Some(at) => Ok(there.swap_remove(at)),
        None => {
            let names = names.join(", ");
            let reason = format!("no adapter matches WGPU_ADAPTER_NAME={name}; there are {names}");
            Err(refused(reason))
        }
    }
}

/// The defaults of WebGPU, as far as the passes use them.
fn check_limits(limits: &wgpu::Limits) -> Result<(), GpuError> {
    let least = wgpu::Limits::default();
    let used = |name, of: fn(&wgpu::Limits) -> u32| (name, of(&least), of(limits));
    for (limit, needed, available) in [
        used("max_storage_buffers_per_shader_stage", |l| l.max_storage_buffers_per_shader_stage),
        used("max_compute_workgroup_storage_size", |l| l.max_compute_workgroup_storage_size),
        used("max_compute_invocations_per_workgroup", |l| l.max_compute_invocations_per_workgroup),
        used("max_compute_workgroups_per_dimension", |l| l.max_compute_workgroups_per_dimension),
    ] {
        if available < needed {
            return Err(GpuError::Limit {
                limit,
                needed: needed.into(),
                available: available.into(),
            });
        }
    }
    Ok(())
}
