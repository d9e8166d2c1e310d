//! Bringing bytes back to the host.

use crate::GpuError;
use crate::device::{checked, poll, release, scoped};
use crate::memory::append;
use bytemuck::Pod;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::Waker;
use wgpu::{
    Buffer, BufferAsyncError, BufferUsages, BufferView, CommandEncoder, Device, MapMode, Queue,
};

/// A buffer that is being mapped, which happens once all submissions that use it are done.
#[derive(Debug)]
pub(crate) struct Mapping {
    /// Never locked: a mutex is `Sync`, as queries have to be, and a receiver is not.
    told: Mutex<Receiver<Result<(), BufferAsyncError>>>,
    /// The task of a browser, where nothing can poll, that waits for it.
    #[cfg_attr(not(target_arch = "wasm32"), expect(dead_code, reason = "threads poll"))]
    waker: Arc<Mutex<Option<Waker>>>,
    is_done: bool,
}

impl Mapping {
    /// Begins to map the first bytes of a buffer. All submissions that use it must have been made.
    pub(crate) fn begin(device: &Device, buffer: &Buffer, bytes: u64, mode: MapMode) -> Self {
        let (tell, told) = channel();
        let waker = Arc::<Mutex<Option<Waker>>>::default();
        let waiting = waker.clone();
        // The callback is told any error.
        let _ = checked(device, || {
            buffer.map_async(mode, ..bytes, move |result| {
                // The receiver is gone only if nobody wants to know.
                let _ = tell.send(result);
                if let Some(waker) = waiting.lock().unwrap_or_else(PoisonError::into_inner).take() {
                    waker.wake();
                }
            });
            Ok(())
        });
        Self { told: Mutex::new(told), waker, is_done: false }
    }

    /// Whether it is mapped. Does not wait.
    pub(crate) fn is_done(&mut self, device: &Device) -> Result<bool, GpuError> {
        if self.is_done {
            return Ok(true);
        }
        poll(device)?;
        self.is_told()
    }

    /// Whether an earlier poll has found that it is mapped.
    pub(crate) fn is_told(&mut self) -> Result<bool, GpuError> {
        if self.is_done {
            return Ok(true);
        }
        match self.told.get_mut().unwrap_or_else(PoisonError::into_inner).try_recv() {
            Ok(Ok(())) => self.is_done = true,
            Ok(Err(error)) => return Err(GpuError::Map { reason: error.to_string() }),
            // Or another thread polls, and is about to call back.
            Err(TryRecvError::Empty) => {}
            Err(error) => return Err(GpuError::Device { reason: error.to_string() }),
        }
        Ok(self.is_done)
    }

    /// Waits until it is mapped, and hands over what the buffer holds, which is to be unmapped. [`GpuError::Cancelled`] once the
    /// flag is set: it may be waited for again.
    ///
    /// Natively the future is ready when it is first polled: it blocks.
    pub(crate) async fn view(
        &mut self,
        device: &Device,
        buffer: &Buffer,
        bytes: u64,
        cancel: Option<&AtomicBool>,
    ) -> Result<BufferView, GpuError> {
        self.wait(device, cancel).await?;
        let refused = |error: wgpu::MapRangeError| GpuError::Device { reason: error.to_string() };
        buffer.get_mapped_range(..bytes).map_err(refused)
    }

    /// The same, read by `take` and unmapped.
    pub(crate) async fn read<T>(
        &mut self,
        device: &Device,
        buffer: &Buffer,
        bytes: u64,
        cancel: Option<&AtomicBool>,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, GpuError> {
        let taken = take(&self.view(device, buffer, bytes, cancel).await?);
        buffer.unmap();
        Ok(taken)
    }

    /// It polls, since wgpu lets no other thread present a surface while one waits, and waiting with a time limit
    /// panics where several threads do (wgpu 30).
    #[cfg(not(target_arch = "wasm32"))]
    async fn wait(&mut self, device: &Device, cancel: Option<&AtomicBool>) -> Result<(), GpuError> {
        use std::time::{Duration, Instant};
        /// A thread that waits asks again after this part of the time that it has waited: it comes that much late at most, and
        /// keeps a core busy only for as long as no pause is long enough to sleep.
        const PAUSE: u32 = 16;
        /// The shortest pause in which a thread sleeps, about what waking takes.
        const SLEEP: Duration = Duration::from_micros(50);
        /// The longest pause: a thread that is to stop hears it within this time.
        const LONGEST_PAUSE: Duration = Duration::from_millis(5);
        let begin = Instant::now();
        while !self.is_done(device)? {
            if cancel.is_some_and(|flag| flag.load(std::sync::atomic::Ordering::Relaxed)) {
                return Err(GpuError::Cancelled);
            }
            let pause = (begin.elapsed() / PAUSE).min(LONGEST_PAUSE);
            if pause < SLEEP { std::thread::yield_now() } else { std::thread::sleep(pause) }
        }
        Ok(())
    }

    /// The browser calls back. Nothing can set the flag meanwhile but what runs between two calls of the page.
    #[cfg(target_arch = "wasm32")]
    async fn wait(&mut self, device: &Device, _: Option<&AtomicBool>) -> Result<(), GpuError> {
        use std::task::Poll;
        std::future::poll_fn(|context| {
            *self.waker.lock().unwrap_or_else(PoisonError::into_inner) =
                Some(context.waker().clone());
            match self.is_done(device) {
                Ok(false) => Poll::Pending,
                told => Poll::Ready(told.map(drop)),
            }
        })
        .await
    }
}

/// Submits an encoder and reads the first `count` elements of a buffer after it, through a buffer made
/// for the purpose.
pub(crate) async fn read_now<T: Pod>(
    device: &Device,
    queue: &Queue,
    mut encoder: CommandEncoder,
    buffer: &Buffer,
    count: usize,
    cancel: Option<&AtomicBool>,
) -> Result<Vec<T>, GpuError> {
    let bytes = (count * size_of::<T>()) as u64;
    if bytes == 0 {
        let submit = || {
            queue.submit([encoder.finish()]);
            Ok(Vec::new())
        };
        return scoped(device, submit).await;
    }
    let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read-back"),
        size: bytes,
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    if scope.pop().await.is_some() {
        return Err(GpuError::OutOfMemory { bytes });
    }
    let submit = || {
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
        queue.submit([encoder.finish()]);
        Ok(())
    };
    scoped(device, submit).await?;
    let mut mapping = Mapping::begin(device, &staging, bytes, MapMode::Read);
    let take = |bytes: &[u8]| {
        let mut list = Vec::new();
        append(&mut list, bytes).map(|()| list)
    };
    let list = mapping.read(device, &staging, bytes, cancel, take).await;
    release([&staging]);
    list?
}
