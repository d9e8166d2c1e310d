//! The memory that reading a mesh may take.

use crate::error::Fault;
use crate::mesh::TriangleMesh;

/// Bytes that a file may take while it is read, unless more are allowed: as many for each of its own, and a constant.
const FACTOR: usize = 16;
const CONSTANT: usize = 64 << 20;

/// A list grows to twice what it holds, and moves meanwhile.
const GROWTH: usize = 3;

/// The bytes that so many vertices and triangles take while they are read.
pub(crate) fn demand(vertices: usize, triangles: usize) -> usize {
    let arrays = size_of::<[f64; 3]>()
        .saturating_mul(vertices)
        .saturating_add(size_of::<[u32; 3]>().saturating_mul(triangles));
    GROWTH.saturating_mul(arrays)
}

/// The bytes that reading a mesh may take, and those that are left.
#[derive(Debug, Default)]
pub(crate) struct Budget {
    most: usize,
    left: usize,
    /// Whether the size of each file that is read is known to add to it, since nobody has set it.
    follows_files: bool,
}

impl Budget {
    /// The budget of a file of so many bytes, which is `set` if that is not `None`.
    pub(crate) fn new(set: Option<usize>, file: usize) -> Self {
        let most = set.unwrap_or_else(|| CONSTANT.saturating_add(FACTOR.saturating_mul(file)));
        Self { most, left: most, follows_files: set.is_none() }
    }

    /// Adds what another file of so many bytes may take.
    pub(crate) fn add_file(&mut self, file: usize) {
        if self.follows_files {
            let more = FACTOR.saturating_mul(file);
            self.most = self.most.saturating_add(more);
            self.left = self.left.saturating_add(more);
        }
    }

    /// Takes bytes that stay in use until the mesh is read.
    pub(crate) fn take(&mut self, bytes: usize) -> Result<(), Fault> {
        self.check(bytes)?;
        self.left -= bytes;
        Ok(())
    }

    /// Checks that so many bytes are left.
    pub(crate) fn check(&self, bytes: usize) -> Result<(), Fault> {
        if bytes <= self.left { Ok(()) } else { Err(Fault::memory(self.most)) }
    }

    /// Checks that a list of so many elements of some bytes each can still grow.
    pub(crate) fn check_list<T>(&self, list: &[T], more: usize) -> Result<(), Fault> {
        let len = list.len().saturating_add(more);
        self.check(GROWTH.saturating_mul(size_of::<T>()).saturating_mul(len))
    }

    /// The bytes that are left.
    pub(crate) fn left(&self) -> usize {
        self.left
    }

    /// Checks that a mesh can have so many more vertices and triangles.
    pub(crate) fn check_growth(
        &self,
        mesh: &TriangleMesh,
        vertices: usize,
        triangles: usize,
    ) -> Result<(), Fault> {
        let TriangleMesh { positions, triangles: own } = mesh;
        self.check(demand(
            positions.len().saturating_add(vertices),
            own.len().saturating_add(triangles),
        ))
    }

    /// Checks that a mesh, as it is read, can have more triangles and faces.
    pub(crate) fn check_mesh(
        &self,
        mesh: &TriangleMesh,
        faces: &[u32],
        more: usize,
    ) -> Result<(), Fault> {
        let TriangleMesh { positions, triangles } = mesh;
        let arrays = demand(positions.len(), triangles.len().saturating_add(more));
        self.check(arrays.saturating_add(GROWTH * size_of_val(faces)))
    }
}
