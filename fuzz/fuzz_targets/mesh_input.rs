//! Arbitrary positions, indices, build options and poses: refused with an error or answered right.

#![no_main]

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use pfront::pfront_core::bvtt::{self, Query};
use pfront::{BuildOptions, Bvh, Executor, Model, Node, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_fuzz::input::Palette;
use pfront_fuzz::{Builder, Tree, as_pairs};
use pfront_testkit::oracle::{pairs, self_pairs};
use pfront_testkit::shapes::posed;

#[derive(Arbitrary, Debug)]
struct Input {
    /// The coordinates that `positions` and `moved` pick from.
    palette: Palette,
    positions: Vec<[u8; 3]>,
    triangles: Vec<[u8; 3]>,
    /// An index that may be out of range.
    stray: Option<u32>,
    moved: Vec<[u8; 3]>,
    leaf_size: u8,
    pose: Option<[[u32; 4]; 3]>,
    capacity: u8,
    /// Words to change in a good BVH, which then comes from elsewhere.
    edits: Vec<(u8, u32)>,
}

fuzz_target!(|input: Input| {
    let positions = input.palette.points(&input.positions);
    let range = positions.len().max(1) as u32;
    let mut triangles: Vec<_> =
        input.triangles.iter().take(24).map(|t| t.map(|v| u32::from(v) % range)).collect();
    if let (Some(stray), Some(last)) = (input.stray, triangles.last_mut()) {
        last[1] = stray;
    }

    let finite = positions.iter().flatten().all(|x| x.is_finite());
    let in_range = triangles.iter().flatten().all(|&v| (v as usize) < positions.len());
    let options = BuildOptions { leaf_size: input.leaf_size.into(), ..BuildOptions::default() };
    let model = Executor::sequential().build(positions, triangles, options);
    assert_eq!(model.is_ok(), finite && in_range);
    let Ok(mut model) = model else { return };
    check(&model, &input);
    adopt(&model, &input);

    let before = model.mesh().positions().unwrap().to_vec();
    if model.set_positions(&input.palette.points(&input.moved)).is_err() {
        assert_eq!(model.mesh().positions().unwrap(), before);
    }
    check(&model, &input);
});

/// All answers of a model against itself in a pose, and within itself.
fn check(model: &Model, input: &Input) {
    model.bvh().assert_well_formed();
    let (positions, triangles) = (model.mesh().positions().unwrap(), model.mesh().triangles());
    let truth = as_pairs(&self_pairs(positions, triangles));
    assert_eq!(SelfQuery::new().all(model).unwrap(), truth);
    pages(&bvtt::SelfBvtt::new(model.bvh()), input.capacity, &truth);
    let tree = Tree::new(model.mesh(), 8, Builder::Morton);
    pages(&bvtt::SelfBvtt::new(tree.bvh(model.mesh())), input.capacity, &truth);

    let pose =
        input.pose.map_or(Pose::IDENTITY, |rows| Pose::new(rows.map(|r| r.map(f32::from_bits))));
    let mut query = PairQuery::new();
    // A pose may be refused, with an error; what it takes is finite and answered right.
    if let Ok(found) = query.all(model, model, pose) {
        let there = posed(positions, &pose.rows);
        let corners = triangles.iter().flatten().map(|&v| there[v as usize]);
        assert!(corners.flatten().all(|x| x.is_finite()));
        let truth = as_pairs(&pairs(positions, triangles, &there, triangles));
        assert_eq!(found, truth, "{pose:?}");
        let query = bvtt::PairBvtt::new(model.bvh(), model.bvh(), pose).unwrap();
        pages(&query, input.capacity, &truth);
    }
}

fn pages(query: &impl Query, capacity: u8, truth: &[TrianglePair]) {
    assert_eq!(pfront_fuzz::pages(query, usize::from(capacity).max(1)), truth);
}

/// A BVH that the check accepts is safe to walk and gives the right answer.
fn adopt(model: &Model, input: &Input) {
    let bvh = model.bvh();
    let mut nodes: Vec<[u32; 8]> = bvh.nodes().iter().map(|n| bytemuck::cast(*n)).collect();
    let mut order = bvh.order().to_vec();
    for &(at, word) in &input.edits {
        let (at, words) = (usize::from(at), 8 * nodes.len());
        if at < words {
            nodes[at / 8][at % 8] = word;
        } else if at - words < order.len() {
            order[at - words] = word;
        }
    }
    let nodes: &[Node] = bytemuck::cast_slice(&nodes);
    let mut scratch = vec![0; order.len().div_ceil(32)];
    if let Ok(adopted) = Bvh::new(bvh.mesh(), nodes, &order, &mut scratch) {
        adopted.assert_well_formed();
        let query = bvtt::SelfBvtt::new(adopted);
        let mut truth = SelfQuery::new();
        pages(&query, input.capacity, truth.all(model).unwrap());
    }
}
