//! The stack that each long call takes, on inputs that make it take most, against the bounds of `docs/embedding.md`.
//!
//! `cargo test -p pfront-core --test stack -- --nocapture` shows the figures; `--features std` those with std.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod inputs;
mod meter;

use inputs::{Tree, coincident, curled, disparate, mesh, peeling, sheets};
use meter::stack_of;
use pfront_blob::Blob;
use pfront_core::bvh::*;
use pfront_core::bvtt::*;
use pfront_core::front::{Front, FrontNode, Part, RefineOptions};
use pfront_core::one_ring::{OneRings, history_bound, links_bound};
use pfront_core::triangle::intersects;
use pfront_core::{Bvh, Mesh, Node, Pose};
use pfront_testkit::MeshData;
use std::hint::black_box;
use std::ops::ControlFlow::Continue;

/// The row of a call in the chapter ends in its stack with std and without.
fn documented(call: &str) -> usize {
    let name = format!("`{call}`");
    let rows = include_str!("../../../docs/embedding.md").lines().filter(|l| l.starts_with("| `"));
    let mut cells = rows.map(|row| row.split('|').map(str::trim).skip(1).collect::<Vec<_>>());
    let row =
        cells.find(|cells| cells[0].contains(&name) && cells[cells.len() - 2].ends_with("KiB"));
    let row = row.unwrap_or_else(|| panic!("no row tells what stack {name} takes"));
    let column = row.len() - if cfg!(feature = "std") { 3 } else { 2 };
    row[column].strip_suffix(" KiB").unwrap().parse::<usize>().unwrap() << 10
}

#[track_caller]
fn check(call: &str, run: impl FnOnce() + Send) {
    let (used, most) = (stack_of(run), documented(call));
    println!("{call}: {used} of {most} bytes");
    assert!(used <= most, "{call} takes {used} bytes of stack, and the chapter says {most}");
}

fn one_after_the_other(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    a();
    b();
}

fn turned() -> Pose {
    Pose::new([[1.0, 0.0, 0.0, 0.0], [0.0, 0.8, -0.6, 0.0], [0.0, 0.6, 0.8, 0.0]])
}

/// BVHs with leaves of one triangle. Returns how deep they are.
fn build(soup: &MeshData) -> [usize; 2] {
    let (mesh, count) = (mesh(soup), soup.triangles.len());
    let options = BuildOptions { leaf_size: 1, join: None };
    let mut tree = Tree { nodes: vec![Node::EMPTY; node_bound(count)], order: vec![0; count] };
    let (mut items, mut keys) = (vec![Node::EMPTY; count], vec![0; 2 * count]);
    let mut depth = [0; 2];
    check("sah", || depth[0] = sah(mesh, &options, tree.storage(), &mut items).unwrap().depth());
    let join: Option<&Join<'_>> = Some(&one_after_the_other);
    let in_parts = BuildOptions { leaf_size: 1, join };
    check("sah` with a `join", || {
        sah(mesh, &in_parts, tree.storage(), &mut items).unwrap();
    });
    check("morton", || {
        depth[1] = morton(mesh, &options, tree.storage(), &mut keys).unwrap().depth();
    });
    check("morton` with a `join", || {
        morton(mesh, &in_parts, tree.storage(), &mut keys).unwrap();
    });
    let used = sah(mesh, &options, tree.storage(), &mut items).unwrap().nodes().len();
    check("refit` with a `join", || {
        let options = Refit { join, ..Refit::default() };
        refit(mesh, &mut tree.nodes[..used], &tree.order, options).unwrap();
    });
    depth
}

#[test]
fn builds() {
    let depths = [disparate(1000), peeling(1 << 17), curled(1 << 15), coincident(1 << 15)]
        .map(|s| build(&s));
    // Else these inputs are not what they are meant to be.
    assert_eq!(depths[0][0], MAX_DEPTH, "{depths:?}");
    assert!(depths[1][0] > 50 && depths[2][1] >= 45, "{depths:?}");
}

#[test]
fn refits() {
    let soup = coincident(MAX_DEPTH + 1);
    let (mesh, tree) = (mesh(&soup), Tree::deepest(mesh(&soup)));
    let (mut nodes, order) = (tree.nodes.clone(), &tree.order);
    let mut table = vec![RefitRow::default(); nodes.len() / 2];
    let mut moved = vec![Moved::default(); soup.positions.len().div_ceil(32)];
    let after: Vec<_> = soup.positions.iter().map(|p| p.map(|x| 1.5 * x)).collect();
    let join: Option<&Join<'_>> = Some(&one_after_the_other);
    check("refit", || _ = refit(mesh, &mut nodes, order, Refit::default()).unwrap());
    let bvh = tree.bvh(mesh);
    check("quality", || _ = black_box(quality(&bvh)));
    check("refit` with a `table", || {
        let options = Refit { join, table: &mut table, moved: None };
        refit(mesh, &mut nodes, order, options).unwrap();
    });
    check("mark_moved", || _ = mark_moved(mesh.positions().unwrap(), &after, &mut moved).unwrap());
    let mesh = mesh.with_positions(&after).unwrap();
    check("refit` with a `table", || {
        let options = Refit { join, table: &mut table, moved: Some(&moved) };
        refit(mesh, &mut nodes, order, options).unwrap();
    });
}

#[test]
fn checks_and_conversions() {
    let soup = coincident(MAX_DEPTH + 1);
    let (mesh, tree) = (mesh(&soup), Tree::deepest(mesh(&soup)));
    let bvh = tree.bvh(mesh);
    assert_eq!(bvh.depth(), MAX_DEPTH);
    let scratch = &mut [0; (MAX_DEPTH + 1).div_ceil(32)];
    check("Mesh::new", || {
        _ = black_box(Mesh::new(mesh.positions().unwrap(), mesh.triangles())).unwrap();
    });
    check("Bvh::new", || _ = black_box(Bvh::new(mesh, &tree.nodes, &tree.order, scratch)).unwrap());
    let mut bytes = pfront_blob::Aligned([0; 1 << 14]);
    let bytes = &mut bytes.0[..pfront_blob::Counts::of(&bvh).bytes()];
    check("pfront_blob::write", || _ = pfront_blob::write(&bvh, bytes).unwrap());
    check("Blob::new", || _ = black_box(Blob::new(bytes)).unwrap());
    let blob = Blob::new(bytes).unwrap();
    check("Blob::bvh", || _ = black_box(blob.bvh(scratch)).unwrap());
}

/// Walks, as far as a good number of tests.
fn walk(query: &(impl Query + Sync)) {
    check("step", || {
        _ = query.step(&mut query.start(), 200_000, |pair| Continue(_ = black_box(pair)));
    });
}

/// A cursor after some tests.
#[cfg(feature = "within")]
fn walked(query: &impl Query, tests: u64) -> Cursor {
    let mut cursor = query.start();
    _ = query.step(&mut cursor, tests, |pair| Continue(_ = black_box(pair)));
    cursor
}

#[test]
fn queries() {
    let deep = coincident(MAX_DEPTH + 1);
    let deepest = Tree::deepest(mesh(&deep));
    let trees =
        [sheets(40), disparate(3000), coincident(2000)].map(|soup| (Tree::of(mesh(&soup)), soup));
    for (tree, soup) in trees.iter().map(|(tree, soup)| (tree, soup)).chain([(&deepest, &deep)]) {
        let (mesh, bvh) = (mesh(soup), tree.bvh(mesh(soup)));
        let posed = PosedBvh::new(bvh, &turned()).unwrap();
        walk(&SelfBvtt::new(bvh));
        walk(&PairBvtt::new(bvh, bvh, turned()).unwrap());
        walk(&PairBvtt::in_world(posed, posed));
        #[cfg(feature = "within")]
        for distance in [1e-30, 0.1] {
            let (near, near_itself) = (
                PairBvtt::in_world(posed, posed)
                    .within(pfront_core::Distance::new(distance).unwrap()),
                SelfBvtt::new(bvh).within(pfront_core::Distance::new(distance).unwrap()),
            );
            let walk = |query: &dyn Fn() -> Cursor| _ = black_box(query());
            let steps = 2_000;
            check("step within a distance", || {
                walk(&|| walked(&near, steps));
                walk(&|| walked(&near_itself, steps));
            });
        }
        #[cfg(feature = "within")]
        for apart in [0.0, 1e-30, 3.0] {
            let pose = Pose::from_translation([apart, 0.0, apart]);
            let query = PairBvtt::new(bvh, bvh, pose).unwrap();
            check("distance", || {
                let mut search = query.search(None, Some(TrianglePair { a: 0, b: 0 }));
                query.seek(&mut search, 2_000);
                black_box(search.gap());
            });
        }
        let query = PairBvtt::new(bvh, bvh, turned()).unwrap();
        let mut page = vec![TrianglePair::default(); 1000];
        check("PairBvtt::new", || _ = black_box(PairBvtt::new(bvh, bvh, turned())).unwrap());
        check("page", || _ = query.page(&mut query.start(), &mut page));
        check("any", || _ = black_box(query.any()));
        check("contact", || page.iter().for_each(|p| _ = black_box(query.contact(*p))));
        check("intersects", || {
            for [a, b] in page.iter().map(|p| [p.a, p.b].map(|t| mesh.shadow_triangle(t))) {
                black_box(intersects(&a, &b));
            }
        });
    }
}

/// Triangles over few coordinates of any bits, so that many signs need integers as long as there are.
#[cfg(feature = "f64")]
#[test]
fn queries_in_f64() {
    use pfront_core::Pose64;
    use pfront_testkit::rng::{RngExt, seeded};
    let mut rng = seeded(5);
    let mut any = || loop {
        let x = f64::from_bits(rng.random());
        if x.abs() <= 4.25e37 {
            break x;
        }
    };
    let values: [f64; 6] = [0; 6].map(|_| any());
    let mut pick = || values[rng.random_range(0..6_usize)];
    let positions: Vec<[f64; 3]> = (0..600).map(|_| [pick(), pick(), pick()]).collect();
    let triangles: Vec<[u32; 3]> = (0..200).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mut shadow = vec![[0.0; 3]; positions.len()];
    let own = Mesh::from_f64(&positions, &triangles, &mut shadow).unwrap();
    let tree = Tree::of(own);
    let bvh = tree.bvh(own);
    let walk = |query: &(dyn Fn() -> u64 + Sync)| check("step in f64", || _ = black_box(query()));
    walk(&|| PairBvtt::in_f64(bvh, bvh, &Pose64::IDENTITY).unwrap().count());
    walk(&|| SelfBvtt::new(bvh).count());
    let pose = Pose64::from_rotation_translation([0.1, 0.2, 0.3, 0.9], [1e-3; 3]);
    let query = PairBvtt::in_f64(bvh, bvh, &pose).unwrap();
    walk(&|| query.count());
    #[cfg(feature = "within")]
    for query in [query, PairBvtt::in_f64(bvh, bvh, &Pose64::IDENTITY).unwrap()] {
        let near = query.within(pfront_core::Distance::new(values[0].abs() as f32).unwrap());
        check("step within a distance in f64", || _ = black_box(walked(&near, 2_000)));
        check("distance in f64", || {
            let mut search = query.search(None, None);
            query.seek(&mut search, 2_000);
            black_box(search.gap());
        });
    }
    check("PairBvtt::in_f64", || _ = black_box(PairBvtt::in_f64(bvh, bvh, &pose)).unwrap());
    for pose in [Pose64::IDENTITY, pose] {
        let query = PairBvtt::in_f64(bvh, bvh, &pose).unwrap();
        let all = (0..200).flat_map(|a| (0..200).map(move |b| TrianglePair { a, b }));
        check("meet", || {
            for pair in all.clone() {
                let [a, b] = query.corners(pair);
                let found = query.meet(pair);
                found.iter().for_each(|meet| meet.points(&a, &b).for_each(|p| _ = black_box(p)));
            }
        });
        check("contact_f64", || all.for_each(|pair| _ = black_box(query.contact_f64(pair))));
    }
}

/// Asks for impacts, of two meshes or of one.
#[cfg(all(feature = "motion", feature = "f64"))]
fn asked<const SELF: bool>(query: &pfront_core::motion::MovingBvtt<'_, SELF>) {
    let _ = query.visit(|pair, impact| Continue(_ = black_box((pair, impact))));
    black_box(query.first_impact());
}

/// Motions through each other, in one plane, and to where all touch.
#[cfg(all(feature = "motion", feature = "f64"))]
#[test]
fn motions() {
    use pfront_core::Pose64;
    use pfront_core::motion::{MovingBvh, impact, impact_in_mesh};
    use pfront_core::triangle::Adjacency;
    let deep = coincident(MAX_DEPTH + 1);
    let deepest = Tree::deepest(mesh(&deep));
    let trees =
        [sheets(8), disparate(12), coincident(12)].map(|soup| (Tree::of(mesh(&soup)), soup));
    for (tree, soup) in trees.iter().map(|(tree, soup)| (tree, soup)).chain([(&deepest, &deep)]) {
        let (own, bvh) = (mesh(soup), tree.bvh(mesh(soup)));
        let in_f32 = |pose: &Pose| PosedBvh::new(bvh, pose).unwrap();
        let in_f64 = |pose: &Pose| PosedBvh::in_f64(bvh, &Pose64::from(*pose)).unwrap();
        let (here, there) = (Pose::IDENTITY, Pose::from_translation([0.25, 0.0, 0.0]));
        for [from, to] in [[here, turned()], [there, here], [turned(), there]] {
            for [start, end] in [[in_f32(&from), in_f32(&to)], [in_f64(&from), in_f64(&to)]] {
                let rest = MovingBvh::new(start, start).unwrap();
                let query = PairBvtt::moving(rest, MovingBvh::new(start, end).unwrap());
                check("MovingBvtt", || asked(&query));
                #[cfg(feature = "within")]
                {
                    let query = query.within(pfront_core::Distance::new(0.125).unwrap());
                    check("MovingBvtt", || asked(&query));
                }
            }
        }
        // Every coordinate becomes another one that is there already.
        let count = soup.positions.len();
        let after: Vec<_> = (0..count).map(|v| soup.positions[(5 * v + 2) % count]).collect();
        let (moved, mut nodes) = (own.with_positions(&after).unwrap(), tree.nodes.clone());
        refit(moved, &mut nodes, &tree.order, Refit::default()).unwrap();
        let end = Bvh::new_unchecked(moved, &nodes, &tree.order);
        let [start, end] = [bvh, end].map(|bvh| PosedBvh::new(bvh, &Pose::IDENTITY).unwrap());
        let query = SelfBvtt::moving(MovingBvh::new(start, end).unwrap());
        check("MovingBvtt", || asked(&query));
        let triangles = own.triangles().len().min(30) as u32;
        let pairs = (0..triangles).flat_map(|a| (0..a).map(move |b| [a, b]));
        check("impact", || {
            for two in pairs.clone() {
                let corners = |mesh: Mesh<'_>, t| mesh.shadow_triangle(t).map(|p| p.map(f64::from));
                let [a, b] = two.map(|t| [own, moved].map(|mesh| corners(mesh, t)));
                _ = black_box(impact(&a, &b));
            }
        });
        check("impact_in_mesh", || {
            for [a, b] in pairs.clone() {
                _ = black_box(impact_in_mesh(own, moved, a, b, Adjacency::default()));
            }
        });
    }
}

#[test]
fn fronts() {
    let soup = sheets(40);
    let tree = Tree::of(mesh(&soup));
    let query = PairBvtt::new(tree.bvh(mesh(&soup)), tree.bvh(mesh(&soup)), turned()).unwrap();
    let (mut nodes, mut history) = (vec![FrontNode::default(); 4096], Vec::new());
    let mut parts = [Part::default(); 64];
    for _ in 0..2 {
        let mut front = Front::new(&mut nodes);
        front.add(0, query.root().unwrap()).unwrap();
        let options = RefineOptions::new(64);
        check("Front::refine", || _ = front.refine(&options, &mut history, |_| query));
        let mut assigned = &mut [][..];
        check("Front::partition", || assigned = front.partition(&mut parts));
        assert!(assigned.len() > 64, "{}", assigned.len());
        history = assigned.to_vec();
    }
}

/// The other bound that the chapter gives on a front.
#[test]
fn a_starting_front_takes_four_box_tests_a_node_above_it() {
    let soup = coincident(2000);
    let tree = Tree::of(mesh(&soup));
    let bvh = tree.bvh(mesh(&soup));
    let query = PairBvtt::new(bvh, bvh, Pose::IDENTITY).unwrap();
    let mut nodes = [FrontNode::default(); 256];
    let mut front = Front::new(&mut nodes);
    front.add(0, query.root().unwrap()).unwrap();
    let options = RefineOptions { workers: 2, g: 0.0, g_estimated: 0.0 };
    let report = front.refine(&options, &mut [], |_| query);
    let nodes = front.partition(&mut [Part::default(); 2]).len();
    // All nodes overlap all: 1, 4, 16, and 64 are enough.
    assert_eq!((nodes, report.full), (64, false));
    assert_eq!(report.box_tests, 4 + 16 + 64);
}

#[test]
fn one_rings() {
    let soup = sheets(128);
    let (mesh, vertices) = (mesh(&soup), soup.positions.len());
    let count = soup.triangles.len();
    let mut history = vec![0; history_bound(vertices)];
    let mut scratch = vec![0; links_bound(vertices, count)];
    check("OneRings::new", || {
        OneRings::new(vertices, &soup.triangles, &mut history, &mut scratch).unwrap();
    });
    let rings = OneRings::new_unchecked(vertices, &soup.triangles, &mut history);
    let mut rings = rings.with_links(&mut scratch).unwrap();
    let mut certify = |join| check("OneRings::certify", || _ = rings.certify(mesh, join));
    certify(None);
    certify(Some(&one_after_the_other));
}

/// Segments through corners and edges, and points on sides, where integers decide, of coordinates far apart.
#[cfg(feature = "relation")]
#[test]
fn segments() {
    use pfront_core::relation::Rule;
    use pfront_core::segment::Segment;
    use pfront_testkit::rng::seeded;
    let mut rng = seeded(72);
    for round in 0..12 {
        let size = [[1.0; 3], [1e12, 1.0, 1e-12], [1e30, 1.0, 1e-30]][round % 3];
        let solid = pfront_testkit::solids::pair(&mut rng)[0].mesh(false, &mut rng);
        let solid = solid.map(|p| [0, 1, 2].map(|k| p[k] * size[k]));
        let count = solid.triangles.len();
        let mut tree = Tree { nodes: vec![Node::EMPTY; node_bound(count)], order: vec![0; count] };
        let mut keys = vec![0; 2 * count];
        morton(mesh(&solid), &BuildOptions::default(), tree.storage(), &mut keys).unwrap();
        let bvh = Bvh::new_unchecked(mesh(&solid), &tree.nodes, &tree.order);
        let mut scratch = vec![0; 2 * solid.positions.len() + 6 * count];
        let mut rule = Rule::NonZero;
        check("Rule::of", || rule = Rule::of(mesh(&solid), &mut scratch).unwrap());
        let mut poses = vec![PosedBvh::new(bvh, &Pose::IDENTITY).unwrap()];
        poses.extend(PosedBvh::new(bvh, &turned()));
        #[cfg(feature = "f64")]
        poses.extend(PosedBvh::in_f64(bvh, &turned().into()));
        check("Segment", || {
            for (i, &from) in solid.positions.iter().enumerate() {
                let to = solid.positions[(7 * i + 3) % solid.positions.len()].map(|x| 1.5 * x);
                let tiny = from.map(|x| f64::from(x) + f64::from_bits(1 + i as u64));
                for end in [from.map(f64::from), tiny] {
                    let segment = Segment::new(end, to).unwrap();
                    for posed in &poses {
                        _ = segment.visit(posed, |_| Continue(()));
                        black_box(segment.first([*posed]));
                        _ = black_box(rule.inside(posed, end));
                    }
                }
            }
        });
    }
}

/// Solids that are flush, so that pictures and integers decide, on axes of sizes far apart.
#[cfg(feature = "relation")]
#[test]
fn relations() {
    use pfront_core::relation::*;
    use pfront_testkit::rng::seeded;
    let mut rng = seeded(71);
    for round in 0..24 {
        let sizes = [[1.0; 3], [1e12, 1.0, 1e-12], [1e30, 1.0, 1e-30]][round % 3];
        let mut solids = pfront_testkit::solids::pair(&mut rng)
            .map(|solid| solid.mesh(false, &mut rng).map(|p| [0, 1, 2].map(|k| p[k] * sizes[k])));
        if round % 2 == 0 {
            solids[1] = solids[0].clone();
        }
        let trees = solids.each_ref().map(|soup| {
            let count = soup.triangles.len();
            let (nodes, order) = (vec![Node::EMPTY; node_bound(count)], vec![0; count]);
            let mut tree = Tree { nodes, order };
            let mut keys = vec![0; 2 * count];
            morton(mesh(soup), &BuildOptions::default(), tree.storage(), &mut keys).unwrap();
            (tree, count, soup.positions.len())
        });
        let words = [0, 1].map(|i| {
            let (tree, count, vertices) = &trees[i];
            let bvh = Bvh::new_unchecked(mesh(&solids[i]), &tree.nodes, &tree.order);
            let mut words = vec![0; solid_bound(*vertices, *count)];
            let mut scratch = vec![0; solid_scratch_bound(*vertices, *count)];
            check("Solid::new", || _ = Solid::new(bvh, &mut words, &mut scratch).unwrap());
            (bvh, words)
        });
        let [a, b] = words.each_ref().map(|(bvh, words)| Solid::new_unchecked(*bvh, words));
        let ask = |query: &RelationQuery<'_>| {
            let mut lines = vec![0; seen_bound(query.patches())];
            black_box(query.relation(&mut lines)).unwrap();
            let mut overlap = Overlap::new(query);
            let _ = query.pairs().visit(&mut query.pairs().start(), |pair| {
                overlap.add(pair);
                Continue(())
            });
            black_box(overlap.conclude()).unwrap();
        };
        let moved = Pose::from_translation([0.5, 0.25, 0.125]);
        for pose in [Pose::IDENTITY, moved, turned()] {
            let Ok(query) = RelationQuery::new(&a, &b, pose) else { continue };
            check("RelationQuery", || ask(&query));
            #[cfg(feature = "f64")]
            {
                let query = PairBvtt::in_f64(a.bvh(), b.bvh(), &pose.into()).unwrap();
                let query = RelationQuery::of_pair(query, &a, &b);
                check("RelationQuery in f64", || ask(&query));
            }
        }
    }
}
