//! Bringing bytes back to the host.

use crate::GpuError;
use crate::device::{checked, poll};
use crate::memory::append;
use bytemuck::Pod;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use wgpu::{Buffer, BufferAsyncError, BufferUsages, CommandEncoder, Device, MapMode, Queue};

/// A thread that waits asks again after this part of the time that it has waited: it comes that much late at most, and keeps a
/// core busy only for as long as no pause is long enough to sleep.
const PAUSE: u32 = 16;

/// The shortest pause in which a thread sleeps, about what waking takes.
const SLEEP: Duration = Duration::from_micros(50);

/// The longest pause: a thread that is to stop hears it within this time.
const LONGEST_PAUSE: Duration = Duration::from_millis(5);

/// A buffer that is being mapped, which happens once all submissions that use it are done.
#[derive(Debug)]
pub(crate) struct Mapping {
    /// Never locked: a mutex is `Sync`, as queries have to be, and a receiver is not.
    told: Mutex<Receiver<Result<(), BufferAsyncError>>>,
    is_done: bool,
}

impl Mapping {
    /// Begins to map the first bytes of a buffer. All submissions that use it must have been made.
    pub(crate) fn begin(device: &Device, buffer: &Buffer, bytes: u64, mode: MapMode) -> Self {
        let (tell, told) = channel();
        // The callback is told any error.
        let _ = checked(device, || {
            buffer.map_async(mode, ..bytes, move |result| {
                // The receiver is gone only if nobody wants to know.
                let _ = tell.send(result);
            });
            Ok(())
        });
        Self { told: Mutex::new(told), is_done: false }
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

    /// Waits until it is mapped, and hands over what the buffer holds. [`GpuError::Cancelled`] once the flag is set: it may be
    /// waited for again.
    ///
    /// It polls, since wgpu lets no other thread present a surface while one waits, and waiting with a time limit
    /// panics where several threads do (wgpu 30).
    pub(crate) fn read<T>(
        &mut self,
        device: &Device,
        buffer: &Buffer,
        bytes: u64,
        cancel: Option<&AtomicBool>,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, GpuError> {
        let begin = Instant::now();
        while !self.is_done(device)? {
            if cancel.is_some_and(|flag| flag.load(Relaxed)) {
                return Err(GpuError::Cancelled);
            }
            let pause = (begin.elapsed() / PAUSE).min(LONGEST_PAUSE);
            if pause < SLEEP { std::thread::yield_now() } else { std::thread::sleep(pause) }
        }
        let view = buffer
            .get_mapped_range(..bytes)
            .map_err(|error| GpuError::Device { reason: error.to_string() })?;
        let taken = take(&view);
        drop(view);
        buffer.unmap();
        Ok(taken)
    }
}

/// Submits an encoder and reads the first `count` elements of a buffer after it, through a buffer made
/// for the purpose.
pub(crate) fn read_now<T: Pod>(
    device: &Device,
    queue: &Queue,
    mut encoder: CommandEncoder,
    buffer: &Buffer,
    count: usize,
    cancel: Option<&AtomicBool>,
) -> Result<Vec<T>, GpuError> {
    let bytes = (count * size_of::<T>()) as u64;
    if bytes == 0 {
        return checked(device, || {
            queue.submit([encoder.finish()]);
            Ok(Vec::new())
        });
    }
    let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read-back"),
        size: bytes,
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    if pollster::block_on(scope.pop()).is_some() {
        return Err(GpuError::OutOfMemory { bytes });
    }
    checked(device, || {
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
        queue.submit([encoder.finish()]);
        Ok(())
    })?;
    let mut mapping = Mapping::begin(device, &staging, bytes, MapMode::Read);
    mapping.read(device, &staging, bytes, cancel, |bytes| {
        let mut list = Vec::new();
        append(&mut list, bytes).map(|()| list)
    })?
}
