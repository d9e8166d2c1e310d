//! The scene of the firmware: two meshes of 1,000 triangles, one moving through the other, in 34 KiB.
//!
//! One BVH is built in Morton order, the other borrowed from flash. Each frame then goes as [`pfront_core::front`] describes, for two
//! workers one after the other, and pairs come in pages. Last, one more frame is asked in steps.

#![no_std]

mod line;
mod mesh;
mod shape;

pub use line::Line;
pub use mesh::{beads, torus};

use core::ops::ControlFlow::Continue;
use pfront_core::bvh::{BuildOptions, BvhStorage, morton};
use pfront_core::bvtt::{Cursor, PairBvtt, Query, TrianglePair};
use pfront_core::front::{Front, FrontNode, Part, RefineOptions};
use pfront_core::{Bvh, Mesh, Node, Pose};
use shape::TRIANGLES;

/// How many frames the scene lasts.
pub const FRAMES: u32 = 8;

/// Workers that a frame is divided among.
const WORKERS: usize = 2;

/// As many as the tree has; the build says so if they are too few.
const NODES: usize = 448;

/// The most nodes of a front.
const FRONT: usize = 160;

/// Pairs to a page.
const PAGE: usize = 64;

/// Tests to a step.
const BUDGET: u64 = 100;

/// Words of scratch for a build, in whose place the front and the cost history have room.
const SCRATCH: usize = 2 * TRIANGLES;
/// Words of the front, and as many of its cost history.
const FRONT_WORDS: usize = FRONT * size_of::<FrontNode>() / 8;
const _: () = assert!(2 * FRONT_WORDS <= SCRATCH, "too little scratch");

/// All memory of the scene but its stack.
pub struct Memory {
    nodes: [Node; NODES],
    order: [u32; TRIANGLES],
    /// Scratch of the build; then the front, and behind it its cost history.
    scratch: [u64; SCRATCH],
}

impl Memory {
    /// As a program begins with it: all zero, so that it takes no flash.
    pub const ZERO: Self = {
        let node = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
        Self { nodes: [node; NODES], order: [0; TRIANGLES], scratch: [0; SCRATCH] }
    };
}

/// Triangle pairs as a set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// How many they are.
    pub count: u32,
    /// The sum of their scrambled numbers, whatever their order.
    pub hash: u32,
}

impl Pairs {
    /// Takes in one more.
    pub fn add(&mut self, pair: TrianglePair) {
        self.count += 1;
        let number = (pair.a * TRIANGLES as u32 + pair.b + 1).wrapping_mul(0x9e37_79b9);
        self.hash = self.hash.wrapping_add(number ^ number.rotate_left(15));
    }
}

/// How the second mesh stands in the frame of the first: it sinks into it, turning.
#[must_use]
pub fn pose(frame: u32) -> Pose {
    let [cos, sin] = shape::on_circle(frame as usize, 64);
    let shift = 1.3 - 0.1 * frame as f32;
    Pose::new([[1.0, 0.0, 0.0, shift], [0.0, cos, -sin, 0.1], [0.0, sin, cos, 0.0]])
}

/// Plays the scene, and hands on the pairs of each frame with a line about it.
///
/// # Errors
/// The buffer that is too small, or the step that has failed.
pub fn play(memory: &mut Memory, mut show: impl FnMut(Pairs, &Line)) -> Result<(), &'static str> {
    let Memory { nodes, order, scratch } = memory;
    let a = build(torus().map_err(|_| "mesh")?, BvhStorage { nodes, order }, scratch)?;
    let b = beads().map_err(|_| "blob")?;
    let (front, rest) = scratch.split_at_mut(FRONT_WORDS);
    let (history, _) = rest.split_at_mut(FRONT_WORDS);
    let front: &mut [FrontNode] = bytemuck::try_cast_slice_mut(front).map_err(|_| "front")?;
    let history: &mut [FrontNode] = bytemuck::try_cast_slice_mut(history).map_err(|_| "history")?;
    let mut remembered = 0;
    for number in 0..FRAMES {
        let query = PairBvtt::new(a, b, pose(number)).map_err(|_| "pose")?;
        let last = history.get_mut(..remembered).unwrap_or_default();
        let nodes = divide(&query, front, last)?;
        let (mut pairs, mut work) = (Pairs::default(), [0; WORKERS]);
        for (node, measured) in nodes.iter().zip(&mut *history) {
            *measured = *node;
            measured.cost = work_through(&query, node, &mut work, &mut pairs);
        }
        remembered = nodes.len();
        let line = found(pairs).with(remembered as u32, " nodes of a front, ");
        show(pairs, &line.with(work[0], " + ").with(work[1], " tests\n"));
    }
    let (pairs, steps, longest) = in_steps(&PairBvtt::new(a, b, pose(FRAMES)).map_err(|_| "pose")?);
    show(pairs, &found(pairs).with(steps, " steps of up to ").with(longest, " tests\n"));
    Ok(())
}

fn found(pairs: Pairs) -> Line {
    Line::EMPTY.with(pairs.count, " pairs, hash ").with(pairs.hash, ": ")
}

// Each part of a frame is a function of its own on the stack, so that none has to bear with what another
// needs there.

#[inline(never)]
fn build<'a>(
    mesh: Mesh<'a>,
    storage: BvhStorage<'a>,
    scratch: &mut [u64],
) -> Result<Bvh<'a>, &'static str> {
    morton(mesh, &BuildOptions::default(), storage, scratch).map_err(|error| error.buffer)
}

/// The front of a frame, assigned to the workers.
#[inline(never)]
fn divide<'n>(
    query: &PairBvtt<'_>,
    nodes: &'n mut [FrontNode],
    last: &mut [FrontNode],
) -> Result<&'n [FrontNode], &'static str> {
    let mut front = Front::new(nodes);
    if let Some(root) = query.root() {
        front.add(0, root).map_err(|error| error.buffer)?;
    }
    front.refine(&RefineOptions::new(WORKERS), last, |_| query);
    Ok(front.partition(&mut [Part::default(); WORKERS]))
}

/// Traverses from a node, page by page; adds what it costs to the work of its worker, and returns it.
#[inline(never)]
fn work_through(
    query: &PairBvtt<'_>,
    node: &FrontNode,
    work: &mut [u32; WORKERS],
    pairs: &mut Pairs,
) -> f32 {
    let mut page = [TrianglePair::default(); PAGE];
    let mut cursor = Cursor::at(node.pair);
    while !cursor.is_done() {
        let len = query.page(&mut cursor, &mut page);
        page.iter().take(len).for_each(|&pair| pairs.add(pair));
    }
    if let Some(sum) = work.get_mut(node.part as usize) {
        *sum += tests(&cursor);
    }
    tests(&cursor) as f32
}

/// The pairs of a whole query in steps, how many there were and how long the longest.
#[inline(never)]
fn in_steps(query: &PairBvtt<'_>) -> (Pairs, u32, u32) {
    let (mut pairs, mut steps, mut longest) = (Pairs::default(), 0, 0);
    let mut cursor = query.start();
    while !cursor.is_done() {
        let before = tests(&cursor);
        let _ = query.step(&mut cursor, BUDGET, |pair| {
            pairs.add(pair);
            Continue(())
        });
        steps += 1;
        longest = longest.max(tests(&cursor) - before);
    }
    (pairs, steps, longest)
}

fn tests(cursor: &Cursor) -> u32 {
    cursor.work.tests() as u32
}
