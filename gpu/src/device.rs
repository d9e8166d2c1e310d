//! Calls of wgpu, with errors as values.

use crate::GpuError;
use std::panic::{AssertUnwindSafe, catch_unwind};
use wgpu::Device;

/// Makes calls of wgpu, and returns the error that they report, if any. Otherwise the handler of the device, which
/// is the caller's, would get them.
pub(crate) fn checked<T>(
    device: &Device,
    call: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let result = call();
    // The inner scope ends first.
    let validation = pollster::block_on(validation.pop());
    match (pollster::block_on(internal.pop()).or(validation), result) {
        (None, result) | (Some(_), result @ Err(GpuError::DeviceLost { .. })) => result,
        (Some(error), _) => Err(GpuError::Device { reason: error.to_string() }),
    }
}

/// Has wgpu look at what is done, and call back. Does not wait.
pub(crate) fn poll(device: &Device) -> Result<(), GpuError> {
    // wgpu panics where it finds that the device is lost.
    match catch_unwind(AssertUnwindSafe(|| device.poll(wgpu::PollType::Poll))) {
        Ok(Ok(_)) => Ok(()),
        Ok(Err(error)) => Err(GpuError::Device { reason: error.to_string() }),
        Err(_) => Err(GpuError::DeviceLost { reason: "it was lost while busy".to_owned() }),
    }
}
