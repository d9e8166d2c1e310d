//! A radix sort of pairs of key and triangle on the device.
//!
//! Counting sort by one digit after another, the lowest first (Merrill & Grimshaw 2011): a workgroup
//! counts the digits of its run of entries, one scan turns all counts into places, and each workgroup
//! scatters its run. Three dispatches a digit and none that waits for another workgroup, which newer
//! sorts do (decoupled look-back) and WebGPU does not promise to end.

use crate::buffer::Usage;
use crate::layout::Build;
use crate::parameters::Parameters;
use crate::pass::Named;
use crate::sequence::Sequence;
use crate::{Gpu, GpuError};
use pfront_shaders::constants::{DIGITS, GROUP};
use wgpu::Buffer;

/// The fewest entries that are worth a workgroup.
const LEAST_RUN: u32 = 4 * GROUP;

/// Entries, and what it takes to sort them.
#[derive(Debug)]
pub(crate) struct Sort {
    /// The entries lie in the first of these, and in the other one after each digit.
    buffers: [Buffer; 2],
    table: Buffer,
    totals: Buffer,
    run: u32,
    workgroups: u32,
}

impl Sort {
    /// Takes 16 bytes an entry.
    pub(crate) fn new(gpu: &Gpu, entries: u32) -> Result<Self, GpuError> {
        let most = 2 * gpu.settings().groups;
        let run = entries.div_ceil(most).max(LEAST_RUN).next_multiple_of(GROUP);
        let workgroups = entries.div_ceil(run);
        let pairs = || gpu.buffer("the entries to sort", 8 * u64::from(entries), Usage::List);
        let counts = u64::from(DIGITS) * 4;
        Ok(Self {
            buffers: [pairs()?, pairs()?],
            table: gpu.buffer("the counts", counts * u64::from(workgroups), Usage::List)?,
            totals: gpu.buffer("the counts", counts, Usage::List)?,
            run,
            workgroups,
        })
    }

    /// Where the entries are after all that has been added.
    pub(crate) fn entries(&self) -> &Buffer {
        &self.buffers[0]
    }

    /// Adds a sort by the lowest bits of the keys to a sequence. With `keys`, more buffers, the pass of
    /// that name writes the keys and counts their first digit.
    pub(crate) fn add(
        &mut self,
        gpu: &Gpu,
        sequence: &mut Sequence,
        round: Build,
        bits: u32,
        keys: Option<Named<'_>>,
    ) -> Result<(), GpuError> {
        let Self { run, workgroups, .. } = *self;
        let digit = |digit| Build { run, workgroups, shift: digit * DIGITS.ilog2(), ..round };
        let digits: Vec<_> = (0..bits.div_ceil(DIGITS.ilog2())).map(digit).collect();
        let parameters = Parameters::new(gpu, "the digits of a sort", &digits)?;
        for index in 0..digits.len() {
            let own = || parameters.binding(index);
            let [from, to] = &self.buffers;
            let table = ("table", &self.table);
            match keys {
                Some(more) if index == 0 => {
                    let buffers = [&[("entries_out", from), table], more].concat();
                    sequence.add(gpu, |p| &p.keys, &buffers, own(), workgroups)?;
                }
                _ => {
                    let buffers = [("entries_in", from), table];
                    sequence.add(gpu, |p| &p.count, &buffers, own(), workgroups)?;
                }
            }
            let totals = ("totals", &self.totals);
            sequence.add(gpu, |p| &p.scan, &[table, totals], own(), DIGITS)?;
            let buffers = [("entries_in", from), ("entries_out", to), table, totals];
            sequence.add(gpu, |p| &p.scatter, &buffers, own(), workgroups)?;
            self.buffers.swap(0, 1);
        }
        Ok(())
    }
}
