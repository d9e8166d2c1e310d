//! Parameters that never change, one set for each dispatch of a sequence.

use crate::buffer::Usage;
use crate::{Gpu, GpuError};
use bytemuck::Pod;
use std::marker::PhantomData;
use wgpu::{BindingResource, Buffer, BufferBinding, BufferSize};

/// Sets lie this far apart, as uniform bindings must.
const STRIDE: usize = 256;

/// Sets of type `T`.
#[derive(Debug)]
pub(crate) struct Parameters<T> {
    buffer: Buffer,
    sets: PhantomData<T>,
}

impl<T: Pod> Parameters<T> {
    pub(crate) fn new(gpu: &Gpu, what: &'static str, sets: &[T]) -> Result<Self, GpuError> {
        const { assert!(size_of::<T>() <= STRIDE) };
        let mut bytes = vec![0; sets.len() * STRIDE];
        for (slot, set) in bytes.chunks_exact_mut(STRIDE).zip(sets) {
            slot[..size_of::<T>()].copy_from_slice(bytemuck::bytes_of(set));
        }
        Ok(Self { buffer: gpu.upload(what, &bytes, Usage::Uniform)?, sets: PhantomData })
    }

    /// One of the sets.
    pub(crate) fn binding(&self, index: usize) -> BindingResource<'_> {
        BindingResource::Buffer(BufferBinding {
            buffer: &self.buffer,
            offset: (index * STRIDE) as u64,
            size: BufferSize::new(size_of::<T>() as u64),
        })
    }
}
