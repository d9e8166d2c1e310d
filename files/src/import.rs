//! A mesh that is being read.

use crate::budget::Budget;
use crate::error::Fault;
use crate::mesh::TriangleMesh;
use crate::source::Source;
use crate::text::without_padding;
use crate::triangulate::{SCRATCH, triangulate};
use glam::{DMat4, DVec3};
use std::collections::HashMap;

/// A mesh that is being read, where it comes from, and what reading may take.
#[derive(Debug, Default)]
pub(crate) struct Import {
    pub(crate) mesh: TriangleMesh,
    pub(crate) source: Source,
    pub(crate) budget: Budget,
    /// Lines about what was passed over.
    pub(crate) notes: Vec<String>,
    /// The lines of vertices with a coordinate that is not finite or very large.
    strange: HashMap<usize, usize>,
    /// How many faces have fewer than three corners.
    small_faces: usize,
    /// Whether vertices are told apart by their positions, since the format splits them.
    pub(crate) is_split: bool,
}

/// Bytes for a body beside its name.
const BODY: usize = 128;

/// 2^125, the largest coordinate of a mesh in f64.
const LARGEST_IN_F64: f64 = 4.253529586511731e37;

impl Import {
    /// Nothing so far, with notes of how the file was taken.
    pub(crate) fn new(budget: Budget, notes: Vec<String>, in_f32: bool) -> Self {
        let mut import = Self { budget, notes, ..Self::default() };
        import.source.in_f32 = in_f32;
        import
    }

    /// The bytes of a text without the NULs that it ends with.
    pub(crate) fn text<'b>(&mut self, bytes: &'b [u8]) -> &'b [u8] {
        let text = without_padding(bytes);
        self.note("NULs after the text are passed over", bytes.len() - text.len());
        text
    }

    /// Forgets all that was read.
    pub(crate) fn forget_mesh(&mut self) {
        self.mesh = TriangleMesh::default();
        self.source.faces.clear();
        self.source.rounded = 0;
        self.strange.clear();
        self.small_faces = 0;
    }

    /// Notes what was passed over, unless it is none.
    pub(crate) fn note(&mut self, what: &str, count: usize) {
        if count > 0 {
            self.notes.push(format!("{what}: {count}"));
        }
    }

    /// Begins a new body with the triangle that comes next, and returns its number.
    pub(crate) fn begin_body(&mut self, name: String) -> Result<u32, Fault> {
        // Names are copied while they are told apart.
        self.budget.take(BODY.saturating_add(4 * name.len()))?;
        Ok(self.source.begin_body(name, self.mesh.triangles.len()))
    }

    /// Adds a face, as a fan for now, since its vertices may come later in the file. One of fewer than three corners has no
    /// triangle.
    pub(crate) fn push_face(&mut self, corners: &[u32]) -> Result<(), Fault> {
        self.budget.check_mesh(&self.mesh, &self.source.faces, corners.len())?;
        self.source.faces.push(self.mesh.triangles.len() as u32);
        self.small_faces += usize::from(corners.len() < 3);
        self.mesh.push_fan(corners);
        Ok(())
    }

    /// Adds the triangles of a strip, each as a face.
    pub(crate) fn push_strip(&mut self, corners: &[u32]) -> Result<(), Fault> {
        self.budget.check_mesh(&self.mesh, &self.source.faces, 2 * corners.len())?;
        let first = self.mesh.triangles.len() as u32;
        self.mesh.push_strip(corners);
        self.source.faces.extend(first..self.mesh.triangles.len() as u32);
        Ok(())
    }

    /// Adds a vertex that a line of the file states.
    pub(crate) fn push_position(&mut self, position: [f64; 3], line: usize) -> Result<(), Fault> {
        if !position.iter().all(|x| x.abs() <= LARGEST_IN_F64) {
            self.strange.insert(self.mesh.positions.len(), line);
        }
        self.mesh.positions.push(position);
        self.check_memory()
    }

    /// Adds vertices that a matrix places, and returns the number of the first.
    pub(crate) fn push_placed(&mut self, positions: &[[f64; 3]], world: &DMat4) -> u32 {
        let Self { mesh, source, .. } = self;
        let first = mesh.positions.len() as u32;
        // Positions that nothing moves stay the same to the bit.
        let moves = *world != DMat4::IDENTITY;
        mesh.positions.extend(positions.iter().map(|&p| {
            let placed = if moves { world.transform_point3(DVec3::from(p)).to_array() } else { p };
            source.rounded(placed)
        }));
        first
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

    /// Completes the mesh: polygons are triangulated, and every vertex of a triangle is there and finite.
    pub(crate) fn finish(&mut self) -> Result<(), Fault> {
        let all = self.mesh.positions.len();
        self.note("faces of one or two corners are passed over", self.small_faces);
        if self.mesh.triangles.is_empty() {
            return Err(Fault::no_triangle(all, &self.notes));
        }
        if let Some(at) =
            self.mesh.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= all))
        {
            let stray = self.mesh.triangles[at].into_iter().max().unwrap_or(0);
            let face = self.source.face(at as u32);
            return Err(Fault::broken(format!(
                "face {face}: there is no vertex {stray} among {all}"
            )));
        }
        self.check_coordinates()?;
        self.triangulate_faces()?;
        self.source.end_bodies(self.mesh.triangles.len());
        if self.source.rounded > 0 {
            let rounded = self.source.rounded;
            self.notes.push(format!(
                "{rounded} of {} coordinates were rounded to f32; the answer is exact for what they became",
                3 * all
            ));
        }
        Ok(())
    }

    /// Checks that vertices of triangles are finite. Others that are not take the place of one that is.
    fn check_coordinates(&mut self) -> Result<(), Fault> {
        let largest = match self.source.in_f32 || self.mesh.beyond_f32() == 0 {
            true => f32::MAX.into(),
            false => LARGEST_IN_F64,
        };
        let is_bad = |p: &[f64; 3]| !p.iter().all(|x| x.abs() <= largest);
        let mesh = &mut self.mesh;
        if !mesh.positions.iter().any(is_bad) {
            return Ok(());
        }
        let mut used = vec![false; mesh.positions.len()];
        mesh.triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
        let first = mesh.triangles[0][0] as usize;
        let mut unused = 0;
        let instead = mesh.positions[first];
        for (vertex, position) in mesh.positions.iter_mut().enumerate() {
            if !is_bad(position) {
                continue;
            }
            if used[vertex] {
                let what = match position.iter().all(|x| x.is_finite()) {
                    true => "a coordinate beyond ±2^125",
                    false => "a NaN or infinite coordinate",
                };
                let what = format!("vertex {vertex} has {what} (vertices count from 0)");
                return Err(match self.strange.get(&vertex) {
                    Some(&line) if line > 0 => Fault::line(line, what),
                    _ => Fault::broken(what),
                });
            }
            unused += 1;
            *position = instead;
        }
        self.note("vertices that no face uses are not finite, and put elsewhere", unused);
        Ok(())
    }

    /// Triangulates every face of more than three corners, in place of its fan.
    fn triangulate_faces(&mut self) -> Result<(), Fault> {
        let Self { mesh, source, budget, notes, .. } = self;
        let (mut corners, mut fans) = (Vec::new(), None);
        let ends = source.faces.iter().skip(1).copied().chain([mesh.triangles.len() as u32]);
        for (face, (&first, end)) in source.faces.iter().zip(ends).enumerate() {
            let fan = &mut mesh.triangles[first as usize..end as usize];
            let [[apex, second, _], _, ..] = *fan else { continue };
            budget.check(SCRATCH.saturating_mul(fan.len()))?;
            corners.clear();
            corners.extend([apex, second]);
            corners.extend(fan.iter().map(|[_, _, corner]| *corner));
            if !triangulate(&corners, &mesh.positions, fan) {
                fans.get_or_insert((face, 0)).1 += 1;
            }
        }
        if let Some((first, count)) = fans {
            let what = "faces that cross themselves or have no area are fans, which may cover more";
            notes.push(format!("{what}: {count}, the first is face {first}"));
        }
        Ok(())
    }
}
