//! In what order the boxes of a tree are refitted on the device.
//!
//! A box waits for those of its children. One dispatch for each level would spend its time on launches,
//! and waiting for other workgroups is not to be had in WebGPU. So a workgroup gets a job: a subtree small
//! enough for it to fit alone, level by level. When all jobs of a stage are done, the nodes above
//! them are a tree some hundred times smaller, and make the jobs of the next stage: two or three stages
//! refit millions of triangles.

use crate::buffer::Usage;
use crate::layout::Stage;
use crate::parameters::Parameters;
use crate::sequence::{Sequence, groups_for};
use crate::{Gpu, GpuError};
use pfront_core::Node;
use pfront_shaders::constants::{EARLIER, GROUP, JOB};
use std::ops::Range;
use wgpu::Buffer;

/// Nodes by stage, job and round.
#[derive(Debug, Default)]
pub(crate) struct Schedule {
    /// Each node with the slots of its children in the job, 16 bits each; [`EARLIER`] if a child was
    /// fitted in an earlier stage.
    nodes: Vec<[u32; 2]>,
    /// Where each round begins in `nodes`, and the end of the last.
    rounds: Vec<u32>,
    /// Where each job begins in `rounds`, and the end of the last.
    jobs: Vec<u32>,
    /// The jobs of each stage.
    stages: Vec<Range<u32>>,
}

impl Schedule {
    /// # Complexity
    /// O(nodes) for each stage.
    pub(crate) fn new(tree: &[Node]) -> Self {
        let mut schedule = Self::default();
        let mut done = vec![false; tree.len()];
        let mut slots = vec![EARLIER; tree.len()];
        while done.first() == Some(&false) {
            let first = schedule.jobs.len() as u32;
            schedule.add_stage(tree, &mut done, &mut slots);
            schedule.stages.push(first..schedule.jobs.len() as u32);
        }
        schedule.jobs.push(schedule.rounds.len() as u32);
        schedule.rounds.push(schedule.nodes.len() as u32);
        schedule
    }

    /// The dispatches that refit a mesh by it, whose nodes begin with this one of the buffer.
    pub(crate) fn sequence(
        &self,
        gpu: &Gpu,
        [nodes, corners]: [&Buffer; 2],
        first_node: u32,
        positions: &Buffer,
    ) -> Result<Sequence, GpuError> {
        let mut sequence = Sequence::new(gpu)?;
        let entries = self.nodes.iter().map(|&[node, slots]| [node + first_node, slots]);
        let entries: Vec<_> = entries.collect();
        let buffers = [
            ("nodes", nodes),
            ("corners", corners),
            ("positions", positions),
            ("schedule", &gpu.upload("the schedule", &entries, Usage::Input)?),
            ("rounds", &gpu.upload("the rounds", &self.rounds, Usage::Input)?),
            ("jobs", &gpu.upload("the jobs", &self.jobs, Usage::Input)?),
        ];
        let stage = |jobs: &Range<u32>| Stage { first_job: jobs.start, end_job: jobs.end };
        let stages: Vec<_> = self.stages.iter().map(stage).collect();
        let parameters = Parameters::new(gpu, "the stages", &stages)?;
        for (index, jobs) in self.stages.iter().enumerate() {
            let groups = groups_for(jobs.len() as u32);
            sequence.add(gpu, |p| &p.refit, &buffers, parameters.binding(index), groups)?;
        }
        Ok(sequence)
    }

    /// Bytes of device memory that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        let words = 2 * self.nodes.len() + self.rounds.len() + self.jobs.len();
        (words * size_of::<u32>()) as u64
    }

    /// Adds every largest subtree of at most [`JOB`] nodes that are not yet done.
    fn add_stage(&mut self, tree: &[Node], done: &mut [bool], slots: &mut [u32]) {
        // How many nodes a subtree has, and how many rounds from its leaves it takes to fit it.
        let mut subtrees = vec![(0, 0); tree.len()];
        // Children come after their parents.
        for (index, node) in tree.iter().enumerate().rev().filter(|&(index, _)| !done[index]) {
            let left = node.first as usize;
            subtrees[index] = (1, 1);
            if !node.is_leaf() {
                let ((a, low), (b, high)) = (subtrees[left], subtrees[left + 1]);
                subtrees[index] = (1 + a + b, 1 + u32::max(low, high));
            }
        }
        let (mut job, mut size) = (Vec::new(), 0);
        let mut waiting = vec![0];
        while let Some(index) = waiting.pop() {
            let node = &tree[index as usize];
            match subtrees[index as usize] {
                (0, _) => {}
                (nodes @ 1..=JOB, _) => {
                    // Small ones share a job, most of whose invocations they would leave idle.
                    if size + nodes > GROUP && size != 0 {
                        self.add_job(tree, std::mem::take(&mut job), &subtrees, done, slots);
                        size = 0;
                    }
                    job.push(index);
                    size += nodes;
                }
                _ => waiting.extend([node.first, node.first + 1]),
            }
        }
        if size != 0 {
            self.add_job(tree, job, &subtrees, done, slots);
        }
    }

    /// Adds subtrees, all leaves of them first: what takes longest has the most invocations. `slots` is
    /// [`EARLIER`] for every node, and is so again afterwards.
    fn add_job(
        &mut self,
        tree: &[Node],
        roots: Vec<u32>,
        subtrees: &[(u32, u32)],
        done: &mut [bool],
        slots: &mut [u32],
    ) {
        self.jobs.push(self.rounds.len() as u32);
        let mut nodes = vec![];
        let mut waiting = roots;
        while let Some(index) = waiting.pop() {
            let node = &tree[index as usize];
            let children = if node.is_leaf() { 0..0 } else { node.first..node.first + 2 };
            waiting.extend(children.filter(|&child| !done[child as usize]));
            nodes.push(index);
        }
        let round = |index: u32| subtrees[index as usize].1;
        nodes.sort_unstable_by_key(|&index| (round(index), index));
        (0..).zip(&nodes).for_each(|(slot, &index)| slots[index as usize] = slot);
        let entry = |&index: &u32| match &tree[index as usize] {
            leaf if leaf.is_leaf() => [index, EARLIER | (EARLIER << 16)],
            inner => {
                let left = inner.first as usize;
                [index, slots[left] | (slots[left + 1] << 16)]
            }
        };
        for nodes in nodes.chunk_by(|&a, &b| round(a) == round(b)) {
            self.rounds.push(self.nodes.len() as u32);
            nodes.iter().for_each(|&index| done[index as usize] = true);
            self.nodes.extend(nodes.iter().map(entry));
        }
        nodes.iter().for_each(|&index| slots[index as usize] = EARLIER);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tree of n leaves whose left children are leaves with the given chance in 8.
    fn tree(n: u32, skew: u32) -> Vec<Node> {
        let mut tree = vec![Node::EMPTY; 2];
        let mut waiting = vec![(0, 0, n)];
        while let Some((index, first, count)) = waiting.pop() {
            if count == 1 {
                tree[index as usize] = Node { first, count, ..Node::EMPTY };
                continue;
            }
            let left = if first % 8 < skew { 1 } else { count / 2 };
            let children = tree.len() as u32;
            tree[index as usize].first = children;
            tree.extend([Node::EMPTY; 2]);
            waiting.extend([(children, first, left), (children + 1, first + left, count - left)]);
        }
        tree
    }

    #[test]
    fn every_node_is_scheduled_once_and_after_its_children() {
        for (n, skew) in [(1, 0), (2, 0), (300, 4), (5_000, 0), (5_000, 3), (40_000, 5)] {
            check(&tree(n, skew), 2 * n - 1);
        }
    }

    fn check(tree: &[Node], count: u32) {
        let Schedule { nodes, rounds, jobs, stages } = Schedule::new(tree);
        assert_eq!(nodes.len() as u32, count);
        // When a node is done, and its slot: stages follow one another, as do rounds of a job.
        let mut when = vec![None; tree.len()];
        let mut kept = vec![[EARLIER; 2]; tree.len()];
        for (stage, range) in stages.iter().enumerate() {
            for job in range.clone() {
                let of_job = jobs[job as usize]..jobs[job as usize + 1];
                let [start, end] = [of_job.start, of_job.end].map(|r| rounds[r as usize]);
                assert!(end - start <= JOB);
                for round in of_job {
                    for i in rounds[round as usize]..rounds[round as usize + 1] {
                        let [index, children] = nodes[i as usize];
                        let old = when[index as usize].replace((stage, job, round, i - start));
                        assert_eq!(old, None);
                        kept[index as usize] = [children & 0xffff, children >> 16];
                    }
                }
            }
        }
        for (index, node) in tree.iter().enumerate().filter(|(_, node)| !node.is_leaf()) {
            // The second slot of a tree is not used.
            let Some((stage, job, round, _)) = when[index] else { continue };
            for (child, slot) in (node.first..).zip(kept[index]) {
                let (s, j, r, at) = when[child as usize].unwrap();
                assert!(s < stage || (s == stage && j == job && r < round));
                assert_eq!(slot, if s < stage { EARLIER } else { at });
            }
        }
        assert!(stages.len() <= 4, "{} stages", stages.len());
    }

    #[test]
    fn nothing_needs_no_stage() {
        assert!(Schedule::new(&[]).stages.is_empty());
    }
}
