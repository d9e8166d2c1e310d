//! Mesh files of arbitrary bytes in every format: refused, or read into what a model takes or refuses.

#![no_main]

use libfuzzer_sys::fuzz_target;
use pfront::Model;
use pfront_files::{Contents, FORMATS, ReadOptions, read_bytes};

fuzz_target!(|bytes: &[u8]| {
    let Some((&format, bytes)) = bytes.split_first() else { return };
    let format = FORMATS[usize::from(format) % FORMATS.len()];
    let options = ReadOptions { format: Some(format.to_owned()), ..ReadOptions::default() };
    match read_bytes(bytes, &options) {
        Ok(Contents::Mesh(file)) => {
            let mesh = file.mesh.into_f32();
            let vertices = mesh.positions.len();
            assert!(mesh.triangles.as_flattened().iter().all(|&v| (v as usize) < vertices));
            let is_finite = mesh.positions.as_flattened().iter().all(|x| x.is_finite());
            assert_eq!(Model::new(mesh.positions, mesh.triangles).is_ok(), is_finite);
        }
        Ok(Contents::Baked(bytes)) => drop(Model::from_blob(&bytes)),
        Err(_) => {}
    }
});
