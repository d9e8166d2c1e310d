//! Blobs are read as they were written, on machines of either endianness.

extern crate std;

mod hostile;
#[cfg(feature = "f64")]
mod in_f64;

use super::*;
use pfront_core::MeshError;
use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound, sah};
use pfront_testkit::MeshData;
use pfront_testkit::shapes::strip;
use std::prelude::v1::*;
use std::{format, vec};

/// One triangle, field by field as the module has them. The checksum is zlib's.
const GOLDEN: [&[u8]; 18] = [
    b"\x89PFB\r\n\x1a\n",
    b"\x01\0\0\0",
    b"\xf0\xe3\x43\xf5",
    b"\xa4\0\0\0\0\0\0\0",
    b"\x01\0\x01\0\x01\0\x01\0",
    b"\x01\0\0\0",
    b"\x03\0\0\0",
    b"\x01\0\0\0",
    &[0; 20],
    b"\0\0\x80\xbf\0\0\0\0\0\0\0\0",
    b"\0\0\0\0",
    b"\0\0\x80\x3f\0\0\0\x40\0\0\0\x3f",
    b"\x01\0\0\0",
    b"\0\0\x80\xbf\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0\0\0\x3f\0\0\0\0\0\0\0\x40\0\0\0\x80",
    &[0; 12],
    b"\0\0\0\0\x01\0\0\0\x02\0\0\0",
    &[0; 4],
    b"\0\0\0\0",
];

/// Bytes that begin where they should.
fn aligned(bytes: &[u8]) -> Box<Aligned<[u8]>> {
    let mut to: Box<Aligned<[u8]>> = Box::new(Aligned([0; 8192]));
    to.0[..bytes.len()].copy_from_slice(bytes);
    to
}

/// A mesh and its BVH.
#[derive(Clone, Debug, PartialEq)]
struct Owned {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Owned {
    fn new(soup: MeshData, leaf_size: u32, by_morton: bool) -> Self {
        let MeshData { positions, triangles } = soup;
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let n = triangles.len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let options = BuildOptions { leaf_size, ..BuildOptions::default() };
        let built = if by_morton {
            morton(mesh, &options, storage, &mut vec![0; 2 * n])
        } else {
            sah(mesh, &options, storage, &mut vec![Node::EMPTY; n])
        };
        let used = built.unwrap().nodes().len();
        nodes.truncate(used);
        Self { positions, triangles, nodes, order }
    }

    fn bvh(&self) -> Bvh<'_> {
        let mesh = Mesh::new_unchecked(&self.positions, &self.triangles);
        Bvh::new_unchecked(mesh, &self.nodes, &self.order)
    }

    fn room(counts: Counts) -> Self {
        Self {
            nodes: vec![Node::EMPTY; counts.nodes],
            positions: vec![[0.0; 3]; counts.vertices],
            triangles: vec![[0; 3]; counts.triangles],
            order: vec![0; counts.triangles],
        }
    }

    fn storage(&mut self) -> BlobStorage<'_> {
        BlobStorage {
            nodes: &mut self.nodes,
            positions: &mut self.positions,
            triangles: &mut self.triangles,
            order: &mut self.order,
        }
    }

    fn baked(&self) -> Vec<u8> {
        let mut out = vec![0xaa; Counts::of(&self.bvh()).bytes()];
        write(&self.bvh(), &mut out).unwrap();
        out
    }
}

fn triangle() -> Owned {
    Owned {
        nodes: vec![Node { min: [-1.0, 0.0, 0.0], first: 0, max: [1.0, 2.0, 0.5], count: 1 }],
        positions: vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 2.0, -0.0]],
        triangles: vec![[0, 1, 2]],
        order: vec![0],
    }
}

/// The BVH of a good blob, borrowed where that is possible and copied.
fn read(bytes: &[u8]) -> Owned {
    let bytes = &aligned(bytes).0[..bytes.len()];
    let blob = Blob::new(bytes).unwrap();
    let mut own = Owned::room(blob.counts());
    blob.read_into(own.storage(), &mut [0; 2]).unwrap();
    let borrowed = blob.bvh(&mut [0; 2]);
    if cfg!(target_endian = "big") {
        assert_eq!(borrowed.err(), Some(BlobError::BigEndian));
    } else {
        let (bvh, copy) = (borrowed.unwrap(), own.bvh());
        assert_eq!((bvh.nodes(), bvh.order()), (copy.nodes(), copy.order()));
        assert_eq!(bvh.mesh().positions().unwrap(), copy.mesh().positions().unwrap());
        assert_eq!(bvh.mesh().triangles(), copy.mesh().triangles());
    }
    own
}

#[test]
fn the_format_does_not_drift() {
    let golden = GOLDEN.concat();
    assert_eq!(triangle().baked(), golden);
    let own = read(&golden);
    assert_eq!(own, triangle());
    assert!(own.positions[2][2].is_sign_negative(), "to the bit");
}

#[test]
fn what_is_written_is_read_and_written_again() {
    let sizes: &[u32] = if cfg!(miri) { &[0, 9] } else { &[0, 1, 2, 7, 8, 9, 33, 60] };
    for (&size, by_morton) in sizes.iter().flat_map(|n| [(n, false), (n, true)]) {
        for leaf_size in [1, 8] {
            let own = Owned::new(strip(size), leaf_size, by_morton);
            let bytes = own.baked();
            let again = read(&bytes);
            assert_eq!(again, own, "{size} {by_morton} {leaf_size}");
            assert_eq!(again.baked(), bytes);
            assert!(own.bvh().is_depth_first());
        }
    }
}

#[test]
fn bytes_may_lie_anywhere_to_be_copied() {
    let golden = GOLDEN.concat();
    for shift in 0..8 {
        let bytes = aligned(&[&[0xee; 8][..shift], &golden].concat());
        let blob = Blob::new(&bytes.0[shift..][..golden.len()]).unwrap();
        let mut own = Owned::room(blob.counts());
        blob.read_into(own.storage(), &mut [0]).unwrap();
        assert_eq!(own, triangle());
        if cfg!(target_endian = "little") {
            let refused = (shift % 4 != 0).then_some(BlobError::Misaligned { needed: 4 });
            assert_eq!(blob.bvh(&mut [0]).err(), refused, "{shift}");
        }
    }
}

#[test]
fn buffers_that_are_too_small_are_named() {
    let own = triangle();
    let short = write(&own.bvh(), &mut [0; 163]).err();
    let error = CapacityError::check("out", 164, 163).unwrap_err();
    assert_eq!(short, Some(error.into()));
    let golden = GOLDEN.concat();
    let blob = Blob::new(&golden).unwrap();
    for name in ["nodes", "positions", "triangles", "order"] {
        let mut room = Owned::room(blob.counts());
        match name {
            "nodes" => room.nodes.clear(),
            "positions" => room.positions.clear(),
            "triangles" => room.triangles.clear(),
            _ => room.order.clear(),
        }
        let refused = blob.read_into(room.storage(), &mut [0]).err();
        let found = match refused {
            Some(BlobError::Capacity(error)) => Some((error.buffer, error.capacity)),
            _ => None,
        };
        assert_eq!(found, Some((name, 0)), "{refused:?}");
    }
    assert!(matches!(
        blob.read_into(Owned::room(blob.counts()).storage(), &mut []),
        Err(BlobError::Bvh(BvhError::Capacity(_)))
    ));
}

#[test]
fn what_is_no_bvh_is_not_written() {
    for order in [vec![], vec![0, 0]] {
        let error = BvhError::Length { array: "order", expected: 1, found: order.len() };
        let own = Owned { order, ..triangle() };
        assert_eq!(write(&own.bvh(), &mut [0; 999]).err(), Some(error));
    }
}

#[test]
fn no_count_overflows() {
    let max = usize::MAX;
    let most = Counts { nodes: max, vertices: max, triangles: max, positions_f64: max };
    assert!(most.bytes() > isize::MAX as usize);
    let none = Counts { nodes: 0, vertices: 0, triangles: 0, positions_f64: 0 };
    for most in
        [Counts { nodes: max / 32 + 2, ..none }, Counts { positions_f64: max / 24 + 2, ..none }]
    {
        assert!(most.bytes() > isize::MAX as usize);
    }
}
