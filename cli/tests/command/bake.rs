//! `pfront bake`: what it writes is read by every command, with the same answers.

use super::{folder, out, refused};
use pfront::{Blob, Model};
use std::fs;

#[test]
fn a_baked_mesh_answers_as_the_mesh_does() {
    let folder = folder();
    let at = folder.path();
    let said = out(at, "bake a.obj");
    assert!(said.starts_with("a.obj: 4 triangles, 4 vertices, 1 nodes; see a.pfb\n"), "{said}");
    for row in ["header", "nodes", "positions", "triangles", "order", "all"] {
        assert!(said.lines().any(|line| line.trim_start().starts_with(row)), "no {row} in {said}");
    }
    let bytes = fs::read(at.join("a.pfb")).unwrap();
    assert_eq!(
        said.lines().last().unwrap().split_whitespace().nth(1),
        Some(&*bytes.len().to_string())
    );
    let expected = out(at, "pairs a.obj b.obj --csv");
    assert_eq!(out(at, "pairs a.pfb b.obj --csv"), expected);
    assert_eq!(out(at, "self a.pfb --weld"), out(at, "self a.obj --weld"));
    out(at, "bake a.pfb --out again.pfb");
    assert_eq!(fs::read(at.join("again.pfb")).unwrap(), bytes);
}

#[test]
fn a_mesh_is_baked_as_one_likes() {
    let folder = folder();
    let at = folder.path();
    for build in ["sah", "morton"] {
        out(at, &format!("bake a.obj -o {build}.pfb --build {build} --leaf-size 1"));
        let bytes = fs::read(at.join(format!("{build}.pfb"))).unwrap();
        assert_eq!(Blob::new(&bytes).unwrap().counts().nodes, 8);
        assert_eq!(Model::from_blob(&bytes).unwrap().bvh().order().len(), 4);
    }
    fs::create_dir(at.join("folder")).unwrap();
    fs::copy(at.join("a.obj"), at.join("folder/inner.obj")).unwrap();
    assert!(out(at, "bake folder/inner.obj").contains("see inner.pfb"));
    assert!(at.join("inner.pfb").exists());
    fs::write(at.join("nan.obj"), "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n").unwrap();
    for (arguments, part) in [
        ("bake a.obj --leaf-size 9", "--leaf-size"),
        ("bake a.obj --leaf-size 0", "--leaf-size"),
        ("bake nan.obj", "vertex 2"),
        ("bake a.obj -o no/such/folder.pfb", "no/such/folder.pfb"),
    ] {
        assert!(refused(at, arguments).contains(part), "{arguments}");
    }
    assert!(!at.join("a.pfb").exists() && !at.join("nan.pfb").exists());
}
