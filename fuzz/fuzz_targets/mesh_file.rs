//! Mesh files of arbitrary bytes in every format: refused, or read into what a model takes or refuses.

#![no_main]

use libfuzzer_sys::fuzz_target;
use pfront::Model;
use pfront_cli::mesh::{FORMATS, read_bytes};

fuzz_target!(|bytes: &[u8]| {
    let Some((&format, bytes)) = bytes.split_first() else { return };
    let format = FORMATS[usize::from(format) % FORMATS.len()];
    if let Some(mesh) = read_bytes(format, bytes) {
        let triangles = mesh.triangles.len();
        let welded = mesh.clone().welded();
        assert_eq!(welded.triangles.len(), triangles);
        let is_mesh = Model::new(mesh.positions, mesh.triangles).is_ok();
        assert_eq!(Model::new(welded.positions, welded.triangles).is_ok(), is_mesh);
    }
});
