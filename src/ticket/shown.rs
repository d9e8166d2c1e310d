//! Lists of a GPU whose buffers a ticket shows.

use crate::executor::{Device, Hidden};
use crate::gpu::{GpuQuery, wgpu};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The lists of a single question, whose buffers its ticket shows. They go back to the device when this is dropped.
#[derive(Debug)]
pub(crate) struct Shown {
    pub(crate) device: Arc<Device>,
    /// The buffers of hits and counters.
    pub(crate) buffers: [wgpu::Buffer; 2],
    /// Once they are read.
    pub(crate) lists: Mutex<Option<GpuQuery>>,
}

/// The lists of a ticket, if it shows some.
#[derive(Debug, Default)]
pub(crate) struct ShownLists(OnceLock<Hidden<Shown>>);

impl ShownLists {
    /// Shows buffers of a GPU, until the ticket and its outcome are dropped.
    pub(crate) fn show(&self, shown: Shown) {
        let _ = self.0.set(Hidden::new(shown));
    }

    /// The buffers of hits and counters, if they are shown.
    pub(crate) fn buffers(&self) -> Option<&[wgpu::Buffer; 2]> {
        self.0.get().map(|shown| &shown.buffers)
    }

    /// Keeps the lists whose buffers are shown; else returns them.
    pub(crate) fn keep(&self, lists: GpuQuery) -> Option<GpuQuery> {
        let Some(shown) = self.0.get() else { return Some(lists) };
        let mut own = shown.lists.lock().unwrap_or_else(PoisonError::into_inner);
        match &*own {
            Some(_) => Some(lists),
            None => own.replace(lists),
        }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.device.hide();
        let lists = self.lists.get_mut().unwrap_or_else(PoisonError::into_inner);
        self.device.take_back(lists.take());
    }
}
