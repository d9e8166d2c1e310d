//! Calls of wgpu, with errors as values.

use crate::GpuError;
use std::panic::{AssertUnwindSafe, catch_unwind};
use wgpu::{Buffer, Device, ErrorFilter, ErrorScopeGuard};

/// Whether nothing may block, as in a browser, which tells errors later and has no buffers that stay mapped.
pub(crate) const WEB: bool = cfg!(target_arch = "wasm32");

/// Error scopes around calls of wgpu. Without them the handler of the device, which is the caller's, would get the errors.
pub(crate) struct Scopes {
    internal: ErrorScopeGuard,
    validation: ErrorScopeGuard,
}

impl Scopes {
    pub(crate) fn begin(device: &Device) -> Self {
        let internal = device.push_error_scope(ErrorFilter::Internal);
        Self { internal, validation: device.push_error_scope(ErrorFilter::Validation) }
    }

    /// The error that the calls report, if any: at once, but on the web.
    pub(crate) fn end(self) -> impl Future<Output = Option<GpuError>> + use<> {
        // The inner scope ends first, and both before anything is waited for.
        let (validation, internal) = (self.validation.pop(), self.internal.pop());
        async {
            let (validation, internal) = (validation.await, internal.await);
            let error = internal.or(validation)?;
            Some(GpuError::Device { reason: error.to_string() })
        }
    }
}

/// The result of calls, or the error that they reported.
pub(crate) fn outcome<T>(
    result: Result<T, GpuError>,
    error: Option<GpuError>,
) -> Result<T, GpuError> {
    match (error, result) {
        (None, result) | (Some(_), result @ Err(GpuError::DeviceLost { .. })) => result,
        (Some(error), _) => Err(error),
    }
}

/// Makes calls of wgpu, and returns the error that they report, if any.
pub(crate) async fn scoped<T>(
    device: &Device,
    call: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let scopes = Scopes::begin(device);
    let result = call();
    let error = scopes.end();
    outcome(result, error.await)
}

/// The same at once. On the web scopes further out report what is wrong: what an invalid object is part of is invalid too.
pub(crate) fn checked<T>(
    device: &Device,
    call: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    if WEB { call() } else { pollster::block_on(scoped(device, call)) }
}

/// Frees buffers that nothing will use any more, where a browser would do so some time after their last owner has gone.
pub(crate) fn release<'b>(buffers: impl IntoIterator<Item = &'b Buffer>) {
    if WEB {
        buffers.into_iter().for_each(Buffer::destroy);
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
