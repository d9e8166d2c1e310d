//! A mesh, what is known of it, and its BVHs.

use crate::input::{Build, Builder};
use pfront::MeshError;
use pfront::pfront_core::bvh::node_bound;
use pfront::pfront_core::bvh::{self, BvhStorage, Join, Refit};
use pfront::{BuildOptions, Bvh, Error, Executor, Mesh, Model, Node, threads};
use pfront_testkit::MeshData;

/// The nodes and order of a BVH, without its mesh.
#[derive(Clone, Debug)]
pub struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Tree {
    /// Builds one.
    ///
    /// # Panics
    /// If the library refuses buffers of the size it asked for.
    #[must_use]
    pub fn new(mesh: Mesh<'_>, leaf_size: u32, builder: Builder) -> Self {
        let n = mesh.triangles().len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let side_by_side = matches!(builder, Builder::SahThreads | Builder::MortonThreads);
        let join: Option<&Join<'_>> = if side_by_side { Some(&threads::join) } else { None };
        let options = BuildOptions { leaf_size, join };
        let mut items = vec![Node::EMPTY; n];
        let mut keys = vec![0; 2 * n];
        let built = match builder {
            Builder::Sah | Builder::SahThreads => bvh::sah(mesh, &options, storage, &mut items),
            Builder::Morton | Builder::MortonThreads => {
                bvh::morton(mesh, &options, storage, &mut keys)
            }
        };
        let used = built.unwrap().nodes().len();
        nodes.truncate(used);
        let tree = Self { nodes, order };
        tree.bvh(mesh).assert_well_formed();
        tree
    }

    /// The BVH over its mesh.
    #[must_use]
    pub fn bvh<'t>(&'t self, mesh: Mesh<'t>) -> Bvh<'t> {
        Bvh::new_unchecked(mesh, &self.nodes, &self.order)
    }

    fn refit(&mut self, mesh: Mesh<'_>) {
        let mut other = self.nodes.clone();
        bvh::refit(mesh, &mut self.nodes, &self.order, Refit::default()).unwrap();
        let options = Refit { join: Some(&threads::join), ..Refit::default() };
        bvh::refit(mesh, &mut other, &self.order, options).unwrap();
        assert_eq!(self.nodes, other);
        self.bvh(mesh).assert_well_formed();
    }
}

/// A model, and a tree that need not be the model's own.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) soup: MeshData,
    pub(crate) model: Model,
    tree: Tree,
}

impl Body {
    /// Refused in the same words by every way to make a model.
    pub(crate) fn new(soup: MeshData, build: Build) -> Result<Self, Error> {
        let options = BuildOptions { leaf_size: build.leaf_size.into(), ..BuildOptions::default() };
        let MeshData { positions, triangles } = soup.clone();
        let alone = Executor::sequential();
        let model = alone.build(positions.clone(), triangles.clone(), options);
        let error = mesh_error(&soup).map(Error::Mesh);
        assert_eq!(Mesh::new(&positions, &triangles).err().map(Error::Mesh), error);
        assert_eq!(model.as_ref().err(), error.as_ref());
        let model = model?;
        let tree = Tree::new(model.mesh(), build.leaf_size.into(), build.builder);
        Ok(Self { soup, model, tree })
    }

    /// The tree that is not the model's own.
    pub(crate) fn bvh(&self) -> Bvh<'_> {
        self.tree.bvh(self.model.mesh())
    }

    /// Moves the vertices, or says what is wrong with them, and then changes nothing.
    pub(crate) fn deform(&mut self, positions: &[[f32; 3]]) -> Result<(), Error> {
        let error = position_error(positions, self.soup.positions.len()).map(Error::Mesh);
        let mut later = self.model.clone();
        assert_eq!(later.set_positions_unfitted(positions).err(), error);
        assert_eq!(self.model.set_positions(positions).err(), error);
        if error.is_none() {
            self.soup.positions = positions.to_vec();
        }
        for model in [&self.model, &later] {
            assert_eq!(model.mesh().positions().unwrap(), self.soup.positions);
            model.bvh().assert_well_formed();
        }
        self.tree.refit(self.model.mesh());
        error.map_or(Ok(()), Err)
    }
}

fn mesh_error(soup: &MeshData) -> Option<MeshError> {
    let vertices = soup.positions.len();
    let stray = || {
        let all = soup.triangles.iter().enumerate();
        let mut corners = all.flat_map(|(triangle, t)| t.map(|index| (triangle, index)));
        let (triangle, index) = corners.find(|&(_, index)| index as usize >= vertices)?;
        Some(MeshError::IndexOutOfRange { triangle, index, vertices })
    };
    position_error(&soup.positions, vertices).or_else(stray)
}

fn position_error(positions: &[[f32; 3]], expected: usize) -> Option<MeshError> {
    let found = positions.len();
    if found != expected {
        return Some(MeshError::VertexCount { expected, found });
    }
    let vertex = positions.iter().position(|p| p.iter().any(|x| !x.is_finite()))?;
    Some(MeshError::NonFinite { vertex })
}
