//! Meshes: closed, turned outward, free of self-crossings, of the right size, reproducible.

use pfront_testkit::scenes::{Kind, Scene, SceneError, icosphere, torus_knot};
use pfront_testkit::{MeshData, Rows};

use crate::oracle::{assert_closed, directed_edges};

fn scene(name: &str, size: Option<usize>) -> Scene {
    Scene::by_name(name, size).expect("a named scene")
}

#[test]
fn solids_are_closed_and_face_outward_at_every_size() {
    for size in [None, Some(0), Some(2_000), Some(17_000), Some(200_000)] {
        for name in ["worm-gear", "torus-knots", "course"] {
            scene(name, size).meshes.iter().for_each(|mesh| assert_closed(mesh, 1));
        }
        scene("spheres", size).meshes.iter().for_each(|mesh| assert_closed(mesh, 0));
    }
}

#[test]
fn the_sheet_is_a_disc_turned_one_way() {
    for size in [0, 900, 92_000] {
        let mesh = &scene("sheet", Some(size)).meshes[0];
        let edges = directed_edges(mesh);
        let border = edges.iter().filter(|&&(a, b)| !edges.contains(&(b, a))).count();
        let all_edges = (edges.len() + border) / 2;
        assert_eq!(mesh.positions.len() + mesh.triangles.len(), all_edges + 1);
        assert!(border > 0);
    }
}

#[test]
fn default_sizes_are_those_of_the_paper() {
    for (name, objects, triangles) in
        [("worm-gear", 2, 64_000), ("swarm", 17, 149_000), ("sheet", 1, 92_000)]
    {
        let scene = scene(name, None);
        assert_eq!(scene.objects.len(), objects);
        let off = scene.triangles().abs_diff(triangles);
        assert!(off * 50 <= triangles, "{name} has {}", scene.triangles());
    }
}

#[test]
fn sizes_are_met_roughly() {
    for name in Scene::NAMES {
        for size in [100_000, 300_000, 1_000_000] {
            let got = scene(name, Some(size)).triangles();
            assert!(got.abs_diff(size) * 20 <= size, "{name} {size}: {got}");
        }
    }
    assert!(icosphere(5_000).triangles.len().abs_diff(5_000) < 500);
    assert!(torus_knot(5_000).triangles.len().abs_diff(5_000) < 500);
}

#[test]
fn errors_say_what_to_do() {
    let unknown = Scene::by_name("gears", None).expect_err("no such scene");
    for name in Scene::NAMES {
        assert!(unknown.to_string().contains(name));
        assert_eq!(scene(name, Some(0)).name, name);
    }
    let size = usize::MAX;
    assert_eq!(
        Scene::by_name("sheet", Some(size)).expect_err("too large"),
        SceneError::TooLarge { size }
    );
}

/// Over the bits of meshes, poses and positions: the same on every platform, or a scene has changed and measured records
/// no longer compare.
#[test]
fn scenes_have_the_recorded_bits() {
    let recorded = [
        ("worm-gear", 0x9218_612a_d64a_4e9f),
        ("swarm", 0x1b3e_7e3c_22e4_7f11),
        ("crowd", 0x837d_9092_6ed9_41a8),
        ("sheet", 0x4c86_e851_7598_eb95),
        ("torus-knots", 0x35a6_17eb_10cc_9d82),
        ("spheres", 0x695e_1063_bbd4_d6e6),
        ("course", 0x2caf_3687_d36b_91d5),
    ];
    assert_eq!(recorded.map(|(name, _)| (name, bits(&scene(name, None)))), recorded);
}

fn bits(scene: &Scene) -> u64 {
    let mut words: Vec<u32> = scene.meshes.iter().flat_map(mesh_words).collect();
    let (mut poses, mut positions) = (Vec::<Rows>::new(), Vec::new());
    for frame in [0, 1, 59, 119] {
        scene.poses(frame, &mut poses);
        words.extend(poses.as_flattened().as_flattened().iter().map(|x| x.to_bits()));
        if scene.kind() == Kind::SelfMesh {
            scene.positions(frame, &mut positions);
            words.extend(positions.as_flattened().iter().map(|x| x.to_bits()));
        }
    }
    pfront_testkit::checksum(words.into_iter().flat_map(u32::to_le_bytes))
}

fn mesh_words(mesh: &MeshData) -> Vec<u32> {
    let positions = mesh.positions.as_flattened().iter().map(|x| x.to_bits());
    positions.chain(mesh.triangles.as_flattened().iter().copied()).collect()
}
