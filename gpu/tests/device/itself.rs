//! One mesh with itself: every way of sharing vertices, smooth, folded and flat surfaces.

use crate::common::{Both, gpu, sorted};
use pfront_core::bvtt;
use pfront_core::triangle::Adjacency;
use pfront_gpu::{Budget, GpuQuery, GpuQuestion, GpuSettings};
use pfront_testkit::MeshData;
use pfront_testkit::families::Family;
use pfront_testkit::rng::seeded;
use pfront_testkit::scenes::Scene;
use pfront_testkit::shapes::{family, sheet, sphere, tangle, union};

/// Checks every verb under both rules and returns how many pairs meet.
fn check(query: &mut GpuQuery, mesh: &Both) -> usize {
    let mut most = 0;
    for adjacency in [Adjacency::SkipNeighbours, Adjacency::SharedIndexRule] {
        let truth = sorted(&bvtt::SelfBvtt::new(mesh.bvh()).with_adjacency(adjacency));
        let question = GpuQuestion::Itself { model: &mesh.model, adjacency };
        assert_eq!(query.all(&question).unwrap(), truth);
        assert_eq!(query.count(&question).unwrap(), truth.len() as u64);
        let any = query.any(&question).unwrap();
        assert!(any.map_or(truth.is_empty(), |pair| truth.binary_search(&pair).is_ok()));
        most = truth.len();
    }
    most
}

fn both(soup: &MeshData, leaf_size: u32) -> Both {
    Both::new(&soup.positions, &soup.triangles, leaf_size)
}

#[test]
fn a_deforming_sheet() {
    let mut query = GpuQuery::new(gpu()).unwrap();
    let scene = Scene::by_name("sheet", Some(6_000)).unwrap();
    let (mut positions, mut found) = (Vec::new(), 0);
    for frame in (0..scene.frames()).step_by(scene.frames() / 6) {
        scene.positions(frame, &mut positions);
        found += check(&mut query, &Both::new(&positions, &scene.meshes[0].triangles, 4));
    }
    assert!(found > 0);
    assert_eq!(query.report().on_cpu, 0);
}

#[test]
fn flat_folded_and_coinciding_surfaces() {
    let mut query = GpuQuery::new(gpu()).unwrap();
    let flat = sheet(12, |_, _| 0.0);
    let tilted = sheet(12, |x, _| x);
    let rolled = sheet(18, |_, _| 0.0).map(|[x, y, _]| [(4.0 * x).cos(), (4.0 * x).sin() * 0.9, y]);
    let folded = sheet(12, |_, _| 0.0).map(|[x, y, z]| [x.abs(), y, z]);
    let balls = [sphere(16), sphere(16).map(|[x, y, z]| [x + 0.5, y, z])];
    let soups = [flat.clone(), rolled, folded, union(&balls), union(&[flat.clone(), flat, tilted])];
    for (soup, leaf_size) in soups.iter().zip([1, 4].into_iter().cycle()) {
        check(&mut query, &both(soup, leaf_size));
    }
    let settings = GpuSettings { budget: Budget::LEAST, depth: 1, ..gpu().settings() };
    let mut query = GpuQuery::with_settings(gpu(), settings).unwrap();
    let balls = [sphere(8), sphere(8).map(|[x, y, z]| [x + 0.5, y, z])];
    assert!(check(&mut query, &both(&union(&balls), 8)) > 0);
}

#[test]
fn tangles_of_shared_indices() {
    let mut rng = seeded(21);
    let mut query = GpuQuery::new(gpu()).unwrap();
    for size in [0, 1, 3, 20] {
        for vertices in [1, 3, 5, 8, 40] {
            check(&mut query, &both(&tangle(vertices, 100, size, &mut rng), 4));
        }
    }
}

#[test]
fn pairs_of_every_family_that_share_indices() {
    let mut rng = seeded(22);
    let mut query = GpuQuery::new(gpu()).unwrap();
    for (f, leaf_size) in Family::ALL.into_iter().zip([2, 8].into_iter().cycle()) {
        let mut soup = MeshData::default();
        for _ in 0..100 {
            let (positions, a, b) = f.indexed(&mut rng);
            let first = soup.positions.len() as u32;
            soup.positions.extend(positions);
            soup.triangles.extend([a, b].map(|t| t.map(|v| v + first)));
        }
        check(&mut query, &both(&union(&[soup, family(f, 28, &mut rng)]), leaf_size));
    }
}
