//! Meshes that move, refitted on the device, against the core's refit.

use crate::common::{Both, gpu, sorted, truth};
use pfront_core::{MeshError, Pose, bvtt};
use pfront_gpu::{Budget, Deforming, GpuError, GpuQuery, GpuQuestion, GpuSettings};
use pfront_testkit::scenes::Scene;
use pfront_testkit::shapes::{bumpy, sheet, sphere};

#[test]
fn a_sheet_that_folds() {
    let scene = Scene::by_name("sheet", Some(20_000)).unwrap();
    let mut positions = Vec::new();
    scene.positions(0, &mut positions);
    let mut sheet = Both::new(&positions, &scene.meshes[0].triangles, 4);
    let soup = sphere(16).map(|p| p.map(|x| x * 0.3));
    let ball = Both::new(&soup.positions, &soup.triangles, 4);
    let mut moving = Deforming::new(gpu(), sheet.bvh()).unwrap();
    let (mut own, mut pair) = (GpuQuery::new(gpu()).unwrap(), GpuQuery::new(gpu()).unwrap());
    let mut found = 0;
    for frame in (0..scene.frames()).step_by(scene.frames() / 5).skip(1) {
        scene.positions(frame, &mut positions);
        moving.set_positions(&positions).unwrap();
        sheet.set_positions(&positions);
        let within = sorted(&bvtt::SelfBvtt::new(sheet.bvh()));
        assert!(own.all(&GpuQuestion::itself(&moving)).unwrap() == within, "frame {frame}");
        let pose = Pose::from_translation(positions[frame]);
        assert!(
            pair.all(&GpuQuestion::pair(&moving, &ball.model, &pose)).unwrap()
                == truth(&sheet, &ball, &pose)
        );
        found += within.len();
    }
    assert!(found > 0);
}

/// The parts that a question about a flat sheet was divided into cover the same sheet crumpled.
#[test]
fn parts_serve_other_positions() {
    let flat = bumpy(60);
    let mut core = Both::new(&flat.positions, &flat.triangles, 4);
    let mut moving = Deforming::new(gpu(), core.bvh()).unwrap();
    let settings = GpuSettings { budget: Budget::LEAST, ..gpu().settings() };
    let mut query = GpuQuery::with_settings(gpu(), settings).unwrap();
    let (mut found, mut runs) = (0, 0);
    for fold in [0.0, 1.0, 0.0, -0.7, 0.3] {
        let crumple =
            |p: &[f32; 3]| [p[0] * (1.0 - fold * p[0].abs()), p[1], p[2] + fold * p[0] * p[1]];
        let positions: Vec<_> = flat.positions.iter().map(crumple).collect();
        moving.set_positions(&positions).unwrap();
        core.set_positions(&positions);
        let truth = sorted(&bvtt::SelfBvtt::new(core.bvh()));
        assert_eq!(query.all(&GpuQuestion::itself(&moving)).unwrap(), truth, "{fold}");
        (found, runs) = (found + truth.len(), runs.max(query.report().runs));
    }
    assert!(found > 0 && runs > 1, "{found} {runs}");
}

#[test]
fn positions_at_the_ends_of_the_range() {
    let soup = sheet(12, |x, y| x * y);
    let mut mesh = Both::new(&soup.positions, &soup.triangles, 2);
    let mut moving = Deforming::new(gpu(), mesh.bvh()).unwrap();
    let mut own = GpuQuery::new(gpu()).unwrap();
    for scale in [f32::from_bits(7), f32::MIN_POSITIVE, -1e-20, 1e38, -0.0] {
        let crumple = |[x, y, z]: [f32; 3]| [(x * 9.0).sin(), (y * 7.0).cos() * z, x - y];
        let positions: Vec<_> =
            soup.positions.iter().map(|&p| crumple(p).map(|x| x * scale)).collect();
        moving.set_positions(&positions).unwrap();
        mesh.set_positions(&positions);
        assert!(
            own.all(&GpuQuestion::itself(&moving)).unwrap()
                == sorted(&bvtt::SelfBvtt::new(mesh.bvh()))
        );
    }
}

#[test]
fn positions_that_do_not_fit_change_nothing() {
    let soup = sheet(2, |_, _| 0.0);
    let mesh = Both::new(&soup.positions, &soup.triangles, 4);
    let mut moving = Deforming::new(gpu(), mesh.bvh()).unwrap();
    let refused = moving.set_positions(&soup.positions[1..]).unwrap_err();
    assert_eq!(refused, GpuError::Mesh(MeshError::VertexCount { expected: 9, found: 8 }));
    let mut broken = soup.positions.clone();
    broken[4][1] = f32::INFINITY;
    let refused = moving.set_positions(&broken).unwrap_err();
    assert_eq!(refused, GpuError::Mesh(MeshError::NonFinite { vertex: 4 }));
    let empty = Both::new(&[], &[], 4);
    let mut moving = Deforming::new(gpu(), empty.bvh()).unwrap();
    moving.set_positions(&[]).unwrap();
    assert_eq!(GpuQuery::new(gpu()).unwrap().all(&GpuQuestion::itself(&moving)).unwrap(), []);
}
