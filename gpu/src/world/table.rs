//! Bodies and pairs of a world on the device.

use super::arena::Arena;
use crate::buffer::Usage;
use crate::gpu::Instances;
use crate::groups::Dispatches;
use crate::layout::{Body, InstancePair, Row};
use crate::pass::Pass;
use crate::runner::Runner;
use crate::{Gpu, GpuError, GpuModel};
use pfront_shaders::constants::GROUP;
use std::ops::Range;
use std::sync::Arc;
use wgpu::{BindGroup, Buffer, CommandEncoder};

/// The pass that makes rows for the others, and what it reads and writes.
#[derive(Debug)]
pub(super) struct Table {
    passes: Arc<Instances>,
    /// If they know all bodies but those that have moved since.
    pub(super) buffers: Option<Buffers>,
}

/// Buffers that are made together.
#[derive(Debug)]
pub(super) struct Buffers {
    id: u64,
    bodies: Buffer,
    rows: Buffer,
    /// Written by `pose`.
    pub(super) pairs: Buffer,
    tallies: Buffer,
    /// The bind group of `pose`.
    group: BindGroup,
}

impl Buffers {
    fn new(gpu: &Gpu, pose: &Pass, bodies: usize, rows: &[Row]) -> Result<Self, GpuError> {
        let buffer =
            |what, count: usize, size: usize, usage| gpu.buffer(what, (count * size) as u64, usage);
        let bodies = buffer("the bodies", bodies, size_of::<Body>(), Usage::Input)?;
        let pairs = buffer("the pairs", rows.len(), size_of::<InstancePair>(), Usage::List)?;
        let tallies = buffer("the tallies", Self::pairs(rows), size_of::<u32>(), Usage::List)?;
        let rows = buffer("the rows", rows.len(), size_of::<Row>(), Usage::Input)?;
        let buffers = [("bodies", &bodies), ("rows", &rows), ("pairs", &pairs)];
        let group = pose.bind_buffers(gpu.device(), 0, &buffers)?;
        Ok(Self { id: GpuModel::next_id(), bodies, rows, pairs, tallies, group })
    }

    /// How many pairs these rows are of, with those before them of which nothing is asked.
    fn pairs(rows: &[Row]) -> usize {
        rows.last().map_or(0, |last| last.number as usize + 1)
    }

    fn has_room(&self, bodies: usize, rows: &[Row]) -> bool {
        let has_room = |buffer: &Buffer, count: usize, size| buffer.size() >= (count * size) as u64;
        has_room(&self.bodies, bodies, size_of::<Body>())
            && has_room(&self.pairs, rows.len(), size_of::<InstancePair>())
            && has_room(&self.tallies, Self::pairs(rows), size_of::<u32>())
    }
}

impl Table {
    pub(super) fn new(passes: Arc<Instances>) -> Self {
        Self { passes, buffers: None }
    }

    /// Records that the rows of a run are written, and bodies as far as they have moved or buffers are others, and what `pose` makes of
    /// both. Binds all buffers. After an error nothing is known of what is there.
    pub(super) fn write(
        &mut self,
        runner: &mut Runner,
        arena: &Arena,
        encoder: &mut CommandEncoder,
        moved: Range<usize>,
    ) -> Result<(), GpuError> {
        let Runner { engine, bodies, rows, .. } = runner;
        let (pose, old) = (&self.passes.pose, self.buffers.take());
        let (own, moved) = match old.filter(|own| own.has_room(bodies.len(), rows)) {
            Some(own) => (own, moved),
            None => (Buffers::new(&engine.gpu, pose, bodies.len(), rows)?, 0..bodies.len()),
        };
        let at = (moved.start * size_of::<Body>()) as u64;
        let writes = [
            (&own.rows, 0, bytemuck::cast_slice(rows)),
            (&own.bodies, at, bytemuck::cast_slice(&bodies[moved])),
        ];
        engine.write(encoder, &writes)?;
        let groups = (rows.len() as u32).div_ceil(GROUP);
        Dispatches::begin(encoder, None).add(pose, &[&own.group], groups);
        let Arena { nodes, corners, order, .. } = arena;
        if let (Some(nodes), Some(corners), Some(order)) =
            (nodes.buffer(), corners.buffer(), order.buffer())
        {
            let buffers = [
                ("nodes_a", nodes),
                ("corners_a", corners),
                ("order_a", order),
                ("pairs", &own.pairs),
                ("tallies", &own.tallies),
            ];
            engine.bind_buffers([arena.id, own.id], &buffers)?;
        }
        engine.tallies = Some(own.tallies.clone());
        self.buffers = Some(own);
        Ok(())
    }

    /// Bytes of device memory.
    pub(super) fn bytes(&self) -> u64 {
        let size = |Buffers { bodies, rows, pairs, tallies, .. }: &Buffers| {
            [bodies, rows, pairs, tallies].map(Buffer::size).iter().sum()
        };
        self.buffers.as_ref().map_or(0, size)
    }
}
