//! Trees built on the device give the answers of the core, whatever the mesh.

use crate::common::{Both, gpu, sorted, truth};
use pfront_core::bvh::BuildOptions;
use pfront_core::{Mesh, MeshError, Pose, bvtt};
use pfront_gpu::{Deforming, GpuError, GpuQuery, GpuQuestion, GpuVerb, wgpu};
use pfront_testkit::scenes::{Scene, torus_knot};
use pfront_testkit::shapes::{bumpy, sheet, sphere};

fn build(positions: &[[f32; 3]], triangles: &[[u32; 3]], leaf_size: u32) -> Deforming {
    let mesh = Mesh::new(positions, triangles).unwrap();
    Deforming::build(gpu(), mesh, &BuildOptions { leaf_size, ..BuildOptions::default() }).unwrap()
}

#[test]
fn a_sheet_that_folds_refitted_and_rebuilt() {
    let scene = Scene::by_name("sheet", Some(20_000)).unwrap();
    let mut positions = Vec::new();
    scene.positions(0, &mut positions);
    let triangles = &scene.meshes[0].triangles;
    let mut sheet = Both::new(&positions, triangles, 4);
    let soup = sphere(16).map(|p| p.map(|x| x * 0.3));
    let ball = Both::new(&soup.positions, &soup.triangles, 4);
    let mut built = build(&positions, triangles, 4);
    let mut given = Deforming::new(gpu(), sheet.bvh()).unwrap();
    let (mut own, mut pair) = (GpuQuery::new(gpu()).unwrap(), GpuQuery::new(gpu()).unwrap());
    let mut found = 0;
    for (step, frame) in (0..scene.frames()).step_by(scene.frames() / 6).skip(1).enumerate() {
        scene.positions(frame, &mut positions);
        match step % 3 {
            0 => built.set_positions(&positions).unwrap(),
            1 => built.rebuild_at(&positions).unwrap(),
            _ => {
                built.set_positions(&positions).unwrap();
                built.rebuild().unwrap();
            }
        }
        match step {
            2 => given.rebuild_at(&positions).unwrap(),
            _ => given.set_positions(&positions).unwrap(),
        }
        sheet.set_positions(&positions);
        let within = sorted(&bvtt::SelfBvtt::new(sheet.bvh()));
        assert!(own.all(&GpuQuestion::itself(&built)).unwrap() == within, "frame {frame}");
        assert!(own.all(&GpuQuestion::itself(&given)).unwrap() == within, "frame {frame}");
        let pose = Pose::from_translation(positions[frame]);
        let met = truth(&sheet, &ball, &pose);
        assert!(
            pair.all(&GpuQuestion::pair(&built, &ball.model, &pose)).unwrap() == met,
            "frame {frame}"
        );
        assert!(
            pair.all(&GpuQuestion::pair(&given, &ball.model, &pose)).unwrap() == met,
            "frame {frame}"
        );
        found += within.len() + met.len();
    }
    assert!(found > 0);
}

#[test]
fn a_frame_in_one_submission() {
    let knot = torus_knot(6_000);
    let mesh = Both::new(&knot.positions, &knot.triangles, 4);
    let flat: Vec<_> = knot.positions.iter().map(|&[x, y, _]| [x, y, 0.0]).collect();
    let mut built = build(&flat, &knot.triangles, 4);
    let mut own = GpuQuery::new(gpu()).unwrap();
    let pose = Pose::from_translation([0.5, 0.0, 0.0]);
    let mut encoder = gpu().device().create_command_encoder(&Default::default());
    built.record_rebuild_at(&mut encoder, &knot.positions).unwrap();
    let question = GpuQuestion::pair(&built, &mesh.model, &pose);
    own.record(&mut encoder, &question, GpuVerb::All).unwrap();
    gpu().queue().submit([encoder.finish()]);
    let mut pairs = Vec::new();
    own.read(&mut pairs).unwrap();
    assert!(pairs == truth(&mesh, &mesh, &pose));
}

#[test]
fn two_built_trees() {
    let knot = torus_knot(6_000);
    let ball = sphere(24);
    for leaf_size in [1, 3, 8] {
        let a = Both::new(&knot.positions, &knot.triangles, leaf_size);
        let b = Both::new(&ball.positions, &ball.triangles, leaf_size);
        let [own_a, own_b] = [
            build(&knot.positions, &knot.triangles, leaf_size),
            build(&ball.positions, &ball.triangles, leaf_size),
        ];
        let mut pair = GpuQuery::new(gpu()).unwrap();
        for x in [0.0, 0.7, 1.5] {
            let pose = Pose::from_translation([x, 0.1, 0.0]);
            let met = truth(&a, &b, &pose);
            assert!(pair.all(&GpuQuestion::pair(&own_a, &own_b, &pose)).unwrap() == met);
            assert!(pair.all(&GpuQuestion::pair(&own_a, &b.model, &pose)).unwrap() == met);
        }
    }
}

#[test]
fn any_number_of_triangles() {
    let whole = bumpy(16);
    for n in [0, 1, 2, 3, 4, 5, 16, 17, 127, 129, 255, 256, 257, 511] {
        let triangles = &whole.triangles[..n];
        let tangled: Vec<_> = whole.positions.iter().map(|&[x, y, z]| [z, x * y, z * x]).collect();
        let mesh = Both::new(&tangled, triangles, 4);
        let mut built = build(&whole.positions, triangles, 4);
        built.rebuild_at(&tangled).unwrap();
        let mut own = GpuQuery::new(gpu()).unwrap();
        assert_eq!(
            own.all(&GpuQuestion::itself(&built)).unwrap(),
            sorted(&bvtt::SelfBvtt::new(mesh.bvh())),
            "{n}"
        );
    }
}

#[test]
fn positions_at_the_ends_of_the_range() {
    let soup = sheet(12, |x, y| x * y);
    let mut mesh = Both::new(&soup.positions, &soup.triangles, 4);
    let mut built = build(&soup.positions, &soup.triangles, 4);
    let mut own = GpuQuery::new(gpu()).unwrap();
    for scale in [f32::from_bits(7), f32::MIN_POSITIVE, -1e-20, 1.6e38, -0.0, 0.0] {
        let crumple = |[x, y, z]: [f32; 3]| [(x * 9.0).sin(), (y * 7.0).cos() * z, x - y];
        let positions: Vec<_> =
            soup.positions.iter().map(|&p| crumple(p).map(|x| x * scale)).collect();
        mesh.set_positions(&positions);
        let within = sorted(&bvtt::SelfBvtt::new(mesh.bvh()));
        built.rebuild_at(&positions).unwrap();
        assert!(own.all(&GpuQuestion::itself(&built)).unwrap() == within, "{scale:e}");
    }
}

#[test]
fn all_triangles_in_one_place() {
    let (corners, triangles) = ([[0.5; 3], [1.5, 0.5, 0.5], [0.5, 1.5, 0.5]], [[0, 1, 2]; 300]);
    for positions in [corners, [[0.5; 3]; 3]] {
        let mesh = Both::new(&positions, &triangles, 4);
        let built = build(&positions, &triangles, 4);
        let mut own = GpuQuery::new(gpu()).unwrap();
        assert_eq!(
            own.all(&GpuQuestion::itself(&built)).unwrap(),
            sorted(&bvtt::SelfBvtt::new(mesh.bvh()))
        );
        let mut pair = GpuQuery::new(gpu()).unwrap();
        let pose = Pose::from_translation([0.25, 0.25, 0.0]);
        assert!(
            pair.all(&GpuQuestion::pair(&built, &mesh.model, &pose)).unwrap()
                == truth(&mesh, &mesh, &pose)
        );
    }
}

#[test]
fn positions_that_do_not_fit_change_nothing() {
    let soup = sheet(2, |_, _| 0.0);
    let mut built = build(&soup.positions, &soup.triangles, 4);
    let refused = built.rebuild_at(&soup.positions[1..]).unwrap_err();
    assert_eq!(refused, GpuError::Mesh(MeshError::VertexCount { expected: 9, found: 8 }));
    let mut broken = soup.positions.clone();
    broken[4][1] = f32::NAN;
    let refused = built.rebuild_at(&broken).unwrap_err();
    assert_eq!(refused, GpuError::Mesh(MeshError::NonFinite { vertex: 4 }));
}

#[test]
fn passes_are_timed_if_the_device_can_tell() {
    let knot = torus_knot(2_000);
    let mut built = build(&knot.positions, &knot.triangles, 4).with_timings().unwrap();
    let passes = |built: &Deforming| -> Vec<_> {
        built.timings().unwrap().iter().map(|timing| timing.pass).collect()
    };
    built.rebuild().unwrap();
    let of_rebuild = passes(&built);
    built.set_positions(&knot.positions).unwrap();
    let of_refit = passes(&built);
    if gpu().device().features().contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES) {
        assert_eq!(of_rebuild[..4], ["survey", "keys", "scan", "scatter"]);
        assert_eq!(of_rebuild[of_rebuild.len() - 1], "fit");
        assert_eq!(of_refit, ["fit"]);
    } else {
        assert!(of_rebuild.is_empty() && of_refit.is_empty());
    }
    let mut built = built.with_time().unwrap();
    built.rebuild().unwrap();
    assert!(passes(&built).len() <= 1);
}
