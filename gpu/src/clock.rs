//! Device time of each pass, by timestamps.

use crate::GpuError;
use crate::buffer::Usage;
use crate::gpu::{Gpu, TIMESTAMPS};
use crate::read::Mapping;
use std::time::Duration;
use wgpu::{
    Buffer, BufferUsages, CommandEncoder, ComputePass, ComputePassTimestampWrites, QuerySet,
};

/// Timestamps of a run.
const MOST: u32 = 128;

/// The name of all passes together.
const ALL: &str = "all";

/// How long one pass took on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Timing {
    /// Its entry point; "all" for all passes together.
    pub pass: &'static str,
    /// From the end of the pass before it to its own end.
    pub time: Duration,
}

#[derive(Debug)]
pub(crate) struct Clock {
    set: QuerySet,
    resolved: Buffer,
    read_back: Buffer,
    /// Whether each pass is timed, which makes it wait for the one before.
    each: bool,
    /// The pass that ended at each timestamp but the first.
    marks: Vec<&'static str>,
    /// Nanoseconds of a tick.
    period: f32,
}

impl Clock {
    /// A clock for each pass, or for all of them together. `None` if the device cannot keep time.
    pub(crate) fn new(gpu: &Gpu, each: bool) -> Result<Option<Self>, GpuError> {
        let device = gpu.device();
        if !device.features().contains(TIMESTAMPS) {
            return Ok(None);
        }
        let bytes = u64::from(MOST * wgpu::QUERY_SIZE);
        gpu.checked(|| {
            Ok(Some(Self {
                set: device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("timestamps"),
                    ty: wgpu::QueryType::Timestamp,
                    count: MOST,
                }),
                resolved: device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("timestamps"),
                    size: bytes,
                    usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                }),
                read_back: gpu.buffer("the timestamps", bytes, Usage::ReadBack)?,
                each,
                marks: Vec::new(),
                period: gpu.queue().get_timestamp_period(),
            }))
        })
    }

    /// Before the first pass of a run: where the timestamps of the whole run go.
    pub(crate) fn start(&mut self) -> Option<ComputePassTimestampWrites<'_>> {
        self.marks.clear();
        if !self.each {
            self.marks.push(ALL);
        }
        (!self.each).then_some(ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        })
    }

    /// Before the first pass of a run, and after each.
    pub(crate) fn mark(&mut self, compute: &mut ComputePass<'_>, pass: Option<&'static str>) {
        let index = self.marks.len() as u32 + u32::from(pass.is_some());
        if self.each && index < MOST {
            compute.write_timestamp(&self.set, index);
            self.marks.extend(pass);
        }
    }

    /// After the last pass of a run.
    pub(crate) fn finish(&self, encoder: &mut CommandEncoder) {
        let count = self.marks.len() as u32 + 1;
        encoder.resolve_query_set(&self.set, 0..count, &self.resolved, 0);
        let bytes = u64::from(count * wgpu::QUERY_SIZE);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read_back, 0, bytes);
    }

    /// No run is the last one.
    pub(crate) fn forget(&mut self) {
        self.marks.clear();
    }

    /// The times of the last run, which has been submitted; none without a clock. There is none on the web, where nothing may block.
    pub(crate) fn read(clock: Option<&Self>, gpu: &Gpu) -> Result<Vec<Timing>, GpuError> {
        let Some(Self { marks, read_back, period, .. }) = clock else { return Ok(Vec::new()) };
        if marks.is_empty() {
            return Ok(Vec::new());
        }
        let bytes = (marks.len() as u64 + 1) * u64::from(wgpu::QUERY_SIZE);
        let mut mapping = Mapping::begin(gpu.device(), read_back, bytes, wgpu::MapMode::Read);
        let take = bytemuck::pod_collect_to_vec;
        let ticks = mapping.read(gpu.device(), read_back, bytes, None, take);
        let ticks: Vec<u64> = pollster::block_on(ticks)?;
        let time = |pair: &[u64]| {
            let nanoseconds = pair[1].saturating_sub(pair[0]) as f64 * f64::from(*period);
            Duration::from_nanos(nanoseconds as u64)
        };
        let times = ticks.windows(2).map(time);
        Ok(marks.iter().zip(times).map(|(&pass, time)| Timing { pass, time }).collect())
    }
}
