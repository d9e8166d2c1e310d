//! A refit: positions of a mesh that moves are brought to the device, and the boxes of its tree fitted to them.
//!
//! Its commands do not depend on positions. So those of the next refit are recorded where the host would only wait: while the device
//! works on a question that was asked after this one.

use crate::clock::Clock;
use crate::sequence::Sequence;
use crate::staging::Staging;
use crate::{Gpu, GpuError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::{Buffer, CommandBuffer, CommandEncoder};

/// A refit by the same dispatches to positions from one place, whose commands are recorded again for each frame.
#[derive(Debug)]
pub(crate) struct Refit {
    gpu: Gpu,
    origin: Origin,
    /// The dispatches, in order.
    sequences: Vec<Arc<Sequence>>,
    next: Mutex<Next>,
}

/// Where positions come from.
#[derive(Debug)]
pub(crate) enum Origin {
    /// A staging buffer, of which so many bytes, which are some, are copied to this one.
    Host(Buffer, u64),
    /// A buffer of the caller's, which the first dispatch reads. It needs this buffer at 0.
    Device(Buffer),
}

/// The memory and the commands of the next time.
#[derive(Debug, Default)]
pub(crate) struct Next {
    pub(crate) staging: Staging,
    ahead: Option<Recorded>,
}

/// Commands that have not been submitted, with a mapped buffer for positions from the host.
pub(crate) type Recorded = (CommandBuffer, Option<Buffer>);

impl Refit {
    pub(crate) fn new(gpu: &Gpu, origin: Origin, sequences: Vec<Arc<Sequence>>) -> Arc<Self> {
        Arc::new(Self { gpu: gpu.clone(), origin, sequences, next: Mutex::default() })
    }

    /// Nothing panics under this lock.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Next> {
        self.next.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records it, with a buffer that holds positions if they come from the host, and the times of its last dispatches if those are
    /// wanted.
    pub(crate) fn record(
        &self,
        encoder: &mut CommandEncoder,
        source: Option<&Buffer>,
        clock: Option<&mut Clock>,
    ) {
        match (&self.origin, source) {
            (Origin::Host(positions, bytes), Some(source)) => {
                encoder.copy_buffer_to_buffer(source, 0, positions, 0, *bytes);
            }
            (Origin::Host(..), None) => {}
            (Origin::Device(outside), _) => encoder.clear_buffer(outside, 0, None),
        }
        if let Some((last, first)) = self.sequences.split_last() {
            first.iter().for_each(|sequence| sequence.run(encoder, None));
            last.run(encoder, clock);
        }
    }

    /// The commands that were recorded ahead, or such as are recorded now.
    pub(crate) fn take(&self) -> Result<Recorded, GpuError> {
        let mut next = self.lock();
        next.staging.forget();
        match next.ahead.take() {
            Some(recorded) => Ok(recorded),
            None => self.record_alone(&mut next.staging),
        }
    }

    fn record_alone(&self, staging: &mut Staging) -> Result<Recorded, GpuError> {
        let source = match self.origin {
            Origin::Host(_, bytes) => Some(staging.take(&self.gpu, bytes)?),
            Origin::Device(_) => None,
        };
        let mut encoder = self.gpu.device().create_command_encoder(&Default::default());
        self.record(&mut encoder, source.as_ref(), None);
        Ok((encoder.finish(), source))
    }

    /// Submits commands, and has what they copy from mapped again.
    pub(crate) fn submit(&self, commands: CommandBuffer) -> Result<(), GpuError> {
        self.gpu.queue().submit([commands]);
        self.lock().staging.submitted(&self.gpu);
        self.gpu.check()
    }

    /// Records the next commands, if they are not there. Without memory for them, they are recorded when they are due.
    pub(crate) fn record_ahead(&self) {
        let mut next = self.lock();
        if next.ahead.is_none() {
            let Next { staging, ahead } = &mut *next;
            *ahead = self.gpu.checked(|| self.record_alone(staging)).ok();
        }
    }
}
