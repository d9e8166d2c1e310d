//! Building a tree on the device.
//!
//! A linear BVH (Lauterbach et al. 2009) sorts the triangles once and splits runs of them where their keys
//! differ first, so that only the device knows the tree that comes of it. Here every node is halved
//! instead, at the median of its triangles. The shape of the tree then follows from their number: the
//! host can go on recording queries, nothing links nodes, and all passes read and write runs of memory.
//!
//! Near the root, a sort divides the nodes of a level into eight at once, each across its longest axis
//! (so, with more axes to choose from, are packed R-trees built: Leutenegger et al., "STR", 1997). As
//! soon as the triangles of a node fit, one workgroup halves them down to the leaves, choosing axes by
//! surface.

mod shape;
mod sort;
#[cfg(test)]
mod tests;

use crate::buffer::Usage;
use crate::layout::{Corner, Cut};
use crate::parameters::Parameters;
use crate::sequence::{Sequence, groups_for};
use crate::source::Source;
use crate::{Gpu, GpuError, GpuModel};
use pfront_core::bvh::BuildOptions;
use pfront_core::{Aabb, Node};
use pfront_shaders::constants::{CUT_BITS, LEAF};
use shape::Balanced;
use sort::Sort;
use std::sync::Arc;

/// A model with how it is built, as often as wanted, and how it is refitted.
#[derive(Debug)]
pub(crate) struct Built {
    pub(crate) model: GpuModel,
    pub(crate) build: Sequence,
    pub(crate) refit: Sequence,
}

/// The box tests that take about as long as a build: each of its passes visits all triangles.
pub(crate) fn price(triangles: usize, options: BuildOptions<'_>) -> u64 {
    let shape = Balanced::new(triangles as u32, options);
    triangles as u64 * u64::from(shape.map_or(0, Balanced::passes))
}

impl Built {
    /// Nothing is built yet. The model takes 52 bytes a triangle and 64 a leaf, the build 16 a triangle.
    pub(crate) fn new(
        gpu: &Gpu,
        source: &Source,
        bounds: &Aabb,
        options: BuildOptions,
    ) -> Result<Self, GpuError> {
        GpuModel::check_size(source.count)?;
        let shape = Balanced::new(source.count as u32, options);
        let model = model(gpu, shape, bounds)?;
        let (mut build, mut refit) = (Sequence::new(gpu)?, Sequence::new(gpu)?);
        if let Some(shape) = shape {
            arrange(gpu, source, shape, &model, &mut build)?;
            fit(gpu, source, shape, &model, &mut build)?;
            fit(gpu, source, shape, &model, &mut refit)?;
        }
        Ok(Self { model, build, refit })
    }
}

/// Adds what puts the triangles in order.
fn arrange(
    gpu: &Gpu,
    source: &Source,
    shape: Balanced,
    model: &GpuModel,
    sequence: &mut Sequence,
) -> Result<(), GpuError> {
    let mut sort = Sort::new(gpu, shape.triangles)?;
    let (rounds, blocks) = (shape.rounds(), shape.blocks());
    let nodes = rounds.last().map_or(0, |round| 1 << round.top);
    let cuts = gpu.buffer("the cuts", nodes * size_of::<Cut>() as u64, Usage::List)?;
    let Source { positions, triangles, .. } = source;
    let of_mesh = [("positions", positions), ("triangles", triangles), ("cuts", &cuts)];
    for round in rounds {
        let parameters = Parameters::new(gpu, "a round", &[round])?;
        let buffers = [&[("entries_in", sort.entries())], &of_mesh[..]].concat();
        let groups = groups_for(1 << round.top);
        sequence.add(gpu, |p| &p.survey, &buffers, parameters.binding(0), groups)?;
        sort.add(gpu, sequence, round, CUT_BITS + round.top, Some(&of_mesh))?;
    }
    let to_model =
        [("entries_in", sort.entries()), ("corners", &model.corners), ("order", &model.order)];
    let buffers = [&to_model[..], &of_mesh].concat();
    let parameters = Parameters::new(gpu, "the blocks", &[blocks])?;
    let groups = groups_for(1 << blocks.top);
    sequence.add(gpu, |p| &p.arrange, &buffers, parameters.binding(0), groups)
}

/// Adds what fits the boxes.
fn fit(
    gpu: &Gpu,
    source: &Source,
    shape: Balanced,
    model: &GpuModel,
    sequence: &mut Sequence,
) -> Result<(), GpuError> {
    let buffers =
        [("nodes", &model.nodes), ("corners", &model.corners), ("positions", &source.positions)];
    let stages = shape.stages();
    let parameters = Parameters::new(gpu, "the stages", &stages)?;
    for (index, stage) in stages.iter().enumerate() {
        let groups = groups_for(1 << stage.top);
        sequence.add(gpu, |p| &p.fit, &buffers, parameters.binding(index), groups)?;
    }
    Ok(())
}

/// A model whose tree is still to be built.
fn model(gpu: &Gpu, shape: Option<Balanced>, bounds: &Aabb) -> Result<GpuModel, GpuError> {
    let triangles = shape.map_or(0, |shape| shape.triangles);
    let buffer = |what, bytes: usize, count: u32| {
        gpu.buffer(what, bytes as u64 * u64::from(count), Usage::List)
    };
    let (level, seeds) = shape.map_or((0, 0..0), Balanced::seeds);
    let seeds: Vec<u32> = seeds.collect();
    let depth = shape.map_or(0, |shape| shape.depth);
    Ok(GpuModel {
        id: GpuModel::next_id(),
        device: gpu.id(),
        nodes: buffer("the nodes", size_of::<Node>(), shape.map_or(0, Balanced::nodes))?,
        corners: buffer("the triangles", size_of::<[Corner; 3]>(), triangles)?,
        order: buffer("the order of the triangles", size_of::<u32>(), triangles)?,
        seeds: gpu.upload("the seeds", &seeds, Usage::Input)?,
        seed_count: seeds.len() as u32,
        root: if depth == 0 { LEAF } else { 2 },
        depth,
        depth_below_seeds: depth - level,
        leaf_size: shape.map_or(1, Balanced::leaf_size),
        bounds: shape.map(|_| *bounds),
        is_shadow: false,
        outside: None,
        refit: None,
        wear: Arc::default(),
    })
}
