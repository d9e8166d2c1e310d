//! A mesh that is being read.

use crate::budget::Budget;
use crate::error::Fault;
use crate::mesh::TriangleMesh;
use crate::source::Source;
use crate::triangulate::{SCRATCH, triangulate};

/// A mesh that is being read, where it comes from, and what reading may take.
#[derive(Debug, Default)]
pub(crate) struct Import {
    pub(crate) mesh: TriangleMesh,
    pub(crate) source: Source,
    pub(crate) budget: Budget,
}

impl Import {
    /// Adds a face, as a fan for now, since its vertices may come later in the file.
    pub(crate) fn push_face(&mut self, corners: &[u32]) -> Result<(), Fault> {
        self.budget.check_mesh(&self.mesh, &self.source.faces, corners.len())?;
        self.source.faces.push(self.mesh.triangles.len() as u32);
        self.mesh.push_fan(corners);
        Ok(())
    }

    pub(crate) fn push_position(&mut self, position: [f64; 3]) -> Result<(), Fault> {
        self.mesh.positions.push(position);
        self.check_memory()
    }

    /// Adds a corner of a face to those before it.
    pub(crate) fn push_corner(&self, corners: &mut Vec<u32>, corner: u32) -> Result<(), Fault> {
        if corners.len().is_power_of_two() {
            self.budget.check_list(corners, corners.len())?;
        }
        corners.push(corner);
        Ok(())
    }

    pub(crate) fn check_memory(&self) -> Result<(), Fault> {
        self.budget.check_mesh(&self.mesh, &self.source.faces, 0)
    }

    /// The mesh that has been read.
    pub(crate) fn finish(mut self) -> Result<(TriangleMesh, Source, Vec<String>), Fault> {
        if self.mesh.triangles.is_empty() {
            return Err(Fault::no_triangle());
        }
        self.triangulate_faces()?;
        let mut notes = Vec::new();
        if self.source.rounded > 0 {
            let (rounded, all) = (self.source.rounded, 3 * self.mesh.positions.len());
            notes.push(format!(
                "{rounded} of {all} coordinates were rounded to f32; the answer is exact for what they became"
            ));
        }
        Ok((self.mesh, self.source, notes))
    }

    /// Triangulates every face of more than three corners, in place of its fan.
    fn triangulate_faces(&mut self) -> Result<(), Fault> {
        let Self { mesh, source, budget } = self;
        let mut corners = Vec::new();
        let ends = source.faces.iter().skip(1).copied().chain([mesh.triangles.len() as u32]);
        for (&first, end) in source.faces.iter().zip(ends) {
            let fan = &mut mesh.triangles[first as usize..end as usize];
            let [[apex, second, _], _, ..] = *fan else { continue };
            budget.check(SCRATCH.saturating_mul(fan.len()))?;
            corners.clear();
            corners.extend([apex, second]);
            corners.extend(fan.iter().map(|[_, _, corner]| *corner));
            triangulate(&corners, &mesh.positions, fan);
        }
        Ok(())
    }
}
