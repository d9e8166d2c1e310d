//! Errors of calls of wgpu: told at once natively, and later by a browser.

use crate::GpuError;

/// Errors that calls may have reported, and that are still to be told: none natively.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Debug, Default)]
pub(crate) struct Untold;

#[cfg(not(target_arch = "wasm32"))]
impl Untold {
    /// The error, if it is told already.
    pub(crate) fn add(&self, error: impl Future<Output = Option<GpuError>>) -> Option<GpuError> {
        pollster::block_on(error)
    }

    /// Waits until all are told, and returns the first.
    pub(crate) async fn first(&self) -> Result<(), GpuError> {
        Ok(())
    }
}

/// Errors that calls may have reported, and that are still to be told.
#[cfg(target_arch = "wasm32")]
#[derive(Default)]
pub(crate) struct Untold(std::cell::RefCell<Vec<std::pin::Pin<Box<Telling>>>>);

#[cfg(target_arch = "wasm32")]
type Telling = dyn Future<Output = Option<GpuError>>;

#[cfg(target_arch = "wasm32")]
impl Untold {
    /// The error, if it is told already.
    pub(crate) fn add(
        &self,
        error: impl Future<Output = Option<GpuError>> + 'static,
    ) -> Option<GpuError> {
        self.0.borrow_mut().push(Box::pin(error));
        None
    }

    /// Waits until all are told, and returns the first.
    pub(crate) async fn first(&self) -> Result<(), GpuError> {
        let mut first = Ok(());
        for error in self.0.take() {
            first = first.and(error.await.map_or(Ok(()), Err));
        }
        first
    }
}

#[cfg(target_arch = "wasm32")]
impl std::fmt::Debug for Untold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Untold({})", self.0.borrow().len())
    }
}
