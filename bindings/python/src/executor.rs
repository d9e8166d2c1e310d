//! The threads and devices that answer, made once for each process.

use crate::errors::device;
use crate::lock::lock;
use crate::threads::{apart, heard, heard_as};
use pfront::executor::{Backend, Plan, Reason};
use pfront::gpu::{Gpu, wgpu};
use pfront::threads::Pool;
use pfront::threads::rayon::{ThreadPool, ThreadPoolBuilder};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::{mem, process};

/// The id of the next executor.
static NEXT: AtomicU64 = AtomicU64::new(0);
/// The process that has looked for a GPU first, or 0: its children have no driver.
static DRIVEN: AtomicU32 = AtomicU32::new(0);

/// Devices that answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Device {
    Cpu,
    Gpu,
    Auto,
}

/// The threads and executors that a process has made.
#[derive(Clone)]
pub(crate) struct Made {
    process: u32,
    /// The threads, if there are several.
    pub(crate) pool: Option<Arc<ThreadPool>>,
    pub(crate) cpu: pfront::Executor,
    /// The executor of the device asked for.
    device: Option<pfront::Executor>,
    /// The number of [`PoolUse`]s.
    uses: Arc<AtomicUsize>,
}

/// Work in the pool that may take longer than signals may wait; it ends when this is dropped.
pub(crate) struct PoolUse(Arc<AtomicUsize>);

impl Drop for PoolUse {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Relaxed);
    }
}

/// Threads and a device. A process that was forked makes its own threads: those of its parent are not there.
#[pyclass(frozen, module = "pfront._pfront")]
pub struct Executor {
    pub(crate) threads: usize,
    pub(crate) device: Device,
    made: Mutex<Option<Made>>,
    /// Tells this executor from all others of the process.
    pub(crate) id: u64,
    /// Who gave the last answer, in words.
    answered: Mutex<String>,
}

#[pymethods]
impl Executor {
    #[new]
    fn new(threads: i64, device: Option<&str>) -> PyResult<Self> {
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
        let (threads, id) = (threads as usize, NEXT.fetch_add(1, Relaxed));
        let answered = Mutex::new("nothing was asked yet".into());
        Ok(Self { threads, device, made: Mutex::new(None), id, answered })
    }

    /// Opens the device, if one is asked for.
    fn open(&self, py: Python<'_>) -> PyResult<()> {
        match self.device {
            Device::Cpu => Ok(()),
            Device::Gpu | Device::Auto => self.on_device(py).map(drop),
        }
    }

    /// Who gave the last answer, in words.
    fn explain(&self) -> String {
        lock(&self.answered).clone()
    }
}

impl Executor {
    /// Notes who has answered; one thread, if there is no plan.
    pub(crate) fn note(&self, plan: Option<&Plan>) {
        let mut words = match plan {
            None => Backend::Sequential.to_string(),
            // There was nothing to choose.
            Some(Plan { backend, reason: Reason::NoChoice, .. }) => backend.to_string(),
            Some(plan) => plan.to_string().replace("f64", "float64"),
        };
        if plan.is_some_and(|plan| plan.backend == Backend::Threads) {
            words = format!("{} {words}", self.threads);
        }
        *lock(&self.answered) = words;
    }

    /// Notes who has answered where there was nothing to choose.
    pub(crate) fn note_backend(&self, backend: Backend) {
        *lock(&self.answered) = match backend {
            Backend::Threads => format!("{} {backend}", self.threads),
            _ => backend.to_string(),
        };
    }

    /// The executor of questions that are submitted: "auto" knows nothing of earlier frames there, and is the CPU.
    pub(crate) fn for_batches(&self, py: Python<'_>) -> PyResult<pfront::Executor> {
        match self.device {
            Device::Gpu => self.on_device(py),
            Device::Cpu | Device::Auto => Ok(self.made(py).cpu),
        }
    }

    /// The threads and executors of this process, made if they are not there.
    pub(crate) fn made(&self, py: Python<'_>) -> Made {
        let process = process::id();
        if let Some(made) = lock(&self.made).as_ref().filter(|made| made.process == process) {
            return made.clone();
        }
        let new = apart(py, || Made::new(self.threads, process));
        self.keep(new)
    }

    /// The device of this process, opened if it is not.
    pub(crate) fn on_device(&self, py: Python<'_>) -> PyResult<pfront::Executor> {
        let made = self.made(py);
        if self.device == Device::Cpu {
            return Ok(made.cpu);
        }
        if let Some(device) = made.device {
            return Ok(device);
        }
        driver()?;
        let (cpu, own) = (made.cpu.clone(), self.device);
        let open = move || open(cpu, own);
        let opened = heard_as(py, "pfront device", &Arc::default(), open)?.map_err(device)?;
        let kept = self.keep(Made { device: Some(opened.clone()), ..made });
        Ok(kept.device.unwrap_or(opened))
    }

    /// Keeps what was made, unless another thread of this process has kept the same meanwhile. Returns what is kept.
    fn keep(&self, new: Made) -> Made {
        let mut made = lock(&self.made);
        match &mut *made {
            Some(kept) if kept.process == new.process => {
                kept.device = kept.device.take().or(new.device);
                kept.clone()
            }
            other => {
                // Executors that a parent has made are left as they are: to drop them would wait for its threads.
                mem::forget(other.take());
                other.insert(new).clone()
            }
        }
    }
}

impl Drop for Executor {
    fn drop(&mut self) {
        let made = lock(&self.made).take();
        if made.as_ref().is_some_and(|made| made.process != process::id()) {
            mem::forget(made);
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
            pfront::Executor::from(Pool::from(pool))
        });
        Self { process, pool, cpu, device: None, uses: Arc::default() }
    }

    /// Begins work in the pool.
    pub(crate) fn use_pool(&self) -> PoolUse {
        self.uses.fetch_add(1, Relaxed);
        PoolUse(self.uses.clone())
    }

    /// Whether threads of the pool may be at work on something long: what is put into the pool then may wait for its end.
    pub(crate) fn is_busy(&self) -> bool {
        self.pool.is_some() && self.uses.load(Relaxed) > 0
    }

    /// Leaves work in the pool to itself, which ends after every thread has ended what it is at.
    pub(crate) fn leave(&self, work: PoolUse) {
        if let Some(pool) = &self.pool {
            pool.spawn_broadcast(move |_| {
                let _ = &work;
            });
        }
    }
}

fn open(cpu: pfront::Executor, device: Device) -> Result<pfront::Executor, String> {
    match (Gpu::new(), device) {
        (Ok(gpu), Device::Gpu) => Ok(cpu.behind_gpu(&gpu, gpu.settings())),
        (Ok(gpu), _) if is_hardware(&gpu) => {
            cpu.and_gpu(&gpu, gpu.settings()).map_err(|error| error.to_string())
        }
        (Err(error), Device::Gpu) => Err(error.to_string()),
        _ => Ok(cpu),
    }
}

/// Says that this process needs a driver.
///
/// # Errors
/// A DeviceError in a child of a process that had one.
fn driver() -> PyResult<()> {
    let own = process::id();
    match DRIVEN.compare_exchange(0, own, Relaxed, Relaxed) {
        Err(first) if first != own => Err(device(
            "no GPU can be used here: this process was forked from one that has used its driver. Start processes by \
             multiprocessing's \"spawn\" or \"forkserver\", or ask threads, by pf.using(device=None)"
                .into(),
        )),
        _ => Ok(()),
    }
}

fn is_hardware(gpu: &Gpu) -> bool {
    gpu.device().adapter_info().device_type != wgpu::DeviceType::Cpu
}

/// Name, kind and backend of the adapter that a GPU executor would use; empty if there is none.
#[pyfunction]
pub fn adapters(py: Python<'_>) -> PyResult<Vec<(String, String, String)>> {
    driver()?;
    heard(py, &Arc::default(), || {
        let info = Gpu::new().ok().map(|gpu| gpu.device().adapter_info());
        let named = |info: wgpu::AdapterInfo| {
            (info.name, format!("{:?}", info.device_type), format!("{:?}", info.backend))
        };
        info.map(named).into_iter().collect()
    })
}
