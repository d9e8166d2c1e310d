//! Blobs of arbitrary bytes, and good ones that were tampered with under a right checksum: refused with an error,
//! or answered right, borrowed as well as copied, and written again to the same bytes.

#![no_main]

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use pfront::pfront_blob::{self, Counts, MAGIC};
use pfront::pfront_core::bvtt;
use pfront::{Blob, BlobError, Mesh, Model, SelfQuery, TrianglePair};
use pfront_fuzz::input::Palette;
use pfront_fuzz::{Builder, Tree, as_pairs, pages, seal};
use pfront_testkit::oracle::self_pairs;

#[derive(Arbitrary, Debug)]
struct Input {
    raw: Vec<u8>,
    /// The coordinates that `positions` and `moved` pick from.
    palette: Palette,
    positions: Vec<[u8; 3]>,
    triangles: Vec<[u8; 3]>,
    moved: Vec<[u8; 3]>,
    leaf_size: u8,
    builder: Builder,
    /// How far from where it should the blob begins.
    shift: u8,
    /// Words to change.
    edits: Vec<(u8, u32)>,
}

fuzz_target!(|input: Input| {
    // The magic would take long to guess.
    for mut bytes in [input.raw.clone(), [&MAGIC[..], &1_u32.to_le_bytes(), &input.raw].concat()] {
        let _ = Blob::new(&bytes);
        seal(&mut bytes);
        check(&bytes, &input);
    }

    let positions = input.palette.points(&input.positions);
    let range = positions.len().max(1) as u32;
    let triangles: Vec<_> =
        input.triangles.iter().take(24).map(|t| t.map(|v| u32::from(v) % range)).collect();
    let Ok(mesh) = Mesh::new(&positions, &triangles) else { return };
    let tree = Tree::new(mesh, input.leaf_size.into(), input.builder);
    let bvh = tree.bvh(mesh);
    let mut bytes = vec![0xaa; Counts::of(&bvh).bytes()];
    pfront_blob::write(&bvh, &mut bytes).unwrap();
    assert!(check(&bytes, &input));
    for &(at, word) in &input.edits {
        let at = 4 * usize::from(at);
        if let Some(old) = bytes.get_mut(at..at + 4) {
            old.copy_from_slice(&word.to_le_bytes());
        }
    }
    seal(&mut bytes);
    check(&bytes, &input);
});

/// Whether bytes are a blob of a BVH; what is must answer right.
fn check(bytes: &[u8], input: &Input) -> bool {
    let model = Model::from_blob(bytes);
    let shift = usize::from(input.shift % 8);
    let mut place = vec![0_u64; bytes.len() / 8 + 2];
    let place: &mut [u8] = bytemuck::cast_slice_mut(&mut place);
    let place = &mut place[shift..][..bytes.len()];
    place.copy_from_slice(bytes);
    let Ok(blob) = Blob::new(place) else {
        assert!(model.is_err());
        return false;
    };
    let mut scratch = vec![0; blob.counts().triangles.div_ceil(32)];
    match (blob.bvh(&mut scratch), &model) {
        (Err(BlobError::Misaligned { .. }), _) => assert_ne!(shift % 4, 0),
        (Err(_), Err(_)) => {}
        (Ok(bvh), Ok(_)) => {
            let mut again = vec![0xaa; bytes.len()];
            assert_eq!(pfront_blob::write(&bvh, &mut again).unwrap(), bytes);
            assert_eq!(pages(&bvtt::SelfBvtt::new(bvh), 7), truth(bvh.mesh()));
        }
        (borrowed, copied) => panic!("borrowed: {borrowed:?}, copied: {copied:?}"),
    }
    let Ok(mut model) = model else { return false };
    assert_eq!(SelfQuery::new().all(&model).unwrap(), truth(model.mesh()));
    let moved = input.palette.points(&input.moved);
    if model.set_positions(&moved).is_ok() {
        model.bvh().assert_well_formed();
        assert_eq!(SelfQuery::new().all(&model).unwrap(), truth(model.mesh()));
    }
    true
}

fn truth(mesh: Mesh<'_>) -> Vec<TrianglePair> {
    as_pairs(&self_pairs(mesh.positions().unwrap(), mesh.triangles()))
}
