//! Breaking a model into pieces.

use crate::model::ONE_THREAD;
use crate::{Error, Model};

/// The triangles of each part, by ascending number of the part; within a part in their old order.
pub(super) fn parts(triangles: u32, part_of: impl Fn(u32) -> u32) -> Vec<(u32, Vec<u32>)> {
    let mut order: Vec<_> = (0..triangles).map(|triangle| (part_of(triangle), triangle)).collect();
    order.sort_unstable();
    let runs = order.chunk_by(|x, y| x.0 == y.0);
    runs.map(|run| (run[0].0, run.iter().map(|&(_, triangle)| triangle).collect())).collect()
}

/// Makes models of some triangles of another one, in its precision.
pub(super) struct Cutter<'m> {
    model: &'m Model,
    /// The new number of each vertex of the last piece.
    numbers: Vec<Option<u32>>,
}

impl<'m> Cutter<'m> {
    pub(super) fn new(model: &'m Model) -> Self {
        Self { model, numbers: vec![None; model.mesh().vertex_count()] }
    }

    /// The model of `triangles`, in this order, with the vertices that they use, in order of first use.
    pub(super) fn cut(&mut self, triangles: &[u32]) -> Result<Model, Error> {
        let mesh = self.model.mesh();
        let mut used = Vec::new();
        let mut number = |vertex: u32| {
            *self.numbers[vertex as usize].get_or_insert_with(|| {
                used.push(vertex);
                (used.len() - 1) as u32
            })
        };
        let corners = triangles.iter().map(|&t| mesh.triangles()[t as usize]);
        let renumbered = corners.map(|[u, v, w]| [number(u), number(v), number(w)]).collect();
        used.iter().for_each(|&vertex| self.numbers[vertex as usize] = None);
        let (model, options) = (self.model, self.model.options());
        if !model.is_f64() {
            let positions = used.iter().map(|&vertex| mesh.shadow()[vertex as usize]);
            return Model::build::<f32>(positions.collect(), renumbered, options, ONE_THREAD);
        }
        let position = |&vertex: &u32| match mesh.positions_f64() {
            Some(positions) => positions[vertex as usize],
            // The shadow holds every coordinate.
            None => mesh.shadow()[vertex as usize].map(f64::from),
        };
        let positions = used.iter().map(position).collect();
        Model::build(positions, renumbered, options, ONE_THREAD)
    }
}
