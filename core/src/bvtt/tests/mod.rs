//! Tests of queries, and of the blocks of triangles below them.

extern crate std;

mod blocks;
#[cfg(feature = "within")]
mod distance;
#[cfg(feature = "f64")]
mod in_f64;
mod queries;
mod steps;
#[cfg(feature = "within")]
mod within;

use super::{Query, TrianglePair, Work};
use crate::Mesh;
use crate::one_ring::{Certified, OneRings, history_bound, link_scratch_bound};
use core::ops::ControlFlow::{self, Continue};
use std::vec;
use std::vec::Vec;

/// The pairs and the work of a query at one go.
fn at_one_go(query: &impl Query) -> (Vec<TrianglePair>, Work) {
    let (mut found, mut cursor) = (Vec::new(), query.start());
    assert!(query.visit(&mut cursor, |pair| push(&mut found, pair)).is_continue());
    assert!(cursor.is_done());
    (found, cursor.work)
}

fn push(found: &mut Vec<TrianglePair>, pair: TrianglePair) -> ControlFlow<()> {
    found.push(pair);
    Continue(())
}

/// Calls `test` with the certificates of a mesh.
fn with_certificates(mesh: Mesh<'_>, test: impl FnOnce(Certified<'_>)) {
    let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles());
    let mut history = vec![0; history_bound(vertices)];
    let mut scratch = vec![0; link_scratch_bound(vertices, triangles.len())];
    let mut rings = OneRings::new(vertices, triangles, &mut history, &mut scratch).unwrap();
    test(rings.certify(mesh, None));
}
