//! Blobs of meshes in f64.

use super::hostile::after;
use super::*;
use pfront_testkit::MeshData;

const FAR: [f64; 3] = [500_000.1, 5_000_000.2, 300.3];

/// A strip far away, and the blob of it; or where it is, in f64 too.
fn baked(is_far: bool) -> (Vec<[f64; 3]>, Vec<u8>) {
    let mut own = Owned::new(strip(9), 2, true);
    let (triangles, mut positions) = (own.triangles.clone(), Vec::new());
    if is_far {
        let place = |p: &[f32; 3]| [0, 1, 2].map(|k| FAR[k] + f64::from(p[k]));
        positions = own.positions.iter().map(place).collect();
        let mut shadow = vec![[0.0; 3]; positions.len()];
        let _ = Mesh::from_f64(&positions, &triangles, &mut shadow).unwrap();
        own = Owned::new(MeshData { positions: shadow, triangles: triangles.clone() }, 2, true);
    }
    let middle = |k: usize| {
        let along = positions.iter().map(|p: &[f64; 3]| p[k]);
        let (low, high) = (along.clone().reduce(f64::min), along.reduce(f64::max));
        low.zip(high).map_or(0.0, |(low, high)| low * 0.5 + high * 0.5)
    };
    let origin = [middle(0), middle(1), middle(2)];
    let mesh = if is_far {
        Mesh::from_f64_unchecked(&positions, &own.positions, origin, &triangles)
    } else {
        Mesh::new_unchecked(&own.positions, &triangles).widened()
    };
    let bvh = Bvh::new(mesh, &own.nodes, &own.order, &mut [0; 4]).unwrap();
    let mut out = vec![0xaa; Counts::of(&bvh).bytes()];
    write(&bvh, &mut out).unwrap();
    (positions, out)
}

#[test]
fn what_is_written_is_read_and_written_again() {
    for is_far in [false, true] {
        let (positions, bytes) = baked(is_far);
        assert_eq!(bytes[24..32], [1, 0, if is_far { 3 } else { 2 }, 0, 1, 0, 1, 0]);
        let place = aligned(&bytes);
        let blob = Blob::new(&place.0[..bytes.len()]).unwrap();
        assert!(blob.is_f64());
        assert_eq!(blob.counts().positions_f64, positions.len());
        let (mut room, mut exact) = (Owned::room(blob.counts()), positions.clone());
        exact.fill([f64::NAN; 3]);
        let copied = blob.read_into_f64(room.storage(), &mut exact, &mut [0; 4]).unwrap();
        assert_eq!(copied.mesh().positions_f64().unwrap_or_default(), positions);
        let mut again = vec![0; bytes.len()];
        assert_eq!(write(&copied, &mut again).unwrap(), bytes);
        // A reader of f32 says so.
        assert_eq!(blob.bvh(&mut [0; 4]).err(), Some(BlobError::InF64));
        let mut room = Owned::room(blob.counts());
        assert_eq!(blob.read_into(room.storage(), &mut [0; 4]).err(), Some(BlobError::InF64));
    }
}

#[test]
fn a_blob_in_f32_is_read_as_one() {
    let golden = GOLDEN.concat();
    let place = aligned(&golden);
    let blob = Blob::new(&place.0[..golden.len()]).unwrap();
    let mut room = Owned::room(blob.counts());
    let copied = blob.read_into_f64(room.storage(), &mut [], &mut [0]).unwrap();
    assert!(!copied.mesh().is_f64());
}

#[test]
fn a_buffer_that_is_too_small_is_named() {
    let (positions, bytes) = baked(true);
    let blob = Blob::new(&bytes).unwrap();
    let mut room = Owned::room(blob.counts());
    let needed = positions.len();
    let error = CapacityError::check("positions_f64", needed, needed - 1).unwrap_err();
    let mut short = vec![[0.0; 3]; needed - 1];
    let found = blob.read_into_f64(room.storage(), &mut short, &mut [0; 4]).err();
    assert_eq!(found, Some(error.into()));
}

#[test]
fn contents_that_lie_are_refused() {
    let (positions, bytes) = baked(true);
    let header = Blob::new(&bytes).unwrap().counts();
    let [_, shadow, .., in_f64] = header.sections().map(|section| section.start);
    let put = |at: usize, x: f64| {
        after(&bytes, |bytes| bytes[at..at + 8].copy_from_slice(&x.to_le_bytes()))
    };
    let is = |found, error: MeshError| assert_eq!(found, Some(BlobError::Mesh(error)));
    // The origin; a position; a coordinate of the shadow.
    is(put(in_f64, FAR[0] + 1.0), MeshError::Shadow { vertex: 0 });
    is(put(in_f64, f64::NAN), MeshError::Shadow { vertex: 0 });
    is(put(in_f64, 1e300), MeshError::Shadow { vertex: 0 });
    is(put(in_f64 + 24 + 48, positions[2][0] + 0.1), MeshError::Shadow { vertex: 2 });
    is(put(in_f64 + 24 + 48, f64::NAN), MeshError::NonFinite { vertex: 2 });
    is(put(in_f64 + 24 + 48, -1e38), MeshError::Range { vertex: 2 });
    let found = after(&bytes, |bytes| bytes[shadow + 14] ^= 1);
    is(found, MeshError::Shadow { vertex: 1 });

    // A mesh that says to be in f32, or the other kind of f64, has another length.
    for kind in [1, 2] {
        let found = after(&bytes, |bytes| bytes[26] = kind);
        assert!(matches!(found, Some(BlobError::Length { .. })), "{found:?}");
    }
    let (_, near) = baked(false);
    assert_eq!(after(&near, |bytes| bytes[26] = 1), None);
    let found = after(&near, |bytes| bytes[26] = 3);
    assert!(matches!(found, Some(BlobError::Length { .. })), "{found:?}");
    let far = |bytes: &mut [u8]| bytes[shadow..shadow + 4].copy_from_slice(&1e38_f32.to_le_bytes());
    is(after(&near, far), MeshError::Range { vertex: 0 });
}
