//! Starting from node pairs of the caller's, who knows the BVH that a model was made from.
//!
//! Fronts on the device tell of a node where its children are, which takes the nodes to know. An entry that
//! says that there are none stands for the node itself, be it a leaf or not: the first level of a descent
//! looks it up, and from there on all is as usual. So the host keeps no nodes, and nothing is translated.

use crate::answer::Answer;
use crate::engine::{Entry, Task};
use crate::model::LEAF;
use crate::{Error, Model, Pending};
use pfront_core::bvtt::NodePair;
use wgpu::CommandEncoder;

/// Node pairs of the BVHs that two models were made from, as entries of a front.
fn entries([a, b]: [&Model; 2], front: &[NodePair]) -> Result<Vec<Entry>, Error> {
    let nodes = |model: &Model| model.uploaded_nodes.ok_or(Error::BuiltOnDevice);
    let (in_a, in_b) = (nodes(a)?, nodes(b)?);
    let entry = |node: u32, nodes: u32| match node < nodes {
        true => Ok(node | LEAF),
        false => Err(Error::NoSuchNode { node, nodes }),
    };
    front.iter().map(|pair| Ok([entry(pair.a, in_a)?, entry(pair.b, in_b)?])).collect()
}

impl<'q> Pending<'q> {
    /// Records a query from node pairs of the caller's.
    pub(crate) fn record_below(
        answer: &'q mut Answer,
        encoder: &mut CommandEncoder,
        task: Option<Task>,
        models: [&Model; 2],
        front: &[NodePair],
    ) -> Result<Self, Error> {
        let front = entries(models, front)?;
        let task = task.filter(|_| !front.is_empty());
        // The level at which nodes are looked up is one more.
        let task = task.map(|task| Task { levels: task.levels + 1, ..task });
        Self::record(answer, encoder, task, Some(&front))
    }
}
