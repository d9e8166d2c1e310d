//! One-rings that intersect themselves and one-rings that do not; certificates in parts, after moves, and of another mesh.

extern crate std;

use super::*;
use crate::Mesh;
use crate::bvh::{BuildOptions, BvhStorage, Join, Refit, morton, node_bound, refit};
use crate::bvtt::{Query, SelfBvtt};
use crate::parallel::FINE;
use crate::{Bvh, Node};
use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::shapes::sheet;
use std::vec;
use std::vec::Vec;

/// Numbers of triangles around a vertex: linked one by one or by sorting, and so many that they make fans.
const SIZES: [usize; 12] = [3, 4, 5, 6, 14, 15, 16, 17, 63, 64, 65, 1000];

/// Calls `test` with the one-rings of some triangles.
fn with_rings<R>(
    vertices: usize,
    triangles: &[[u32; 3]],
    test: impl FnOnce(&mut OneRings<'_>) -> R,
) -> R {
    let mut history = vec![!0; history_bound(vertices)];
    let mut links = vec![!0; links_bound(vertices, triangles.len())];
    OneRings::new(vertices, triangles, &mut history, &mut links).unwrap();
    let rings = OneRings::new_unchecked(vertices, triangles, &mut history);
    test(&mut rings.with_links(&mut links).unwrap())
}

/// Whether each vertex is certified.
fn certified(rings: &mut OneRings<'_>, mesh: Mesh<'_>, join: Option<&Join<'_>>) -> Vec<bool> {
    let certified = rings.certify(mesh, join);
    (0..mesh.vertex_count() as u32).map(|vertex| certified.is_certified(vertex)).collect()
}

/// Whether vertex 0 is certified.
fn first_is_certified(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> bool {
    let mesh = Mesh::new(positions, triangles).unwrap();
    with_rings(positions.len(), triangles, |rings| certified(rings, mesh, None)[0])
}

/// Whether the vertex at the origin is certified, with these points around it.
fn is_certified(around: &[[f32; 3]], closed: bool) -> bool {
    let n = around.len() as u32;
    let positions: Vec<_> = [[0.0; 3]].iter().chain(around).copied().collect();
    let triangles = (0..if closed { n } else { n - 1 }).map(|i| {
        // The corners in any order that keeps the orientation.
        let mut t = [0, i + 1, (i + 1) % n + 1];
        t.rotate_left(i as usize % 3);
        t
    });
    first_is_certified(&positions, &triangles.collect::<Vec<_>>())
}

fn circle(n: usize, turns: f32, height: impl Fn(usize) -> f32) -> Vec<[f32; 3]> {
    let point = |i| {
        let angle = 0.1 + turns * core::f32::consts::TAU * i as f32 / n as f32;
        [cos(angle), cos(angle - core::f32::consts::FRAC_PI_2), height(i)]
    };
    (0..=n).map(point).collect()
}

fn cos(x: f32) -> f32 {
    glam::Vec2::from_angle(x).x
}

#[test]
fn rings_that_go_round_once_are_certified() {
    for n in SIZES {
        assert!(is_certified(&circle(n, 1.0, |_| 0.0)[..n], true), "flat, {n}");
        assert!(is_certified(&circle(n, 1.0, |_| 0.5)[..n], true), "a cone, {n}");
    }
    assert!(is_certified(&circle(6, 1.0, |i| [0.3, -0.3][i % 2])[..6], true), "a saddle");
}

#[test]
fn rings_that_go_round_twice_or_fold_are_not() {
    for n in SIZES.into_iter().filter(|&n| n >= 5) {
        assert!(!is_certified(&circle(n, 2.0, |i| i as f32 * 0.1)[..n], true), "{n}");
    }
    for n in SIZES.into_iter().filter(|&n| n > 6) {
        let mut folded = circle(n, 1.0, |_| 0.0);
        folded.swap(n / 2, n / 2 + 1);
        assert!(!is_certified(&folded[..n], true), "two of {n} change places");
    }
    let mut folded = circle(6, 1.0, |_| 0.0);
    folded.swap(2, 3);
    assert!(!is_certified(&folded[..6], true));
    folded[3] = folded[2];
    assert!(!is_certified(&folded[..6], true), "a triangle without area");
}

#[test]
fn rows_are_certified_below_a_full_turn() {
    for n in SIZES {
        assert!(is_certified(&circle(2 * n, 1.0, |_| 0.0)[..n], false), "half a turn, {n}");
    }
    assert!(!is_certified(&circle(12, 1.2, |_| 0.0)[..13], false), "more than a turn");
    assert!(!is_certified(&circle(12, 1.0, |_| 0.0)[..13], false), "a whole turn");
}

#[test]
fn only_one_ring_or_one_row_is_certified() {
    let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
    let certified = |triangles: &[[u32; 3]]| first_is_certified(&square, triangles);
    assert!(certified(&[[0, 1, 2], [0, 2, 3]]));
    assert!(!certified(&[[0, 1, 2], [0, 3, 2]]), "turned over");
    assert!(!certified(&[[0, 1, 2], [0, 1, 2]]), "twice");
    assert!(!certified(&[[0, 1, 2], [0, 1, 3]]), "two on one side of an edge");
    assert!(!certified(&[[0, 1, 2], [0, 3, 4]]), "two rows");
    assert!(!certified(&[[0, 1, 2], [0, 2, 1], [0, 3, 4], [0, 4, 3]]), "two rings");
    assert!(!certified(&[[0, 1, 2], [0, 0, 3]]), "an index twice");
    assert!(!certified(&[]), "none");
}

#[test]
fn many_triangles_are_linked_as_few_are() {
    let disc = circle(40, 1.0, |_| 0.0);
    let points: Vec<_> = [[0.0; 3]].into_iter().chain(disc).chain([[0.0, 0.0, 9.0]]).collect();
    let rim = |i: u32| [0, 1 + i % 40, 1 + (i + 1) % 40];
    let some = |range: core::ops::Range<u32>| range.map(rim).collect::<Vec<_>>();
    let certified = |triangles: &[[u32; 3]]| first_is_certified(&points, triangles);
    assert!(certified(&some(0..40)) && certified(&some(15..45)) && certified(&some(30..65)));
    assert!(!certified(&[some(0..20), some(21..40)].concat()), "two rows");
    assert!(!certified(&[some(0..40), some(3..4)].concat()), "one twice");
    assert!(!certified(&[some(0..40), vec![[0, 41, 5]]].concat()), "two on one side of an edge");
    assert!(!certified(&[some(0..39), vec![[0, 1, 40]]].concat()), "turned over");
    let pinched = [some(0..20), vec![[0, 21, 1]], some(22..39), vec![[0, 40, 23]]].concat();
    assert!(!certified(&pinched), "two rings");
    let tailed = [some(0..20), vec![[0, 21, 9]]].concat();
    assert!(!certified(&tailed), "a row that ends in its middle");
}

#[test]
fn buffers_one_short_are_errors_that_name_the_need() {
    let (words, scratch_words) = (history_bound(5), link_scratch_bound(5, 1));
    let error = |history: usize, scratch: usize| {
        let (mut history, mut scratch) = (vec![0; history], vec![0; scratch]);
        let error = OneRings::new(5, &[[0, 1, 2]], &mut history, &mut scratch).err()?;
        Some((error.buffer, error.needed, error.capacity))
    };
    assert_eq!(error(words, scratch_words), None);
    let mut history = vec![0; words];
    let rings = OneRings::new_unchecked(5, &[[0, 1, 2]], &mut history);
    let short = rings.with_links(&mut vec![0; scratch_words]).err().unwrap();
    assert_eq!((short.buffer, short.needed), ("links", links_bound(5, 1)));
    assert_eq!(error(words - 1, scratch_words), Some(("history", words, words - 1)));
    assert_eq!(
        error(words, scratch_words - 1),
        Some(("scratch", scratch_words, scratch_words - 1))
    );
}

/// A sheet over so many vertices that are moved at random: some of them are certified.
fn crumpled(vertices: usize) -> MeshData {
    let (mut rng, n) = (seeded(1), vertices.isqrt() as u32);
    let mut soup = sheet(n, |_, _| 0.0).map(|p| {
        let [aside, height] = [0; 2].map(|_| rng.random_range(0.0..0.84));
        [0.5 * n as f32 * p[0] + aside, 0.5 * n as f32 * p[1] - aside, height]
    });
    soup.positions.truncate(vertices);
    soup.triangles.retain(|t| t.iter().all(|&v| (v as usize) < vertices));
    soup
}

/// How often so many items are halved until no part is longer than [`FINE`].
fn halvings(items: usize) -> usize {
    let half = items / 2;
    if items <= FINE { 0 } else { 1 + halvings(half) + halvings(items - half) }
}

#[test]
fn parts_certify_what_the_whole_does() {
    for vertices in [0, 3, 8192, 8193, 16_384, 16_385, 40_000] {
        for shuffled in [false, true] {
            let MeshData { positions, mut triangles } = crumpled(vertices);
            let n = triangles.len();
            if shuffled {
                (0..n).for_each(|i| triangles.swap(i, i * 7919 % n));
            }
            let mesh = Mesh::new(&positions, &triangles).unwrap();
            let joins = AtomicUsize::new(0);
            let join: &Join<'_> = &|a, b| {
                joins.fetch_add(1, Relaxed);
                b();
                a();
            };
            with_rings(vertices, &triangles, |rings| {
                let whole = certified(rings, mesh, None);
                assert_eq!(certified(rings, mesh, Some(join)), whole);
                let some = whole.iter().filter(|&&is| is).count();
                let range = vertices / 10..vertices * 9 / 10;
                assert!(vertices < 8192 || range.contains(&some), "{some} of {vertices}");
            });
            assert_eq!(
                joins.into_inner(),
                halvings(n) + halvings(vertices),
                "{vertices}, shuffled: {shuffled}"
            );
        }
    }
}

/// A row that turns less than once, and more than once when its second vertex has moved by less than a step of the shadow,
/// which a triangle far away makes coarse.
#[cfg(feature = "f64")]
#[test]
fn an_f64_mesh_that_moves_by_less_than_a_step_of_its_shadow_gives_the_true_pairs() {
    let row =
        [[0.0, 0.0], [0.5, 0.0], [0.0, 1.0], [-1.0, 0.5], [-1.0, -0.5], [0.0, -1.0], [20.0, -0.08]];
    let at = |second: f64| -> Vec<[f64; 3]> {
        let mut points: Vec<_> = row.iter().map(|p| [p[0], p[1] + 6e5, 0.0]).collect();
        points[1][1] = 6e5 + second;
        points.extend([[1e6; 3], [-1e6; 3], [1e6, 0.0, 0.0]]);
        points
    };
    let mut triangles: Vec<[u32; 3]> = (1..6).map(|k| [0, k, k + 1]).collect();
    triangles.push([7, 8, 9]);
    let (before, after) = (at(0.02), at(-0.0025));
    let (mut shadow, mut second) = (vec![[0.0; 3]; 10], vec![[0.0; 3]; 10]);
    let rest = Mesh::from_f64(&before, &triangles, &mut shadow).unwrap();
    let moved = rest.with_positions_f64(&after, &mut second).unwrap();
    assert_eq!(rest.shadow(), moved.shadow(), "below a step");
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(6)], vec![0; 6]);
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let bvh = morton(moved, &BuildOptions::default(), storage, &mut [0; 12]).unwrap();
    with_rings(10, &triangles, |rings| {
        assert!(rings.certify(rest, None).is_certified(0));
        let query = SelfBvtt::new(bvh);
        assert!(query.count() > 0);
        let certified = rings.certify(moved, None);
        assert_eq!(query.with_certificates(certified).count(), query.count());
    });
}

#[test]
fn fans_are_used_for_their_own_tree_and_not_for_boxes() {
    let disc = circle(100, 1.0, |_| 0.0);
    let points: Vec<_> = [[0.0; 3]].into_iter().chain(disc).collect();
    let triangles: Vec<_> = (0..100).map(|i| [0, 1 + i, 1 + (i + 1) % 100]).collect();
    let mesh = Mesh::new(&points, &triangles).unwrap();
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(100)], vec![0; 100]);
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 200]).unwrap();
    let (nodes, order) = (bvh.nodes().to_vec(), bvh.order().to_vec());
    let words = fan_bound(nodes.len());
    with_rings(points.len(), &triangles, |rings| {
        assert!(rings.has_fans());
        let certified = rings.certify(mesh, None);
        let mut marks = vec![!0; words];
        let short = certified.with_fans(&bvh, &mut marks[1..]).unwrap_err();
        assert_eq!((short.buffer, short.needed, short.capacity), ("marks", words, words - 1));
        let fans = certified.with_fans(&bvh, &mut marks).unwrap();
        let query = SelfBvtt::new(bvh);
        assert!(query.with_certificates(fans).start().is_done());
        assert!(!query.with_certificates(certified).start().is_done());
        let boxes = query.boxes_only().count();
        assert!(boxes > 0);
        assert_eq!(query.with_certificates(fans).boxes_only().count(), boxes);
        assert_eq!(query.boxes_only().with_certificates(fans).count(), boxes);
        // The same tree in other memory.
        for other in [
            Bvh::new_unchecked(mesh, &nodes, bvh.order()),
            Bvh::new_unchecked(mesh, bvh.nodes(), &order),
        ] {
            assert!(!SelfBvtt::new(other).with_certificates(fans).start().is_done());
        }
    });
    // A hub that moves away from its disc is not certified, and its fans are not skipped.
    let mut folded = points.clone();
    folded[0] = [3.0, 0.0, 0.0];
    let folded = mesh.with_positions(&folded).unwrap();
    let mut refitted = nodes.clone();
    refit(folded, &mut refitted, &order, Refit::default()).unwrap();
    let bvh = Bvh::new_unchecked(folded, &refitted, &order);
    with_rings(points.len(), &triangles, |rings| {
        let mut marks = vec![!0; words];
        let fans = rings.certify(folded, None).with_fans(&bvh, &mut marks).unwrap();
        let query = SelfBvtt::new(bvh);
        assert!(query.count() > 0);
        assert_eq!(query.with_certificates(fans).count(), query.count());
    });
}

/// Two triangles that share vertex 0: side by side at first, then one through the other.
const REST: [[f32; 3]; 4] = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [-2.0, 0.0, 0.0]];
const FOLDED: [[f32; 3]; 4] = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.5, 0.1, 0.0]];
const HINGE: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// The number of hits on the folded hinge, with certificates of these positions for these triangles.
fn hits(certified_for: &[[f32; 3]], triangles: &[[u32; 3]]) -> u64 {
    let rest = Mesh::new(&REST, &HINGE).unwrap();
    let (mut nodes, mut order) = ([Node::EMPTY; node_bound(2)], [0; 2]);
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let options = BuildOptions { leaf_size: 1, ..Default::default() };
    morton(rest, &options, storage, &mut [0; 4]).unwrap();
    let folded = rest.with_positions(&FOLDED).unwrap();
    refit(folded, &mut nodes, &order, Refit::default()).unwrap();
    let bvh = Bvh::new(folded, &nodes, &order, &mut [0; 8]).unwrap();
    with_rings(4, triangles, |rings| {
        let mesh = Mesh::new(certified_for, triangles).unwrap();
        let certified = rings.certify(mesh, None);
        assert_eq!(certified.is_certified(0), certified_for == REST);
        SelfBvtt::new(bvh).with_certificates(certified).count()
    })
}

#[test]
fn certificates_of_other_positions_lose_no_pair() {
    assert_eq!(hits(&FOLDED, &HINGE), 1);
    assert_eq!(hits(&REST, &HINGE), 1);
    assert_eq!(hits(&REST, &HINGE.map(|t| t)), 1);
}

#[test]
fn one_rings_of_other_triangles_certify_nothing() {
    let turned = [[0, 1, 2], [0, 3, 2]];
    with_rings(4, &HINGE, |rings| {
        let mesh = Mesh::new(&REST, &HINGE).unwrap();
        assert!(certified(rings, mesh, None)[0]);
        let copy = HINGE.to_vec();
        assert!(certified(rings, Mesh::new(&REST, &copy).unwrap(), None)[0]);
        let other = Mesh::new(&REST, &turned).unwrap();
        assert_eq!(certified(rings, other, None), [false; 4]);
    });
    let more = [REST.as_slice(), &[[9.0; 3]]].concat();
    with_rings(4, &HINGE, |rings| {
        let mesh = Mesh::new(&more, &HINGE).unwrap();
        assert_eq!(certified(rings, mesh, None), [false; 5]);
    });
}

/// A row that turns a little more than once, in a mesh so large that its shadow knows the y of its corners to 1/16.
#[cfg(feature = "f64")]
#[test]
fn certificates_in_f64_hold_where_those_of_the_shadow_lie() {
    use crate::triangle::{Adjacency, intersects_in_mesh};
    let row = [
        [0.0, 0.0],
        [0.5, -0.002_5],
        [0.0, 1.0],
        [-1.0, 0.5],
        [-1.0, -0.5],
        [0.0, -1.0],
        [20.0, -0.08],
    ];
    let at = |end: f64| {
        let mut positions: Vec<_> = row.iter().map(|p| [p[0], p[1] + 6e5, 0.0]).collect();
        positions[6][1] = end + 6e5;
        positions.extend([[1e6; 3], [-1e6; 3], [1e6, 0.0, 0.0]]);
        positions
    };
    let mut triangles: Vec<[u32; 3]> = (1..6).map(|k| [0, k, k + 1]).collect();
    triangles.push([7, 8, 9]);
    let certified = |mesh: Mesh<'_>| {
        with_rings(mesh.vertex_count(), &triangles, |rings| {
            rings.certify(mesh, None).is_certified(0)
        })
    };
    // The end beyond the beginning, and before it.
    for (end, overlaps) in [(-0.08, true), (-0.2, false)] {
        let positions = at(end);
        let mut shadow = vec![[0.0; 3]; positions.len()];
        let mesh = Mesh::from_f64(&positions, &triangles, &mut shadow).unwrap();
        let rule = Adjacency::SharedIndexRule;
        assert_eq!(intersects_in_mesh(mesh, 0, 4, rule), overlaps);
        assert!(certified(Mesh::new(mesh.shadow(), &triangles).unwrap()));
        assert!(!(overlaps && certified(mesh)));
    }
    // A row that both certify.
    let mut positions = at(-0.2);
    positions[1][1] = 6e5 + 0.1;
    let mut shadow = vec![[0.0; 3]; positions.len()];
    let mesh = Mesh::from_f64(&positions, &triangles, &mut shadow).unwrap();
    assert!(certified(mesh));
}
