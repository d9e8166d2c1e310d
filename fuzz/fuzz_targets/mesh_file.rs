//! Mesh files of arbitrary bytes in every format: refused, or read into what a model takes or refuses.

#![no_main]

use libfuzzer_sys::fuzz_target;
use pfront::Model;
use pfront::pfront_blob::MAGIC;
use pfront_files::{Contents, FORMATS, ReadOptions, read_bytes};
use pfront_fuzz::seal;

fuzz_target!(|bytes: &[u8]| {
    let Some((&how, bytes)) = bytes.split_first() else { return };
    let format = FORMATS[usize::from(how) % FORMATS.len()];
    let in_f32 = usize::from(how) / FORMATS.len() % 2 == 1;
    let format_option = Some(format.to_owned());
    let options = ReadOptions { format: format_option, in_f32, ..ReadOptions::default() };
    let mut bytes = bytes.to_vec();
    // Magic, length and checksum would take long to guess.
    if format == "pfb" && bytes.len() >= 24 {
        let length = bytes.len() as u64;
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[16..24].copy_from_slice(&length.to_le_bytes());
        seal(&mut bytes);
    }
    let Ok(contents) = read_bytes(&bytes, &options) else { return };
    let model = match &contents {
        Contents::Baked(bytes) => Some(Model::from_blob(bytes)),
        Contents::Mesh(_) => None,
    };
    let read = contents.into_mesh("mesh".as_ref());
    if let Some(model) = &model {
        assert!(model.is_err() || read.is_ok(), "the BVH of a model whose mesh is refused");
    }
    let Ok(file) = read else { return };
    let mesh = file.mesh.into_f32();
    let vertices = mesh.positions.len();
    assert!(mesh.triangles.as_flattened().iter().all(|&v| (v as usize) < vertices));
    let is_finite = mesh.positions.as_flattened().iter().all(|x| x.is_finite());
    assert_eq!(Model::new(mesh.positions, mesh.triangles).is_ok(), is_finite);
});
