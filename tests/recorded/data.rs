//! Recorded data: where it lies, and what of it both backends are asked.
//!
//! It may not be redistributed. It is looked for in `$PFRONT_DATA`, else in `../shared/data` beside the
//! checkout; without it the tests fail.

use pfront::{Pose, TrianglePair};
use pfront_files::{ReadOptions, TriangleMesh, open};
use pfront_testkit::MeshData;
use serde_json::Value;
use std::path::PathBuf;

/// Two meshes and all their pairs, on which two independent programs agreed.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) a: MeshData,
    pub(crate) b: MeshData,
    pub(crate) a_from_b: Pose,
    /// `b` in the frame of `a`, as it was posed when the pairs were recorded, if that is known.
    pub(crate) b_world: Option<MeshData>,
    pub(crate) pairs: Vec<TrianglePair>,
}

/// Every case of `oracle/cases.json`, read one after the other.
pub(crate) fn cases() -> impl Iterator<Item = Case> {
    let text = String::from_utf8(bytes("oracle/cases.json")).unwrap();
    let cases: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(cases.len(), 9);
    cases.into_iter().map(|case| {
        let string = |key: &str| case[key].as_str().unwrap();
        let (name, b) = (string("name"), mesh(string("b")));
        let pairs: Vec<_> = words(&format!("oracle/{name}.pairs.u32le"))
            .chunks_exact(2)
            .map(|pair| TrianglePair { a: pair[0], b: pair[1] })
            .collect();
        assert_eq!(case["pairs"], pairs.len(), "{name}");
        let world = format!("oracle/{name}.b_world.f32le");
        let world = data().join(&world).exists().then(|| vectors(&world));
        Case {
            name: name.to_owned(),
            a: mesh(string("a")),
            a_from_b: pose(&case),
            b_world: world.map(|positions| MeshData { positions, triangles: b.triangles.clone() }),
            b,
            pairs,
        }
    })
}

/// Pairs of files in `nasty/` with the number of pairs in f64, where rounding them to f32 changes it to 27 and 95.
pub(crate) const NASTY_PAIRS_IN_F64: [(&str, &str, u64); 2] =
    [("Offset3.obj", "Offset4.obj", 29), ("Havocglass8_left.obj", "Havocglass8_right.obj", 89)];

/// A file of `nasty/` as its decimals say.
pub(crate) fn model_in_f64(file: &str) -> pfront::Model {
    let path = data().join("nasty").join(file);
    let contents = open(&path, &ReadOptions::default()).unwrap();
    let TriangleMesh { positions, triangles } = contents.into_mesh(&path).unwrap().mesh;
    pfront::Model::from_f64(positions, triangles).unwrap()
}

/// Pairs of files in `nasty/`.
///
/// Counts are from `README.md` of the data where they are of f32 coordinates. Rounding those of the file
/// from f64 leaves 27 of 29 pairs for `Offset3` and makes 95 of 89 for `Havocglass8`.
pub(crate) const NASTY_PAIRS: [(&str, &str, Option<usize>); 9] = [
    ("ballA.off", "ballB.off", Some(276)),
    ("self_intersectA.obj", "self_intersectB.obj", Some(600)),
    ("Offset3.obj", "Offset4.obj", Some(27)),
    ("Havocglass8_left.obj", "Havocglass8_right.obj", Some(95)),
    ("center_cylinder.obj", "offset_cylinder.obj", Some(72)),
    ("elephant.off", "elephant-with-holes.off", None),
    ("patch-20.off", "patch-21.off", None),
    ("stairs.obj", "wallhole.obj", None),
    ("degtri_sliding.off", "degtri_sliding.off", None),
];

/// Files in `nasty/` that meet themselves.
pub(crate) const NASTY_SELVES: [&str; 12] = [
    "ballA.off",
    "cylinder_locally_refined.off",
    "degtri_sliding.off",
    "elephant-with-holes.off",
    "issue289_1.obj",
    "patch-20.off",
    "same_mesh_far_from_origin.obj",
    "self_intersectA.obj",
    "self_intersectB.obj",
    "soup.stl",
    "stairs.obj",
    "wallhole.obj",
];

pub(crate) fn mesh(file: &str) -> MeshData {
    let read = pfront_files::read_f32(&data().join(file)).unwrap();
    MeshData { positions: read.positions, triangles: read.triangles }
}

/// Little-endian f32 triples.
pub(crate) fn vectors(file: &str) -> Vec<[f32; 3]> {
    words(file).chunks_exact(3).map(|p| [p[0], p[1], p[2]].map(f32::from_bits)).collect()
}

pub(crate) fn data() -> PathBuf {
    let folder = pfront_testkit::data_folder();
    assert!(
        folder.join("oracle/cases.json").exists(),
        "no test data in {}: set PFRONT_DATA to the folder with oracle/cases.json and nasty/, or \
         run without --features recorded",
        folder.display()
    );
    folder
}

fn pose(case: &Value) -> Pose {
    let number = |key: &str, i: usize| case[key][i].as_f64().unwrap() as f32;
    Pose::new([0, 1, 2].map(|row| {
        let [x, y, z] = [0, 1, 2].map(|k| number("rotation_row_major", 3 * row + k));
        [x, y, z, number("translation", row)]
    }))
}

fn words(file: &str) -> Vec<u32> {
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
    bytes(file).chunks_exact(4).map(word).collect()
}

fn bytes(file: &str) -> Vec<u8> {
    let path = data().join(file);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
