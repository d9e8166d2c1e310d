//! Bringing bytes back to the host.

use crate::GpuError;
use crate::gpu::checked;
use bytemuck::Pod;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::channel;
use std::time::Duration;
use wgpu::{Buffer, BufferUsages, CommandEncoder, Device, Queue, SubmissionIndex};

/// While a thread waits, wgpu lets no other thread present a surface, so waiting is cut into slices.
const SLICE: Duration = Duration::from_micros(100);

/// The time within which a thread that polls calls back.
const CALL_BACK: Duration = Duration::from_millis(10);

/// Waits for a submission, or for all of them so far, and hands over what a mapped buffer then holds.
pub(crate) fn map<T>(
    device: &Device,
    buffer: &Buffer,
    bytes: u64,
    submission: Option<SubmissionIndex>,
    take: impl FnOnce(&[u8]) -> T,
) -> Result<T, GpuError> {
    let failed = |reason: String| GpuError::Device { reason };
    let (tell, told) = channel();
    // What it reports is what the callback is told.
    let _ = checked(device, || {
        buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            // The receiver is gone only if polling failed.
            let _ = tell.send(result);
        });
        Ok(())
    });
    if poll(device, submission, None).is_err() {
        // A lost device has no such submission. Waiting for all of them calls back with what has happened.
        poll(device, None, None)?;
    }
    let told = match told.try_recv() {
        Ok(told) => Ok(told),
        // Another thread polled at the same time: it calls back. If it does not, the submission was an earlier one.
        Err(_) => match told.recv_timeout(CALL_BACK) {
            Ok(told) => Ok(told),
            Err(_) => poll(device, None, None).map(|_| told.recv())?,
        },
    };
    match told {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(GpuError::DeviceLost { reason: error.to_string() }),
        Err(error) => return Err(failed(error.to_string())),
    }
    let view = buffer.get_mapped_range(..bytes).map_err(|error| failed(error.to_string()))?;
    let taken = take(&view);
    drop(view);
    buffer.unmap();
    Ok(taken)
}

/// Waits for a submission, or for all of them so far; returns whether it was done in time.
pub(crate) fn poll(
    device: &Device,
    submission_index: Option<SubmissionIndex>,
    timeout: Option<Duration>,
) -> Result<bool, GpuError> {
    if submission_index.is_some() && timeout.is_none() {
        while !poll(device, submission_index.clone(), Some(SLICE))? {}
        return Ok(true);
    }
    let wait = wgpu::PollType::Wait { submission_index, timeout };
    // wgpu panics when the device is lost while somebody waits for it.
    match catch_unwind(AssertUnwindSafe(|| device.poll(wait))) {
        Ok(Ok(_)) => Ok(true),
        Ok(Err(wgpu::PollError::Timeout)) => Ok(false),
        Ok(Err(error)) => Err(GpuError::Device { reason: error.to_string() }),
        Err(_) => Err(GpuError::DeviceLost { reason: "it was lost while busy".to_owned() }),
    }
}

/// Whether a submission is done.
pub(crate) fn is_done(device: &Device, submission: &SubmissionIndex) -> Result<bool, GpuError> {
    poll(device, Some(submission.clone()), Some(Duration::ZERO))
}

/// Submits an encoder and reads the first `count` elements of a buffer after it, through a buffer made
/// for the purpose.
pub(crate) fn read_now<T: Pod>(
    device: &Device,
    queue: &Queue,
    mut encoder: CommandEncoder,
    buffer: &Buffer,
    count: usize,
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
    let submission = checked(device, || {
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
        Ok(queue.submit([encoder.finish()]))
    })?;
    map(device, &staging, bytes, Some(submission), |view| bytemuck::pod_collect_to_vec(view))
}
