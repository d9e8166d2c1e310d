//! Many triangle pairs to a GPU at once.
//!
//! The passes answer for two meshes, so the pairs of a block become two: triangle i of the one is to meet
//! triangle i of the other and no one else's. The boxes of the BVHs see to that. They are not those of the
//! triangles but stand in a row, box i of one on box i of the other, and so the descent hands exactly
//! the pairs (i, i) to the passes that decide; these look at corners only.

use crate::suite::Case;
use pfront::gpu::{Gpu, GpuError, GpuModel, GpuQuery, GpuQuestion, GpuReport};
use pfront::pfront_core::Triangle;
use pfront::{Bvh, Mesh, Node, Pose};

/// A GPU, and what it needs to answer.
#[derive(Debug)]
pub struct OnGpu {
    gpu: Gpu,
    query: GpuQuery,
    left_to_cpu: u64,
}

impl OnGpu {
    /// The best adapter there is.
    ///
    /// # Errors
    /// If there is none, or none that could do it.
    pub fn new() -> Result<Self, GpuError> {
        let gpu = Gpu::new()?;
        let query = GpuQuery::new(&gpu)?;
        Ok(Self { gpu, query, left_to_cpu: 0 })
    }

    /// The name of the adapter.
    pub fn name(&self) -> String {
        self.gpu.device().adapter_info().name
    }

    /// How many pairs the device left to the CPU so far.
    pub fn left_to_cpu(&self) -> u64 {
        self.left_to_cpu
    }

    /// Whether the two triangles of each pair meet.
    ///
    /// # Errors
    /// If the device fails.
    pub fn answers(&mut self, cases: &[Case]) -> Result<Vec<bool>, GpuError> {
        let nodes = row(cases.len() as u32);
        let order: Vec<u32> = (0..cases.len() as u32).collect();
        let triangles: Vec<[u32; 3]> =
            order.iter().map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let model = |of: fn(&Case) -> Triangle| {
            let corners: Vec<_> = cases.iter().flat_map(of).collect();
            GpuModel::new(
                &self.gpu,
                Bvh::new_unchecked(Mesh::new_unchecked(&corners, &triangles), &nodes, &order),
            )
        };
        let (a, b) = (model(|case| case.a)?, model(|case| case.b)?);
        let mut answers = vec![false; cases.len()];
        for pair in self.query.all(&GpuQuestion::pair(&a, &b, &Pose::IDENTITY))? {
            answers[pair.a as usize] |= pair.a == pair.b;
        }
        let GpuReport { on_cpu, .. } = self.query.report();
        self.left_to_cpu += u64::from(on_cpu);
        Ok(answers)
    }
}

/// A balanced tree over `n` leaves of one triangle each, whose boxes stand in a row along x.
fn row(n: u32) -> Vec<Node> {
    let node = |from: u32, to: u32| {
        let box_at = |x: f32| [x, 0.0, 0.0];
        Node {
            min: box_at(from as f32),
            max: box_at(to as f32 - 0.5),
            first: from,
            count: to - from,
        }
    };
    // Where there are two leaves, slot 1 stays empty. `count` is how many leaves there are below.
    let mut nodes = vec![node(0, n)];
    nodes.extend((n > 1).then_some(Node::EMPTY));
    let mut at = 0;
    while at < nodes.len() {
        let Node { first, count, .. } = nodes[at];
        if count > 1 {
            let middle = first + count / 2;
            (nodes[at].first, nodes[at].count) = (nodes.len() as u32, 0);
            nodes.extend([node(first, middle), node(middle, first + count)]);
        }
        at += 1;
    }
    if n == 0 { Vec::new() } else { nodes }
}
