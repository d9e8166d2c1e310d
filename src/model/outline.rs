//! A box of all triangles in place of a BVH, for what looks at no node below the root.

use super::Model;
use pfront_core::{Bvh, Node};
use std::cell::OnceCell;
use std::slice::from_ref;

/// The root of [`Model::outline`], once it is made.
#[derive(Debug, Default)]
pub(crate) struct Outline(OnceCell<Node>);

impl Model {
    /// The BVH if it fits the positions. If it does not, it is left alone, and a root without children stands for it, for what
    /// traverses nothing: a pose that is checked, the error bounds of a shadow, single triangles. Its box is that of the
    /// root of the BVH.
    ///
    /// # Complexity
    /// O(triangles); O(1) if the BVH fits.
    pub(crate) fn outline<'m>(&'m self, outline: &'m Outline) -> Bvh<'m> {
        if self.is_fitted() {
            return self.bvh();
        }
        let mesh = self.mesh();
        if mesh.triangles().is_empty() {
            return Bvh::new_unchecked(mesh, &[], &[]);
        }
        let root = outline.0.get_or_init(|| {
            let corners = mesh.triangles().as_flattened().iter();
            let corner = |&vertex: &u32| mesh.shadow()[vertex as usize];
            let ([mut min, mut max], at) =
                ([corner(&mesh.triangles()[0][0]); 2], corners.map(corner));
            for p in at {
                min = [0, 1, 2].map(|k| p[k].min(min[k]));
                max = [0, 1, 2].map(|k| p[k].max(max[k]));
            }
            Node { min, first: 0, max, count: 1 }
        });
        Bvh::new_unchecked(mesh, from_ref(root), &[0])
    }

    /// Whether the BVH fits the positions.
    #[inline]
    pub(crate) fn is_fitted(&self) -> bool {
        self.tree.fresh().is_some()
    }
}
