//! Executors: the threads and the GPU that answer about models and scenes.

use crate::memory::{Call, Done, Handle};
use crate::status::Fault;
use crate::status::pfront_status_t::{PFRONT_FORKED, PFRONT_NO_DEVICE};
use core::ffi::CStr;
use core::num::NonZero;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use pfront::Executor;
use pfront_capi_entry::entry;

/// Who answers.
#[repr(u32)]
#[derive(Clone, Copy)]
pub enum pfront_device_t {
    /// The CPU.
    PFRONT_CPU = 0,
    /// The best GPU, always; what no GPU decides, such as bodies in f64, the workers do.
    PFRONT_GPU = 1,
    /// The CPU, or the best GPU where that pays.
    PFRONT_AUTO = 2,
}

/// Threads or a GPU that answer. Any number of threads, scenes and queries may use one at once.
pub struct pfront_executor_t(());

/// An executor, in the process that it belongs to.
#[derive(Clone)]
pub(crate) struct OwnExecutor {
    pub(crate) executor: Executor,
    /// The process that has its threads or its GPU, if it has some.
    process: Option<NonZero<u32>>,
}

impl Handle for pfront_executor_t {
    type Value = OwnExecutor;
    const SEAL: u32 = u32::from_be_bytes(*b"exec");

    fn is_foreign(own: &OwnExecutor) -> bool {
        own.is_foreign()
    }
}

/// The most workers.
const WORKERS: usize = if cfg!(feature = "threads") { u32::MAX as usize } else { 1 };

impl OwnExecutor {
    /// The calling thread, if `at` is null.
    pub(crate) fn of(call: &mut Call<'_>, at: *const pfront_executor_t) -> Result<Self, Fault> {
        if at.is_null() {
            return Ok(Self { executor: Executor::sequential(), process: None });
        }
        let own = call.cloned(c"executor", at)?;
        own.check(c"executor")?;
        Ok(own)
    }

    /// Checks that it is of this process.
    pub(crate) fn check(&self, what: &'static CStr) -> Done {
        if self.is_foreign() { Err(Fault::of(PFRONT_FORKED, what)) } else { Ok(()) }
    }

    /// Whether another process has its threads or its GPU.
    pub(crate) fn is_foreign(&self) -> bool {
        self.process.is_some_and(|process| process.get() != std::process::id())
    }
}

/// Checks that the pool of threads and the driver of the GPU are of this process, or become so.
fn own_process(what: &'static CStr) -> Done {
    /// The process that has made the first executor with either: a child of `fork` has neither.
    static PROCESS: AtomicU32 = AtomicU32::new(0);
    let own = std::process::id();
    match PROCESS.compare_exchange(0, own, Relaxed, Relaxed) {
        Err(other) if other != own => Err(Fault::of(PFRONT_FORKED, what)),
        _ => Ok(()),
    }
}

fn threads(workers: u32) -> Result<Executor, Fault> {
    Fault::below(c"workers", workers as usize, WORKERS.saturating_add(1))?;
    if workers > 1 {
        own_process(c"workers")?;
        #[cfg(feature = "threads")]
        return Ok(Executor::threads(workers as usize));
    }
    Ok(Executor::sequential())
}

/// The same and the best GPU, which answers where that pays, or always.
#[cfg(feature = "gpu")]
fn with_gpu(cpu: Executor, always: bool) -> Result<Executor, Fault> {
    own_process(c"device")?;
    let gpu = pfront::gpu::Gpu::new().map_err(|_| Fault::of(PFRONT_NO_DEVICE, c"device"))?;
    let settings = gpu.settings();
    match always {
        true => Ok(cpu.behind_gpu(&gpu, settings)),
        false => Ok(cpu.and_gpu(&gpu, settings).map_err(pfront::Error::from)?),
    }
}

#[cfg(not(feature = "gpu"))]
fn with_gpu(_: Executor, _: bool) -> Result<Executor, Fault> {
    Err(Fault::of(PFRONT_NO_DEVICE, c"device"))
}

/// Makes an executor of a `pfront_device_t`. With `workers` above 1, which needs a library that was built with threads, a frame
/// that is worth it is divided into as many parts, for as many threads as the machine has cores; else the calling thread works
/// alone, and more than 1 is PFRONT_OUT_OF_RANGE. 0 counts as 1. Under PFRONT_GPU the workers answer what a GPU does not.
///
/// PFRONT_NO_DEVICE if there is no GPU that can be used, or the library was built without. Opening one takes a second or two,
/// measuring it for PFRONT_AUTO as long again: make one executor and keep it. A child of fork can use and make executors without
/// threads and GPU only, once its parent has made one with either; the others are PFRONT_FORKED there, and can only be freed, which
/// leaves their memory.
#[entry]
fn pfront_executor_create(
    call: &mut Call<'_>,
    device: u32,
    workers: u32,
    executor: *mut *mut pfront_executor_t,
) -> Done {
    let out = call.out(c"executor", executor)?;
    Fault::below(c"device", device as usize, 3)?;
    const GPU: u32 = pfront_device_t::PFRONT_GPU as u32;
    const CPU: u32 = pfront_device_t::PFRONT_CPU as u32;
    let cpu = threads(workers)?;
    let executor = match device {
        CPU => cpu,
        _ => with_gpu(cpu, device == GPU)?,
    };
    let has_either = device != CPU || workers > 1;
    let process = NonZero::new(std::process::id()).filter(|_| has_either);
    out.set(Call::boxed(OwnExecutor { executor, process })?);
    Ok(())
}

/// Frees an executor; null is fine. Scenes and queries that were made with it go on. PFRONT_BUSY if another thread is inside a
/// call with it.
#[entry]
fn pfront_executor_free(call: &mut Call<'_>, executor: *mut pfront_executor_t) -> Done {
    call.free(c"executor", executor)
}
