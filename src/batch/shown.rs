//! Lists of a GPU whose buffers a ticket shows.

use crate::executor::Device;
use crate::gpu::{GpuQuery, wgpu};
use std::sync::{Arc, Mutex, PoisonError};

/// The lists of a single question, whose buffers its ticket shows. They go back to the device when this is dropped.
#[derive(Debug)]
pub(super) struct Shown {
    pub(super) device: Arc<Device>,
    /// The buffers of hits and counters.
    pub(super) buffers: [wgpu::Buffer; 2],
    /// Once they are read.
    pub(super) lists: Mutex<Option<GpuQuery>>,
}

impl Shown {
    /// Keeps the lists, unless some are kept already.
    pub(super) fn keep(&self, lists: GpuQuery) -> Option<GpuQuery> {
        let mut own = self.lists.lock().unwrap_or_else(PoisonError::into_inner);
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
