//! The results of a run, brought to the host.

use crate::buffer::Usage;
use crate::device::release;
use crate::layout::{Counters, Rest};
use crate::lists::{Lists, ORDERED_AT};
use crate::memory::append;
use crate::model::Outside;
use crate::read::Mapping;
use crate::task::Order;
use crate::{Gpu, GpuError};
use pfront_core::bvtt::TrianglePair;
use pfront_shaders::constants::FEW;
use std::sync::atomic::AtomicBool;
use wgpu::{Buffer, CommandEncoder, MapMode};

/// A run that has been recorded.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) ticket: u32,
    /// The front after the last pass, which is empty if the run got to the bottom.
    pub(crate) last_front: u32,
    /// How many hits, and how many of the rest, are copied for the host.
    copied: [u32; 2],
    order: Order,
    /// Hits that are copied, of a run that counts no more.
    most_hits: u32,
    /// The vertices of each mesh of which the device tells whether one is outside of its box.
    vertices: [u32; 2],
    /// The buffer into which they are copied.
    read_back: Buffer,
}

/// The results of a run, as far as they were copied.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) counters: Counters,
    pub(crate) rest: Vec<Rest>,
    /// Whether the device has put all hits in order.
    pub(crate) in_order: bool,
}

/// The buffer in which results come to the host.
#[derive(Debug)]
pub(crate) struct ReadBack {
    gpu: Gpu,
    buffer: Buffer,
    /// If the host has begun to read.
    mapping: Option<Mapping>,
}

impl Run {
    /// Whether so many hits, and so many of the rest, are copied as far as there are any.
    pub(crate) fn copies_at_least(&self, [hits, rest]: [u32; 2]) -> bool {
        hits <= self.copied[0].min(self.most_hits) && rest <= self.copied[1]
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

impl ReadBack {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let buffer = gpu.buffer("the read-back", 4096, Usage::ReadBack)?;
        Ok(Self { gpu: gpu.clone(), buffer, mapping: None })
    }

    /// Whether the host has begun to read a run, and not read it to the end.
    pub(crate) fn is_pending(&self) -> bool {
        self.mapping.is_some()
    }

    /// Forgets a run that nobody has read to the end. It leaves a buffer that wgpu 30 may map once that run is done, even if
    /// it was unmapped and is to be mapped after a later one.
    pub(crate) fn forget(&mut self) -> Result<(), GpuError> {
        if self.mapping.take().is_some() {
            self.buffer = self.gpu.buffer("the read-back", self.buffer.size(), Usage::ReadBack)?;
        }
        Ok(())
    }

    /// Records that counters and results are copied for the host, after the last pass of the run of this ticket.
    pub(crate) fn copy(
        &mut self,
        encoder: &mut CommandEncoder,
        lists: &Lists,
        most: [u32; 2],
        order: Order,
        ticket: u32,
        last_front: u32,
    ) -> Result<Run, GpuError> {
        let capacities = &lists.capacities;
        let copied = [most[0].min(capacities.hits), most[1].min(capacities.rest)];
        let [hits_at, rest_at, outside_at, end] = offsets(copied);
        if self.buffer.size() < end {
            // Half as much again, so that answers that grow do not replace it each time.
            self.buffer = self.gpu.buffer("the read-back", end + end / 2, Usage::ReadBack)?;
        }
        let mut copy = |from: &Buffer, at: u64, bytes: u64| {
            if bytes != 0 {
                encoder.copy_buffer_to_buffer(from, 0, &self.buffer, at, bytes);
            }
        };
        let few = FEW.min(capacities.hits);
        if order == Order::Few {
            copy(&lists.counters, 0, rest_at);
        } else {
            copy(&lists.counters, 0, size_of::<Counters>() as u64);
            copy(&lists.hits, hits_at, rest_at - hits_at);
        }
        copy(&lists.rest, rest_at, outside_at - rest_at);
        if order == Order::Few {
            let bytes = u64::from(few) * size_of::<TrianglePair>() as u64;
            encoder.copy_buffer_to_buffer(&lists.counters, ORDERED_AT, &lists.hits, 0, bytes);
        }
        let most_hits = if order == Order::Few { few } else { u32::MAX };
        let (vertices, read_back) = ([0; 2], self.buffer.clone());
        Ok(Run { ticket, last_front, copied, order, most_hits, vertices, read_back })
    }

    /// Records that what the device tells about positions which the host has not seen is copied too.
    pub(crate) fn copy_outside(
        &self,
        encoder: &mut CommandEncoder,
        mut run: Run,
        outside: &[Option<Outside>; 2],
    ) -> Run {
        let [.., at, _] = offsets(run.copied);
        for (k, outside) in outside.iter().enumerate() {
            if let Some(Outside { buffer, vertices }) = outside {
                let at = at + (k * size_of::<u32>()) as u64;
                encoder.copy_buffer_to_buffer(buffer, 0, &run.read_back, at, 4);
                run.vertices[k] = *vertices;
            }
        }
        run
    }

    /// Whether a run is done, which must have been submitted.
    pub(crate) fn is_done(&mut self, run: &Run) -> Result<bool, GpuError> {
        let Self { gpu, mapping, .. } = self;
        let [.., end] = offsets(run.copied);
        let begin = || Mapping::begin(gpu.device(), &run.read_back, end, MapMode::Read);
        let done = mapping.get_or_insert_with(begin).is_done(gpu.device());
        done.map_err(|error| gpu.cause_of(error))
    }

    /// Waits for a run, and for nothing that was submitted later; adds the hits to `pairs`.
    pub(crate) async fn read(
        &mut self,
        run: &Run,
        pairs: &mut Vec<TrianglePair>,
        cancel: Option<&AtomicBool>,
    ) -> Result<Found, GpuError> {
        let [hits_at, rest_at, outside_at, end] = offsets(run.copied).map(|at| at as usize);
        let Self { gpu, mapping, .. } = self;
        gpu.settle().await?;
        let (device, bytes) = (gpu.device(), end as u64);
        let begin = || Mapping::begin(device, &run.read_back, bytes, MapMode::Read);
        let reading = mapping.get_or_insert_with(begin);
        let take = |bytes: &[u8]| {
            let counters = &bytes[..size_of::<Counters>()];
            let counters: Counters = bytemuck::pod_read_unaligned(counters);
            // Too many to be put in order are all copied later.
            let copied = if counters.hits <= run.most_hits { run.copied[0] } else { 0 };
            let hits = counters.hits.min(copied) as usize;
            let rest = (counters.rest as usize * size_of::<Rest>()).min(outside_at - rest_at);
            let copied = &bytes[hits_at..][..hits * size_of::<TrianglePair>()];
            append(pairs, copied)?;
            let in_order = match run.order {
                Order::None => false,
                Order::Few => counters.hits <= run.most_hits,
                Order::Many => counters.unordered == 0,
            };
            let rest = bytemuck::pod_collect_to_vec(&bytes[rest_at..][..rest]);
            let outside: [u32; 2] = bytemuck::pod_read_unaligned(&bytes[outside_at..]);
            let outside = run.outside(outside);
            Ok::<_, GpuError>((Found { counters, in_order, rest }, outside))
        };
        let found = reading.read(device, &run.read_back, bytes, cancel, take).await;
        if !matches!(found, Err(GpuError::Cancelled)) {
            // Else the next run takes another buffer, as it does where nobody awaits this to the end.
            *mapping = None;
        }
        gpu.check()?;
        let (found, outside): (Found, _) = found.map_err(|error| gpu.cause_of(error))??;
        if found.counters.ticket != run.ticket {
            return Err(GpuError::NotSubmitted);
        }
        outside.map_or(Ok(found), |vertex| Err(GpuError::OutsideBox { vertex }))
    }
}

impl Drop for ReadBack {
    fn drop(&mut self) {
        release([&self.buffer]);
    }
}

/// Where hits, the rest, and what is told about positions begin in the read-back buffer, and where that ends. Few hits in order are
/// as far from the counters on the device.
fn offsets([hits, rest]: [u32; 2]) -> [u64; 4] {
    let hits_at = ORDERED_AT;
    let rest_at = hits_at + u64::from(hits) * size_of::<TrianglePair>() as u64;
    let outside_at = rest_at + u64::from(rest) * size_of::<Rest>() as u64;
    [hits_at, rest_at, outside_at, outside_at + size_of::<[u32; 2]>() as u64]
}
