//! Buffers on the device, within its limits.

use crate::device::{WEB, poll};
use crate::layout::Query;
use crate::memory::reserve;
use crate::{Gpu, GpuError};
use bytemuck::Pod;
use wgpu::{BufferUsages, WriteOnly};

/// The uses of a buffer.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Usage {
    /// Read by shaders, written by the host.
    Input,
    /// Written by shaders, read by either.
    List,
    /// Parameters.
    Uniform,
    /// Mapped by the host to read, and written by copies.
    ReadBack,
    /// Written by shaders, and mapped by the host to read where the adapter can.
    Results,
    /// Mapped by the host to write, and copied into other buffers, or where the adapter can, read by shaders.
    Staging,
}

impl Gpu {
    /// A buffer of `bytes`, or of the smallest size that can be bound if that is more.
    pub(crate) fn buffer(
        &self,
        what: &'static str,
        bytes: u64,
        usage: Usage,
    ) -> Result<wgpu::Buffer, GpuError> {
        let size = bytes.next_multiple_of(4).max(size_of::<Query>() as u64);
        self.allocate(what, size, usage, false)
    }

    /// A buffer with contents.
    pub(crate) fn upload<T: Pod>(
        &self,
        what: &'static str,
        contents: &[T],
        usage: Usage,
    ) -> Result<wgpu::Buffer, GpuError> {
        let contents: &[u8] = bytemuck::cast_slice(contents);
        if contents.is_empty() {
            return self.buffer(what, 0, usage);
        }
        self.checked(|| self.upload_bytes(what, contents, usage))
    }

    fn upload_bytes(
        &self,
        what: &'static str,
        contents: &[u8],
        usage: Usage,
    ) -> Result<wgpu::Buffer, GpuError> {
        let buffer = self.mapped_buffer(what, contents.len() as u64, usage)?;
        self.fill(&buffer, contents.len() as u64, |mut view| view.copy_from_slice(contents))?;
        Ok(buffer)
    }

    /// A buffer for [`Gpu::fill`].
    pub(crate) fn mapped_buffer(
        &self,
        what: &'static str,
        bytes: u64,
        usage: Usage,
    ) -> Result<wgpu::Buffer, GpuError> {
        self.allocate(what, bytes, usage, !WEB)
    }

    /// Has the first bytes of a mapped buffer written, and unmaps it. On the web the queue writes them, since wgpu panics where a
    /// browser has no memory to map.
    pub(crate) fn fill(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        fill: impl FnOnce(WriteOnly<'_, [u8]>),
    ) -> Result<(), GpuError> {
        if WEB {
            let mut contents = Vec::new();
            reserve(&mut contents, bytes as usize)?;
            contents.resize(bytes as usize, 0);
            fill(WriteOnly::from_mut(&mut contents[..]));
            self.queue().write_buffer(buffer, 0, &contents);
            return Ok(());
        }
        let mut view = buffer.get_mapped_range_mut(..bytes).map_err(|error| {
            // A lost device gives buffers without memory, and says that it is lost when it is polled.
            let reason = error.to_string();
            let lost = poll(self.device()).and_then(|()| self.check());
            lost.err().unwrap_or(GpuError::Device { reason })
        })?;
        fill(view.slice(..));
        drop(view);
        buffer.unmap();
        Ok(())
    }

    fn allocate(
        &self,
        what: &'static str,
        size: u64,
        usage: Usage,
        mapped_at_creation: bool,
    ) -> Result<wgpu::Buffer, GpuError> {
        let own = match usage {
            Usage::Input => BufferUsages::STORAGE | BufferUsages::COPY_DST,
            Usage::List => BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
            Usage::Results if self.is_mapped() => {
                BufferUsages::STORAGE | BufferUsages::MAP_READ | BufferUsages::COPY_DST
            }
            Usage::Results => BufferUsages::STORAGE | BufferUsages::COPY_SRC,
            Usage::Uniform => BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            Usage::ReadBack => BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            Usage::Staging if WEB => BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
            Usage::Staging if self.is_mapped() => {
                BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC | BufferUsages::UNIFORM
            }
            Usage::Staging => BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC,
        };
        let limits = self.device().limits();
        let bound = match usage {
            Usage::Input | Usage::List | Usage::Results => limits.max_storage_buffer_binding_size,
            Usage::Uniform | Usage::ReadBack | Usage::Staging => u64::MAX,
        };
        let available = limits.max_buffer_size.min(bound);
        if size > available {
            return Err(GpuError::TooLarge { what, needed: size, available });
        }
        let scope = self.device().push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = self.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size,
            usage: own,
            mapped_at_creation,
        });
        let told = scope.pop();
        let error = async move { told.await.map(|_| GpuError::OutOfMemory { bytes: size }) };
        match self.untold().add(error) {
            Some(error) => Err(error),
            // A lost device gives buffers too, but no good ones.
            None => self.check().map(|()| buffer),
        }
    }
}
