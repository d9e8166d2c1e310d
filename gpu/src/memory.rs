//! Buffers on the device, within its limits.

use crate::layout::Query;
use crate::{Error, Gpu};
use bytemuck::Pod;
use wgpu::BufferUsages;

/// What a buffer is for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Usage {
    /// Read by shaders, written by the host.
    Input,
    /// Written by shaders, read by either.
    List,
    /// Parameters.
    Uniform,
    /// Mapped by the host to read.
    ReadBack,
}

impl Gpu {
    /// A buffer of `bytes`, or of the smallest size that can be bound if that is more.
    pub(crate) fn buffer(
        &self,
        what: &'static str,
        bytes: u64,
        usage: Usage,
    ) -> Result<wgpu::Buffer, Error> {
        let size = bytes.next_multiple_of(4).max(size_of::<Query>() as u64);
        self.allocate(what, size, usage, |usage| {
            self.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some(what),
                size,
                usage,
                mapped_at_creation: false,
            })
        })
    }

    /// A buffer with contents.
    pub(crate) fn upload<T: Pod>(
        &self,
        what: &'static str,
        contents: &[T],
        usage: Usage,
    ) -> Result<wgpu::Buffer, Error> {
        let contents: &[u8] = bytemuck::cast_slice(contents);
        if contents.is_empty() {
            return self.buffer(what, 0, usage);
        }
        let size = contents.len() as u64;
        let buffer = self.allocate(what, size, usage, |usage| {
            self.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some(what),
                size,
                usage,
                mapped_at_creation: true,
            })
        })?;
        let mut view = buffer
            .get_mapped_range_mut(..)
            .map_err(|error| Error::Device { reason: error.to_string() })?;
        view.copy_from_slice(contents);
        drop(view);
        buffer.unmap();
        Ok(buffer)
    }

    fn allocate(
        &self,
        what: &'static str,
        bytes: u64,
        usage: Usage,
        create: impl FnOnce(BufferUsages) -> wgpu::Buffer,
    ) -> Result<wgpu::Buffer, Error> {
        let limits = self.device().limits();
        let (usage, available) = match usage {
            Usage::Input => (
                BufferUsages::STORAGE | BufferUsages::COPY_DST,
                limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            ),
            Usage::List => (
                BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
                limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            ),
            Usage::Uniform => {
                (BufferUsages::UNIFORM | BufferUsages::COPY_DST, limits.max_buffer_size)
            }
            Usage::ReadBack => {
                (BufferUsages::MAP_READ | BufferUsages::COPY_DST, limits.max_buffer_size)
            }
        };
        if bytes > available {
            return Err(Error::TooLarge { what, needed: bytes, available });
        }
        let scope = self.device().push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = create(usage);
        match pollster::block_on(scope.pop()) {
            Some(_) => Err(Error::OutOfMemory { bytes }),
            // A lost device gives buffers too, but no good ones.
            None => self.check().map(|()| buffer),
        }
    }
}
