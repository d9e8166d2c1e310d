//! The results of a run, brought to the host.

use crate::buffer::Usage;
use crate::device::release;
use crate::layout::{Counters, Rest};
use crate::lists::Lists;
use crate::memory::append;
use crate::model::Outside;
use crate::read::Mapping;
use crate::task::Order;
use crate::{Gpu, GpuError};
use pfront_core::bvtt::TrianglePair;
use pfront_shaders::constants::FEW;
use std::ops::Range;
use std::sync::atomic::AtomicBool;
use wgpu::{
    BindGroup, BindingResource, Buffer, BufferBinding, BufferSize, BufferView, CommandEncoder,
    MapMode,
};

/// A run that has been recorded.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) ticket: u32,
    /// The front after the last pass, which is empty if the run got to the bottom.
    pub(crate) last_front: u32,
    /// How many hits, and how many of the rest, come to the host.
    brought: [u32; 2],
    order: Order,
    /// The vertices of each mesh of which the device tells whether one is outside of its box.
    vertices: [u32; 2],
    /// The buffer in which they come.
    read_back: Buffer,
    /// Where the hits begin in it.
    hits_at: u64,
}

/// The results of a run, as far as they were brought.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) counters: Counters,
    pub(crate) rest: Vec<Rest>,
    /// Whether the device has put all hits in order.
    pub(crate) in_order: bool,
    /// `None` once they are unmapped.
    pub(crate) hits: Option<MappedHits>,
}

/// The hits of a run where the host has mapped them: until it is dropped, before the next run is submitted.
#[derive(Debug)]
pub(crate) struct MappedHits {
    view: BufferView,
    bytes: Range<usize>,
    /// Dropped after the view.
    _mapped: Mapped,
}

/// A mapped buffer, which is unmapped at the end.
#[derive(Debug)]
struct Mapped(Gpu, Buffer);

impl Drop for Mapped {
    fn drop(&mut self) {
        // If the device was lost since, there is nothing to unmap.
        let _ = self.0.checked(|| {
            self.1.unmap();
            Ok(())
        });
    }
}

impl MappedHits {
    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.bytes.len() / size_of::<TrianglePair>()
    }

    /// The hits, if they are aligned as the host needs it: nothing says how mapped memory is.
    pub(crate) fn list(&self) -> Option<&[TrianglePair]> {
        bytemuck::try_cast_slice(&self.view[self.bytes.clone()]).ok()
    }

    /// Adds them to a list.
    pub(crate) fn copy(&self, pairs: &mut Vec<TrianglePair>) -> Result<(), GpuError> {
        append(pairs, &self.view[self.bytes.clone()])
    }
}

/// How results come to the host.
#[derive(Debug)]
pub(crate) struct ReadBack {
    gpu: Gpu,
    pub(crate) buffers: ReadBackBuffers,
    /// If the host has begun to read.
    mapping: Option<Mapping>,
    /// The hits of the last answer, if they are shown where they are mapped.
    pub(crate) shown: Option<MappedHits>,
}

/// The buffers in which results come to the host.
#[derive(Debug)]
pub(crate) struct ReadBackBuffers {
    /// Written by the last pass.
    results: Buffer,
    /// A copy for the host, where it cannot map `results`.
    copy: Option<Buffer>,
    /// How many hits, and how many of the rest, there is room for.
    room: [u32; 2],
    /// The bind group of `results`, for the passes that may be the last.
    pub(crate) group: BindGroup,
}

impl Run {
    /// Whether so many hits, and so many of the rest, come to the host, as far as there are any, and hits in order.
    pub(crate) fn brings_at_least(&self, [hits, rest]: [u32; 2]) -> bool {
        let is_ordered = self.order != Order::Few || hits <= FEW;
        is_ordered && hits <= self.brought[0] && rest <= self.brought[1]
    }

    /// The bytes of the read-back buffer that the host reads.
    fn bytes(&self) -> u64 {
        self.hits_at + u64::from(self.brought[0]) * size_of::<TrianglePair>() as u64
    }

    /// The results by what the host has mapped, and the first vertex outside of its box.
    fn found(&self, gpu: &Gpu, view: BufferView) -> Result<(Found, Option<u32>), GpuError> {
        let mapped = Mapped(gpu.clone(), self.read_back.clone());
        let hits_at = self.hits_at as usize;
        let mut hits = MappedHits { view, bytes: hits_at..hits_at, _mapped: mapped };
        let bytes: &[u8] = &hits.view;
        let counters: Counters = bytemuck::pod_read_unaligned(&bytes[..size_of::<Counters>()]);
        let found = counters.rest.min(self.brought[1]) as usize * size_of::<Rest>();
        let mut rest = Vec::new();
        append(&mut rest, &bytes[REST_AT as usize..][..found])?;
        let told = &bytes[OUTSIDE_AT as usize..][..size_of::<[u32; 2]>()];
        let outside = self.outside(bytemuck::pod_read_unaligned(told));
        let found = counters.hits.min(self.brought[0]) as usize * size_of::<TrianglePair>();
        hits.bytes.end += found;
        let in_order = counters.unordered == 0;
        Ok((Found { counters, rest, in_order, hits: Some(hits) }, outside))
    }

    /// The first vertex outside of its box by what the device told, if it was asked.
    fn outside(&self, told: [u32; 2]) -> Option<u32> {
        let vertices = self.vertices.iter().zip(told);
        let mut outside = vertices.filter_map(|(&vertices, told)| match told {
            1.. => vertices.checked_sub(told),
            0 => None,
        });
        outside.next()
    }
}

impl ReadBackBuffers {
    fn new(gpu: &Gpu, room: [u32; 2]) -> Result<Self, GpuError> {
        let hits_at = hits_at(room[1]);
        let bytes = hits_at + u64::from(room[0].max(1)) * size_of::<TrianglePair>() as u64;
        let results = gpu.buffer("the results", bytes, Usage::Results)?;
        let copy = || gpu.buffer("the read-back", bytes, Usage::ReadBack);
        let copy = (!gpu.is_mapped()).then(copy).transpose()?;
        let part = |offset, size| {
            let (buffer, size) = (&results, BufferSize::new(size));
            Some(BindingResource::Buffer(BufferBinding { buffer, offset, size }))
        };
        // `bring` and `settle` have the same layout.
        let group = gpu.passes().order.bind(gpu.device(), 2, |name| match name {
            "read_back" => part(0, hits_at),
            "read_back_hits" => part(hits_at, bytes - hits_at),
            _ => None,
        })?;
        Ok(Self { results, copy, room, group })
    }
}

impl ReadBack {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let buffers = ReadBackBuffers::new(gpu, [FEW, 64])?;
        Ok(Self { gpu: gpu.clone(), buffers, mapping: None, shown: None })
    }

    /// Whether the host has begun to read a run, and not read it to the end.
    pub(crate) fn is_pending(&self) -> bool {
        self.mapping.is_some()
    }

    /// Forgets a run that nobody has read to the end. It leaves a buffer that wgpu 30 may map once that run is done, even if
    /// it was unmapped and is to be mapped after a later one.
    pub(crate) fn forget(&mut self) -> Result<(), GpuError> {
        self.shown = None;
        if self.mapping.take().is_some() {
            self.buffers = ReadBackBuffers::new(&self.gpu, self.buffers.room)?;
        }
        Ok(())
    }

    /// Has room for so many hits, and so many of the rest, of the run that is recorded next, as far as lists can hold them.
    pub(crate) fn make_room(&mut self, lists: &Lists, most: [u32; 2]) -> Result<(), GpuError> {
        let capacities = [lists.capacities.hits, lists.capacities.rest];
        let now = self.buffers.room;
        let is_enough = [0, 1].map(|k| now[k] >= most[k].min(capacities[k]));
        if is_enough != [true; 2] {
            // Half as much again, so that answers that grow do not replace it each time.
            let roomy = |k: usize| most[k].saturating_add(most[k] / 2).min(capacities[k]);
            let room = [0, 1].map(|k| if is_enough[k] { now[k] } else { roomy(k) });
            self.buffers = ReadBackBuffers::new(&self.gpu, room)?;
        }
        Ok(())
    }

    /// Records that counters and results come to the host, after the last pass of the run of this ticket: by a copy, unless
    /// that pass has written them where the host can map them.
    pub(crate) fn bring(
        &self,
        encoder: &mut CommandEncoder,
        most: [u32; 2],
        order: Order,
        ticket: u32,
        last_front: u32,
    ) -> Run {
        let ReadBackBuffers { results, copy, room, .. } = &self.buffers;
        let most = if copy.is_some() { most } else { *room };
        let [hits, rest] = [0, 1].map(|k| most[k].min(room[k]));
        let brought = [hits.min(order.most()), rest];
        let (vertices, hits_at) = ([0; 2], hits_at(room[1]));
        let read_back = copy.as_ref().unwrap_or(results).clone();
        let run = Run { ticket, last_front, brought, order, vertices, read_back, hits_at };
        if let Some(copy) = copy {
            encoder.copy_buffer_to_buffer(results, 0, copy, 0, run.bytes());
        }
        run
    }

    /// Records that what the device tells about positions which the host has not seen is copied too.
    pub(crate) fn copy_outside(
        &self,
        encoder: &mut CommandEncoder,
        mut run: Run,
        outside: &[Option<Outside>; 2],
    ) -> Run {
        for (k, outside) in outside.iter().enumerate() {
            if let Some(Outside { buffer, vertices }) = outside {
                let at = OUTSIDE_AT + (k * size_of::<u32>()) as u64;
                encoder.copy_buffer_to_buffer(buffer, 0, &run.read_back, at, 4);
                run.vertices[k] = *vertices;
            }
        }
        run
    }

    /// Whether a run is done, which must have been submitted.
    pub(crate) fn is_done(&mut self, run: &Run) -> Result<bool, GpuError> {
        let Self { gpu, mapping, .. } = self;
        let begin = || Mapping::begin(gpu.device(), &run.read_back, run.bytes(), MapMode::Read);
        let done = mapping.get_or_insert_with(begin).is_done(gpu.device());
        done.map_err(|error| gpu.cause_of(error))
    }

    /// Waits for a run, and for nothing that was submitted later.
    pub(crate) async fn read(
        &mut self,
        run: &Run,
        cancel: Option<&AtomicBool>,
    ) -> Result<Found, GpuError> {
        let Self { gpu, mapping, .. } = self;
        gpu.settle().await?;
        let (device, bytes) = (gpu.device(), run.bytes());
        let begin = || Mapping::begin(device, &run.read_back, bytes, MapMode::Read);
        let reading = mapping.get_or_insert_with(begin);
        let view = reading.view(device, &run.read_back, bytes, cancel).await;
        let found = view.and_then(|view| run.found(gpu, view));
        if !matches!(found, Err(GpuError::Cancelled)) {
            // Else the next run takes another buffer, as it does where nobody awaits this to the end.
            *mapping = None;
        }
        gpu.check()?;
        let (found, outside) = found.map_err(|error| gpu.cause_of(error))?;
        if found.counters.ticket != run.ticket {
            return Err(GpuError::NotSubmitted);
        }
        outside.map_or(Ok(found), |vertex| Err(GpuError::OutsideBox { vertex }))
    }
}

impl Drop for ReadBack {
    fn drop(&mut self) {
        let ReadBackBuffers { results, copy, .. } = &self.buffers;
        release(copy.iter().chain([results]));
    }
}

/// Where what is told about positions begins in the read-back buffer.
const OUTSIDE_AT: u64 = size_of::<Counters>() as u64;

/// Where the rest begins in it.
pub(crate) const REST_AT: u64 = (OUTSIDE_AT + size_of::<[u32; 2]>() as u64).next_multiple_of(16);

/// Where hits begin in it, if it has room for so many of the rest: bindings begin at multiples of 256.
fn hits_at(rest: u32) -> u64 {
    (REST_AT + u64::from(rest.max(1)) * size_of::<Rest>() as u64).next_multiple_of(256)
}
