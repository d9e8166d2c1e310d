//! The task of a run: its verb, its subject, and what it starts from.

use crate::layout::{Counters, Query};
use bytemuck::Zeroable;
use pfront_shaders::constants::{FEW, GROUP, LEAF};
use std::mem::offset_of;

/// The verbs of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GpuVerb {
    /// Every pair.
    All,
    /// One pair, if there is any.
    Any,
    /// How many pairs.
    Count,
    /// One pair for each pair of bodies, if there is any.
    AnyEach,
    /// How many pairs for each pair of bodies.
    CountEach,
}

/// A node pair as fronts hold it.
pub(crate) type Entry = [u32; 2];

/// A question about the models that are bound. The engine fills in the capacities.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task {
    pub(crate) query: Query,
    /// The root of the BVTT.
    pub(crate) root: Entry,
    /// Levels of the BVTT.
    pub(crate) levels: u32,
    /// The same below the seeds.
    pub(crate) levels_below_seeds: u32,
}

/// Where a run starts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Start<'a> {
    /// All pairs of seeds.
    Seeds,
    /// These node pairs.
    Front(&'a [Entry]),
    /// The front of this index, left over by a run that counted this. Its results stay.
    Left(u32, &'a Counters),
}

impl<'a> Start<'a> {
    /// The node pairs that are brought to the device.
    pub(crate) fn front(self) -> &'a [Entry] {
        match self {
            Start::Front(front) => front,
            Start::Seeds | Start::Left(..) => &[],
        }
    }

    pub(crate) fn counters(self) -> Counters {
        let mut counters = Counters::zeroed();
        match self {
            Start::Seeds => {}
            Start::Front(front) => counters.fronts[0] = front.len() as u32,
            Start::Left(front, before) => {
                counters.fronts[front as usize % 2] = before.fronts[front as usize];
                (counters.hits, counters.rest) = (before.hits, before.rest);
            }
        }
        counters
    }

    /// Whether a run along a narrow beam goes first. It lists leaf pairs that the whole run lists again, so that none goes before
    /// leaf pairs alone: lists have room for the results of one leaf pair at least, but not twice.
    pub(crate) fn looks_ahead(self, verb: GpuVerb) -> bool {
        let leads_on = match self {
            Start::Seeds => true,
            Start::Front(front) => front.as_flattened().iter().any(|node| node & LEAF == 0),
            Start::Left(..) => false,
        };
        verb == GpuVerb::Any && leads_on
    }

    /// The byte of the counters up to which they are those of the last run.
    pub(crate) const KEPT: usize = offset_of!(Counters, leaves);

    /// The byte of the counters up to which they are those of the run before; of the run along the beam, if that goes first.
    pub(crate) fn kept(self, verb: GpuVerb) -> usize {
        if self.looks_ahead(verb) { offset_of!(Counters, overflow) } else { Self::KEPT }
    }
}

/// The passes that put hits in order, if any, and write the results for the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// One pass, which brings so many hits as they are.
    None { hits: u32 },
    /// One pass, which leaves more than [`FEW`] as they are.
    Few,
    /// As many as there may be.
    Many,
}

impl Order {
    /// The passes that suit so many hits, if all of these are wanted.
    pub(crate) fn new(verb: GpuVerb, hits: u32) -> Self {
        match verb {
            GpuVerb::All if hits <= FEW => Self::Few,
            GpuVerb::All => Self::Many,
            GpuVerb::Any | GpuVerb::Count | GpuVerb::AnyEach | GpuVerb::CountEach => {
                Self::None { hits: hits.min(65_535 * GROUP) }
            }
        }
    }

    /// The most hits that they bring.
    pub(crate) fn most(self) -> u32 {
        match self {
            Self::None { hits } => hits,
            Self::Few | Self::Many => u32::MAX,
        }
    }
}
