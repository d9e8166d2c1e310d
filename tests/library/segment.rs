//! Segments and points in models and scenes, against cells of lattice solids and fractions of integers.

use pfront::*;
use pfront_testkit::oracle::first_parameter;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded};
use pfront_testkit::solids::{Blocks, Cell, is_inside, pair};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A body as the tests know it: its triangles in the world, in half units, its cells there, and its model and pose.
struct Known {
    triangles: Vec<[[i64; 3]; 3]>,
    cells: BTreeSet<Cell>,
    model: Arc<Model>,
    pose: AnyPose,
}

/// A lattice solid in f32 or in f64, modelled somewhere and posed back to near the origin.
fn known(solid: &Blocks, in_f64: bool, rng: &mut ChaCha8Rng) -> Known {
    let mesh = solid.mesh(rng.random_range(0..3) == 0, rng);
    let by = [0; 3].map(|_| rng.random_range(-4..=4));
    let far = if in_f64 { f64::from(1 << 30) * f64::from(1 << 8) } else { 64.0 };
    let model = if in_f64 {
        let place = |p: &[f32; 3]| p.map(|x| f64::from(x) + far);
        Model::from_f64(mesh.positions.iter().map(place).collect(), mesh.triangles.clone())
    } else {
        let place = |p: &[f32; 3]| p.map(|x| x + far as f32);
        Model::new(mesh.positions.iter().map(place).collect(), mesh.triangles.clone())
    };
    let back = by.map(|x| f64::from(x) - far);
    let pose = match in_f64 || rng.random_range(0..2) == 0 {
        true => AnyPose::from(Pose64::from_translation(back)),
        false => Pose::from_translation(back.map(|x| x as f32)).into(),
    };
    let at = |v: u32| {
        let p = mesh.positions[v as usize];
        [0, 1, 2].map(|k| 2 * (p[k] as i64 + i64::from(by[k])))
    };
    Known {
        triangles: mesh.triangles.iter().map(|t| t.map(at)).collect(),
        cells: solid.cells().iter().map(|cell| [0, 1, 2].map(|k| cell[k] + by[k])).collect(),
        model: Arc::new(model.unwrap()),
        pose,
    }
}

#[test]
fn scenes_and_models_tell_what_cells_and_fractions_tell() {
    let mut rng = seeded(49);
    let (mut hits, mut contained, mut on_surface) = (0, 0, 0);
    for round in 0..300 {
        let solids = [pair(&mut rng), pair(&mut rng)].concat();
        let known: Vec<_> = solids
            .iter()
            .map(|solid| {
                let in_f64 = rng.random_range(0..3) == 0;
                known(solid, in_f64, &mut rng)
            })
            .collect();
        let mut scene = SceneQuery::new();
        let ids: Vec<_> =
            known.iter().map(|body| scene.add(body.model.clone(), body.pose).unwrap()).collect();
        for _ in 0..20 {
            let [p, q] = [0; 2].map(|_| [0; 3].map(|_| rng.random_range(-10..=20)));
            let q = if rng.random_range(0..8) == 0 { p } else { q };
            let [from, to] = [p, q].map(|p| p.map(|x: i32| f64::from(x) * 0.5));
            let ends = [p, q].map(|p| p.map(i64::from));

            let (mut expected, mut first) = (Vec::new(), None);
            for (body, id) in known.iter().zip(&ids) {
                for (triangle, corners) in (0..).zip(&body.triangles) {
                    if let Some((over, under)) = first_parameter(ends, corners) {
                        expected.push((*id, triangle));
                        if first.is_none_or(|(_, (o, u))| over * u < o * under) {
                            first = Some(((*id, triangle), (over, under)));
                        }
                    }
                }
            }
            let names = |(id, hit): &(BodyId, SegmentHit)| (*id, hit.triangle);
            let found = scene.segment(from, to).unwrap();
            assert_eq!(found.iter().map(names).collect::<Vec<_>>(), expected, "{round}");
            let found = scene.segment_first(from, to).unwrap();
            assert_eq!(found.as_ref().map(names), first.map(|(hit, _)| hit), "{round}");
            if let (Some((_, hit)), Some((_, (over, under)))) = (found, first) {
                assert!((hit.at - over as f64 / under as f64).abs() < 1e-14);
            }
            hits += expected.len();

            let mut containing = Vec::new();
            for (body, id) in known.iter().zip(&ids) {
                let location = match is_inside(&body.cells, p) {
                    Some(true) => Location::Inside,
                    Some(false) => Location::Outside,
                    None => Location::Surface,
                };
                let solid = Solid::new(body.model.clone()).unwrap();
                let own = body.pose.to_f64().inverse().unwrap().apply(from);
                assert_eq!(solid.inside(own).unwrap(), location);
                if location != Location::Outside {
                    containing.push(BodyLocation { body: *id, location: Ok(location) });
                    contained += 1;
                    on_surface += usize::from(location == Location::Surface);
                }
            }
            assert_eq!(scene.inside(from).unwrap(), containing, "{round}");
            assert_eq!(scene.inside(from.map(|x| x as f32)).unwrap(), containing, "{round}");
        }
        for (body, id) in known.iter().zip(&ids) {
            let own = body.pose.to_f64().inverse().unwrap();
            let [from, to] = [own.apply([-9.0; 3]), own.apply([12.0, 11.0, 13.0])];
            let mut alone = SceneQuery::new();
            alone.add(body.model.clone(), body.pose).unwrap();
            let of_model = body.model.segment(from, to).unwrap();
            let of_scene = alone.segment([-9.0; 3], [12.0, 11.0, 13.0]).unwrap();
            assert_eq!(of_model, of_scene.iter().map(|(_, hit)| *hit).collect::<Vec<_>>());
            let first = body.model.segment_first(from, to).unwrap();
            assert_eq!(
                first,
                alone.segment_first([-9, -9, -9], [12, 11, 13]).unwrap().map(|x| x.1)
            );
            // Bodies that move, and that are gone.
            scene.remove(*id).unwrap();
            let left = scene.segment([-9.0; 3], [12.0, 11.0, 13.0]).unwrap();
            assert!(left.iter().all(|(other, _)| other != id));
        }
    }
    println!("{hits} hits, {contained} bodies contain, {on_surface} of them on the surface");
    assert!(hits > 4_000 && contained > 400 && on_surface > 150);
}

#[test]
fn open_bodies_are_named_and_deforming_ones_looked_at_anew() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let closed = Model::new(corners.clone(), faces.clone()).unwrap();
    let open = Model::new(corners.clone(), faces[..3].to_vec()).unwrap();
    let mut scene = SceneQuery::new();
    let closed = scene.add(closed, Pose::IDENTITY).unwrap();
    let open = scene.add(open, Pose::IDENTITY).unwrap();
    let error = NotSolid::OpenEdge { triangle: 0, edge: 1 };
    let point = [0.25, 0.25, 0.25];
    let at = |body, location| BodyLocation { body, location };
    let expected = [at(closed, Ok(Location::Inside)), at(open, Err(error))];
    assert_eq!(scene.inside(point).unwrap(), expected);
    assert_eq!(scene.inside([0.9, 0.9, 0.9]).unwrap(), [at(open, Err(error))], "its box");
    assert_eq!(scene.inside([9.0; 3]).unwrap(), []);

    // The corners of a soup, torn apart and put together again.
    let soup: Vec<[f32; 3]> = faces.iter().flatten().map(|&v| corners[v as usize]).collect();
    let alone = (0..4).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let soup_id = scene.add(Model::new(soup.clone(), alone).unwrap(), Pose::IDENTITY).unwrap();
    assert_eq!(scene.inside(point).unwrap()[2], at(soup_id, Ok(Location::Inside)));
    let mut torn = soup.clone();
    torn[11][2] = 2.0;
    scene.set_positions(soup_id, &torn).unwrap();
    assert!(matches!(scene.inside(point).unwrap()[2].location, Err(NotSolid::OpenEdge { .. })));
    scene.set_positions(soup_id, &soup).unwrap();
    assert_eq!(scene.inside(point).unwrap()[2], at(soup_id, Ok(Location::Inside)));
}

#[test]
fn what_is_no_point_is_refused() {
    let model = Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    let mut scene = SceneQuery::new();
    let (start, end) = (MeshError::NonFinite { vertex: 0 }, MeshError::Range { vertex: 1 });
    assert_eq!(model.segment([f32::NAN; 3], [0.0; 3]), Err(Error::Mesh(start)));
    assert_eq!(model.segment_first([0.0; 3], [1e38; 3]), Err(Error::Mesh(end)));
    assert_eq!(scene.segment([0.0; 3], [1e38; 3]), Err(Error::Mesh(end)));
    assert_eq!(scene.segment_first([f64::INFINITY; 3], [1e38; 3]), Err(Error::Mesh(start)));
    assert_eq!(scene.inside([f64::NAN; 3]), Err(Error::Mesh(start)));
    assert_eq!(model.segment_first([0; 3], [0; 3]).unwrap().unwrap().triangle, 0);
}
