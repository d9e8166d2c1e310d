//! Staging buffers: mapped memory that the host writes and a submission copies.

use crate::buffer::Usage;
use crate::device::{WEB, release};
use crate::read::Mapping;
use crate::{Gpu, GpuError};
use wgpu::{Buffer, WriteOnly};

/// Buffers that are mapped again once the submissions that copy them are done: a new one for each submission takes longer
/// than to write it.
#[derive(Debug, Default)]
pub(crate) struct Staging {
    /// Written since the last submission.
    written: Vec<Buffer>,
    /// Submitted, and mapped again some time later; on the web, where the queue writes them in its order, at once.
    submitted: Vec<(Buffer, Option<Mapping>)>,
}

impl Staging {
    /// Forgets what has been written and was not submitted by [`Staging::submitted`]: its buffers are not used again.
    pub(crate) fn forget(&mut self) {
        self.written.clear();
    }

    /// A buffer whose first `bytes`, a multiple of 4, `fill` has written.
    pub(crate) fn write(
        &mut self,
        gpu: &Gpu,
        bytes: u64,
        fill: impl FnOnce(WriteOnly<'_, [u8]>),
    ) -> Result<Buffer, GpuError> {
        let buffer = self.take(gpu, bytes)?;
        self.write_into(gpu, buffer.clone(), bytes, fill)?;
        Ok(buffer)
    }

    /// Has the first `bytes` of a buffer written that was taken.
    pub(crate) fn write_into(
        &mut self,
        gpu: &Gpu,
        buffer: Buffer,
        bytes: u64,
        fill: impl FnOnce(WriteOnly<'_, [u8]>),
    ) -> Result<(), GpuError> {
        gpu.fill(&buffer, bytes, fill)?;
        self.written.push(buffer);
        Ok(())
    }

    /// A mapped buffer for so many bytes.
    pub(crate) fn take(&mut self, gpu: &Gpu, bytes: u64) -> Result<Buffer, GpuError> {
        let is_free = |(buffer, mapping): &mut (Buffer, Option<Mapping>)| {
            let is_mapped = |mapping: &mut Mapping| matches!(mapping.is_told(), Ok(true));
            buffer.size() >= bytes && mapping.as_mut().is_none_or(is_mapped)
        };
        match self.submitted.iter_mut().position(is_free) {
            Some(at) => Ok(self.submitted.swap_remove(at).0),
            None => {
                // Buffers that are too small would never be used again.
                self.submitted.retain(|(buffer, _)| buffer.size() >= bytes);
                gpu.mapped_buffer("the staging buffer", bytes, Usage::Staging)
            }
        }
    }

    /// Has what was written mapped again, after its submission.
    pub(crate) fn submitted(&mut self, gpu: &Gpu) {
        self.submitted.extend(self.written.drain(..).map(|buffer| {
            let begin =
                || Mapping::begin(gpu.device(), &buffer, buffer.size(), wgpu::MapMode::Write);
            let mapping = (!WEB).then(begin);
            (buffer, mapping)
        }));
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        release(self.submitted.iter().map(|(buffer, _)| buffer));
    }
}
