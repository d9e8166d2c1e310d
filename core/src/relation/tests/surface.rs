//! Surfaces without an interior: some sides of lattice solids, beside the cells of another solid.

use super::*;
use pfront_testkit::solids::Cell;

type Cells = std::collections::BTreeSet<Cell>;

/// Calls `then` with a mesh as a surface.
fn with_surface<R>(mesh: Mesh<'_>, then: impl FnOnce(Solid<'_>) -> R) -> R {
    let n = mesh.triangles().len();
    let mut words = vec![0; solid_bound(mesh.vertex_count(), n)];
    let mut scratch = vec![0; solid_scratch_bound(mesh.vertex_count(), n)];
    with_bvh(mesh, |bvh| then(Solid::surface(bvh, &mut words, &mut scratch).unwrap()))
}

/// The answer of a query, which two workers give too.
fn answer(a: &Solid<'_>, b: &Solid<'_>, pose: Pose) -> Between {
    let query = RelationQuery::new(a, b, pose).unwrap();
    let found = query.relation(&mut vec![0; seen_bound(query.patches())]).unwrap();
    assert_eq!(by_workers(&query).relation, found.relation);
    found
}

/// The relation of the unit squares of some sides to a set of cells, each side two triangles.
fn truth_of_sides(sides: &MeshData, cells: &Cells) -> (Relation, bool) {
    let (mut inside, mut outside, mut meets) = (false, false, false);
    for side in sides.triangles.chunks(2) {
        let points: vec::Vec<_> =
            side.iter().flatten().map(|&v| sides.positions[v as usize].map(|x| x as i32)).collect();
        let low = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).min().unwrap());
        let high = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).max().unwrap());
        let flat = (0..3).find(|&k| low[k] == high[k]).unwrap();
        // Twice the coordinates of all points at halves.
        let mut at = low.map(|x| 2 * x);
        loop {
            let is_inside = is_inside(cells, at);
            let is_middle = (0..3).all(|k| k == flat || at[k] % 2 != 0);
            meets |= is_inside.is_none();
            inside |= is_middle && is_inside == Some(true);
            outside |= is_middle && is_inside == Some(false);
            let Some(k) = (0..3).find(|&k| at[k] < 2 * high[k]) else { break };
            at[k] += 1;
            (0..k).for_each(|lower| at[lower] = 2 * low[lower]);
        }
    }
    let relation = match (inside, outside) {
        (true, true) => Relation::Crossing,
        (true, false) => Relation::AInB,
        _ if meets => Relation::Touching,
        _ => Relation::Apart,
    };
    (relation, meets)
}

#[test]
fn surfaces_are_to_solids_what_their_squares_are_to_the_cells() {
    let mut rng = numbers(50);
    let mut counts = std::collections::BTreeMap::new();
    for round in 0..rounds(1_500) {
        let [own, other] = pair(&mut rng);
        let mut a = own.mesh(rng.random_range(0..4) == 0, &mut rng);
        let keep = rng.random_range(1..=6);
        let sides: vec::Vec<_> = a.triangles.chunks(2).map(<[_]>::to_vec).collect();
        a.triangles =
            sides.into_iter().filter(|_| rng.random_range(0..6) < keep).flatten().collect();
        if a.triangles.is_empty() {
            continue;
        }
        let (relation, meets) = truth_of_sides(&a, &other.cells());
        let (rows, _) = map(&mut rng);
        a.triangles.iter_mut().for_each(|t| {
            if rng.random_range(0..2) == 0 {
                t.swap(0, 1);
            }
        });
        a.triangles.shuffle(&mut rng);
        let b = other.mesh(false, &mut rng).map(|p| mapped(&rows, p));
        let a = a.map(|p| mapped(&rows, p));
        with_surface(mesh(&a), |a| {
            with_solid(mesh(&b), |b| {
                let b = b.unwrap();
                let found = answer(&a, &b, Pose::IDENTITY);
                assert_eq!((found.relation, found.meets), (Some(relation), meets), "{round}");
                let swapped = answer(&b, &a, Pose::IDENTITY);
                assert_eq!(swapped.relation, Some(relation.swapped()), "{round}");
            });
        });
        *counts.entry(relation.as_str()).or_insert(0) += 1;
    }
    std::println!("{counts:?}");
    assert!(cfg!(miri) || counts.len() == 4 && counts.values().all(|&n| n > 30), "{counts:?}");
}

#[test]
fn a_surface_may_meet_itself_and_has_no_volume() {
    let sheet = |z: f32| MeshData {
        positions: vec![[-1.0, -1.0, z], [2.0, -1.0, z], [-1.0, 2.0, z], [0.2, 0.2, 9.0]],
        triangles: vec![[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 3, 2], [0, 2, 1]],
    };
    let cube = cube(0.0, 1.0);
    with_solid(mesh(&cube), |solid| {
        let solid = solid.unwrap();
        for (z, relation) in
            [(0.5, Relation::Crossing), (1.0, Relation::Touching), (1.5, Relation::Apart)]
        {
            with_surface(mesh(&sheet(z)), |surface| {
                assert_eq!(answer(&surface, &solid, Pose::IDENTITY).relation, Some(relation));
                let query = RelationQuery::new(&surface, &solid, Pose::IDENTITY).unwrap();
                let mut overlap = Overlap::new(&query);
                let _ = crate::bvtt::Query::visit(
                    query.pairs(),
                    &mut crate::bvtt::Query::start(query.pairs()),
                    |pair| {
                        overlap.add(pair);
                        core::ops::ControlFlow::Continue(())
                    },
                );
                assert!(matches!(overlap.conclude(), Ok([0.0, high]) if high < 1e-300));
                assert_eq!(surface.inside([0.5, 0.5, z]), Ok(Location::Surface));
                assert_eq!(surface.inside([0.5, 0.5, z + 0.25]), Ok(Location::Outside));
            });
        }
    });
    let flat = MeshData { positions: vec![[0.0; 3], [1.0; 3]], triangles: vec![[0, 1, 1]] };
    let (mut words, mut scratch) = ([0; solid_bound(2, 1)], [0; solid_scratch_bound(2, 1)]);
    let refused = with_bvh(mesh(&flat), |bvh| Solid::surface(bvh, &mut words, &mut scratch).err());
    assert_eq!(refused, Some(NotSolid::NoArea));
}

#[test]
fn two_surfaces_cross_touch_or_leave_it_open() {
    let triangle = |points: [[f32; 3]; 3]| MeshData::of([points]);
    let flat = triangle([[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
    let through = triangle([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 1.0, 0.5]]);
    let upon = triangle([[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 1.0, 1.0]]);
    let at_a_point = triangle([[1.0, 1.0, 0.0], [2.0, 1.0, 1.0], [1.0, 1.0, 1.0]]);
    for (other, relation) in
        [(through, Some(Relation::Crossing)), (upon, None), (at_a_point, Some(Relation::Touching))]
    {
        with_surface(mesh(&flat), |a| {
            with_surface(mesh(&other), |b| {
                let found = answer(&a, &b, Pose::IDENTITY);
                assert_eq!((found.relation, found.meets), (relation, true));
                assert!(found.pair.is_some());
            });
        });
    }
}
