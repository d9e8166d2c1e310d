//! Models as blobs: they come back as they were, and behave as the original does from then on; nothing in a
//! blob is trusted, whatever its checksum says.

use pfront::{Blob, BlobError, Bvh, Error, Executor, Model, Node, SelfQuery};
use pfront_blob::Counts;
use pfront_core::BvhError;
use pfront_testkit::MeshData;
use pfront_testkit::scenes::{Scene, icosphere, torus_knot};
use proptest::prelude::*;
use std::collections::VecDeque;

fn model(mesh: &MeshData) -> Model {
    Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
}

/// Puts the right checksum into a blob that was tampered with, by other code than the library's.
fn seal(bytes: &mut [u8]) {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[..12]);
    hasher.update(&bytes[16..]);
    bytes[12..16].copy_from_slice(&hasher.finalize().to_le_bytes());
}

fn pairs(model: &Model) -> Vec<pfront::TrianglePair> {
    SelfQuery::new().all(model).unwrap().to_vec()
}

#[test]
fn models_come_back() {
    let worm_gear = Scene::by_name("worm-gear", Some(4_000)).unwrap();
    let empty = MeshData { positions: Vec::new(), triangles: Vec::new() };
    let meshes = [empty, icosphere(1_280), torus_knot(6_000)];
    for mesh in meshes.iter().chain(&worm_gear.meshes) {
        let original = model(mesh);
        let mut bytes = original.to_blob().unwrap();
        assert_eq!(bytes.len(), Counts::of(&original.bvh()).bytes());
        let again = Model::from_blob(&bytes).unwrap();
        assert_eq!(again.mesh().positions().unwrap(), original.mesh().positions().unwrap());
        assert_eq!(again.mesh().triangles(), original.mesh().triangles());
        assert_eq!(again.bvh().nodes(), original.bvh().nodes());
        assert_eq!(again.bvh().order(), original.bvh().order());
        assert_eq!(again.to_blob().unwrap(), bytes);
        assert_eq!(pairs(&again), pairs(&original));
        let before = bytes.clone();
        seal(&mut bytes);
        assert_eq!(bytes, before, "the checksum is zlib's");
    }
}

/// A refit, a refit of few vertices and a rebuild do what they do to a model that was built.
#[test]
fn what_was_a_blob_deforms_as_if_built() {
    let knot = torus_knot(6_000);
    let mut built = model(&knot);
    let mut read = Model::from_blob(&built.to_blob().unwrap()).unwrap();
    let mut positions = knot.positions.clone();
    for round in 0..12 {
        let moving = if round % 3 == 0 { positions.len() } else { 40 };
        for (v, p) in positions.iter_mut().enumerate().take(moving) {
            p[v % 3] += 0.02 * (round as f32 - 5.0) * (v as f32).sin();
        }
        built.set_positions(&positions).unwrap();
        Executor::threads(2).refit(&mut read, &positions).unwrap();
        read.bvh().assert_well_formed();
        assert_eq!(pairs(&read), pairs(&built), "round {round}");
    }
}

/// The same tree, level by level.
fn breadth_first(nodes: &[Node]) -> Vec<Node> {
    let mut out = vec![nodes[0], Node::EMPTY];
    let mut waiting = VecDeque::from([0]);
    while let Some(at) = waiting.pop_front() {
        if !out[at].is_leaf() {
            let left = out[at].first as usize;
            out[at].first = out.len() as u32;
            waiting.extend([out.len(), out.len() + 1]);
            out.extend_from_slice(&nodes[left..left + 2]);
        }
    }
    out
}

#[test]
fn a_tree_that_no_build_has_laid_out_is_built_anew() {
    let ball = icosphere(20_000);
    let original = model(&ball);
    let nodes = breadth_first(original.bvh().nodes());
    let scratch = &mut vec![0; ball.triangles.len().div_ceil(32)];
    let foreign = Bvh::new(original.mesh(), &nodes, original.bvh().order(), scratch).unwrap();
    assert!(original.bvh().is_depth_first() && !foreign.is_depth_first());
    let mut bytes = vec![0; Counts::of(&foreign).bytes()];
    pfront_blob::write(&foreign, &mut bytes).unwrap();
    let mut read = Model::from_blob(&bytes).unwrap();
    assert!(read.bvh().is_depth_first());
    // A foreign tree would not survive these.
    read.set_positions(&vec![[1.0_f32; 3]; ball.positions.len()]).unwrap();
    read.bvh().assert_well_formed();
}

#[test]
fn boxes_that_are_too_large_are_made_tight() {
    let original = model(&icosphere(1_280));
    let mut nodes = original.bvh().nodes().to_vec();
    nodes[0].max = [9.0; 3];
    let loose = Bvh::new_unchecked(original.mesh(), &nodes, original.bvh().order());
    let mut bytes = vec![0; Counts::of(&loose).bytes()];
    pfront_blob::write(&loose, &mut bytes).unwrap();
    assert_eq!(Model::from_blob(&bytes).unwrap().bvh().nodes(), original.bvh().nodes());
}

#[test]
fn faults_are_errors_of_the_library() {
    let mut bytes = model(&icosphere(20)).to_blob().unwrap();
    assert_eq!(Model::from_blob(b"solid").err(), Some(Error::Blob(BlobError::Magic)));
    let last = bytes.len() - 4;
    bytes[last..].fill(0xff);
    assert!(matches!(Model::from_blob(&bytes), Err(Error::Blob(BlobError::Checksum { .. }))));
    seal(&mut bytes);
    let found = Model::from_blob(&bytes).err();
    assert_eq!(found, Some(Error::Blob(BlobError::Bvh(BvhError::Order { entry: 19 }))));
    // The first vertex lies behind the nodes.
    let first = 64 + 32 * Blob::new(&bytes).unwrap().counts().nodes;
    bytes[first..first + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    seal(&mut bytes);
    let found = Model::from_blob(&bytes).err();
    assert_eq!(found, Some(Error::Mesh(pfront::MeshError::NonFinite { vertex: 0 })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Words that an attacker puts under a right checksum are refused, or make a model that answers as one built of
    /// the same mesh does.
    #[test]
    fn tampering_is_refused_or_harmless(
        edits in prop::collection::vec((0_usize..600, prop_oneof![any::<u32>(), 0..40_u32]), 1..4),
    ) {
        let mut bytes = model(&icosphere(20)).to_blob().unwrap();
        for (word, new) in edits {
            let at = 8 + 4 * (word % ((bytes.len() - 8) / 4));
            bytes[at..at + 4].copy_from_slice(&new.to_le_bytes());
        }
        seal(&mut bytes);
        if let Ok(read) = Model::from_blob(&bytes) {
            read.bvh().assert_well_formed();
            let mesh = read.mesh();
            let built = Model::new(mesh.positions().unwrap().to_vec(), mesh.triangles().to_vec()).unwrap();
            prop_assert_eq!(pairs(&read), pairs(&built));
        }
    }

    #[test]
    fn bytes_of_any_kind_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let forged = [&pfront_blob::MAGIC[..], &1_u32.to_le_bytes(), &bytes].concat();
        prop_assert!(Model::from_blob(&bytes).is_err() && Model::from_blob(&forged).is_err());
    }
}
