//! The threads and devices that answer, made once for each process.

use crate::errors::device;
use pfront::gpu::{Gpu, wgpu};
use pfront::threads::Traversal;
use pfront::threads::rayon::{ThreadPool, ThreadPoolBuilder};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::process;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The time between two looks at signals while others work.
pub(crate) const PATIENCE: Duration = Duration::from_millis(20);

/// The id of the next executor.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// Devices that answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Device {
    Cpu,
    Gpu,
    Auto,
}

/// The backend that answered last.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
pub(crate) enum Backend {
    OneThread = 1,
    Threads,
    Gpu,
    Scene,
}

/// What a process has made.
struct Made {
    process: u32,
    pool: Option<Arc<ThreadPool>>,
    cpu: pfront::Executor,
    /// The executor of the device asked for.
    device: Option<pfront::Executor>,
}

/// Threads and a device. A process that was forked makes its own threads: those of its parent are not there.
#[pyclass(frozen, module = "pfront._pfront")]
pub struct Executor {
    pub(crate) threads: usize,
    pub(crate) device: Device,
    made: Mutex<Option<Made>>,
    /// Tells this executor from all others of the process.
    pub(crate) id: u64,
    last: AtomicU8,
    plan: Mutex<String>,
}

#[pymethods]
impl Executor {
    #[new]
    fn new(threads: usize, device: Option<&str>) -> PyResult<Self> {
        let device = match device {
            None | Some("cpu") => Device::Cpu,
            Some("gpu") => Device::Gpu,
            Some("auto") => Device::Auto,
            Some(other) => {
                let text = format!("device {other:?} is none of None, 'cpu', 'gpu' and 'auto'");
                return Err(PyValueError::new_err(text));
            }
        };
        if !(1..=1024).contains(&threads) {
            return Err(PyValueError::new_err(format!("{threads} threads are not 1 to 1024")));
        }
        let (made, last) = (Mutex::new(None), AtomicU8::new(0));
        let id = NEXT.fetch_add(1, Relaxed);
        Ok(Self { threads, device, made, id, last, plan: Mutex::default() })
    }

    /// Opens the device, if one is asked for.
    fn open(&self, py: Python<'_>) -> PyResult<()> {
        match self.device {
            Device::Cpu => Ok(()),
            Device::Gpu | Device::Auto => py.detach(|| self.on_device()).map(drop),
        }
    }

    /// The backend of the last answer, in words.
    fn explain(&self) -> String {
        let last = self.last.load(Relaxed);
        let is = |backend: Backend| last == backend as u8;
        if is(Backend::OneThread) {
            "one thread: the question ended before others were worth calling".into()
        } else if is(Backend::Threads) {
            format!("{} threads", self.threads)
        } else if is(Backend::Gpu) {
            "GPU".into()
        } else if is(Backend::Scene) {
            lock(&self.plan).clone()
        } else {
            "nothing was asked yet".into()
        }
    }
}

impl Executor {
    /// Notes who answered.
    pub(crate) fn note(&self, backend: Backend) {
        self.last.store(backend as u8, Relaxed);
    }

    /// Notes the plan of a scene.
    pub(crate) fn note_plan(&self, plan: String) {
        *lock(&self.plan) = plan;
        self.note(Backend::Scene);
    }

    /// The threads of this process, if there are several.
    pub(crate) fn pool(&self) -> Option<Arc<ThreadPool>> {
        if self.threads < 2 {
            return None;
        }
        self.made(|made| made.pool.clone())
    }

    /// The CPU of this process.
    pub(crate) fn on_cpu(&self) -> pfront::Executor {
        self.made(|made| made.cpu.clone())
    }

    /// The device of this process, opened if it is not.
    pub(crate) fn on_device(&self) -> PyResult<pfront::Executor> {
        if self.device == Device::Cpu {
            return Ok(self.on_cpu());
        }
        if let Some(device) = self.made(|made| made.device.clone()) {
            return Ok(device);
        }
        let cpu = self.on_cpu();
        let opened = match (Gpu::new(), self.device) {
            (Ok(gpu), Device::Gpu) => pfront::Executor::gpu(&gpu, gpu.settings()),
            (Ok(gpu), _) if is_hardware(&gpu) => {
                cpu.and_gpu(&gpu, gpu.settings()).map_err(|error| device(error.to_string()))?
            }
            (Err(error), Device::Gpu) => return Err(device(error.to_string())),
            _ => cpu,
        };
        self.made(|made| made.device = Some(opened.clone()));
        Ok(opened)
    }

    fn made<T>(&self, read: impl FnOnce(&mut Made) -> T) -> T {
        let mut made = lock(&self.made);
        let process = process::id();
        match &mut *made {
            Some(made) if made.process == process => read(made),
            other => {
                // What a parent has made is left as it is: to drop it would wait for its threads.
                std::mem::forget(other.take());
                read(other.insert(Made::new(self.threads, process)))
            }
        }
    }
}

impl Made {
    fn new(threads: usize, process: u32) -> Self {
        let builder = ThreadPoolBuilder::new().num_threads(threads);
        let pool = (threads > 1)
            .then(|| builder.thread_name(|i| format!("pfront {i}")).build().ok())
            .flatten()
            .map(Arc::new);
        // Where there are no more threads to be had, the calling one answers.
        let cpu = pool.clone().map_or_else(pfront::Executor::sequential, |pool| {
            pfront::Executor::from(Traversal::with_pool(pool))
        });
        Self { process, pool, cpu, device: None }
    }
}

/// Nothing that is guarded here is left in pieces by a panic.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn is_hardware(gpu: &Gpu) -> bool {
    gpu.device().adapter_info().device_type != wgpu::DeviceType::Cpu
}

/// Name, kind and backend of the adapter that a GPU executor would use; empty if there is none.
#[pyfunction]
pub fn adapters(py: Python<'_>) -> Vec<(String, String, String)> {
    py.detach(|| {
        let info = Gpu::new().ok().map(|gpu| gpu.device().adapter_info());
        let named = |info: wgpu::AdapterInfo| {
            (info.name, format!("{:?}", info.device_type), format!("{:?}", info.backend))
        };
        info.map(named).into_iter().collect()
    })
}
