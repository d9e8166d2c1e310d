//! A model that deforms: whatever is refitted, when and by whom, is what a whole refit would give, and a
//! stamp says what the model holds.

mod history;
mod together;

use pfront::{BuildOptions, Executor, Model};
use pfront_core::bvh::{self, Refit};
use pfront_testkit::MeshData;
use pfront_testkit::shapes::bumpy;

const SIDE: u32 = 24;

fn model(soup: &MeshData) -> Model {
    let options = BuildOptions { leaf_size: 3, ..BuildOptions::default() };
    Executor::sequential().build(soup.positions.clone(), soup.triangles.clone(), options).unwrap()
}

/// Everything that the model keeps is equal to the same computed anew.
fn assert_fits(model: &Model) {
    let bvh = model.bvh();
    let mut nodes = bvh.nodes().to_vec();
    bvh::refit(bvh.mesh(), &mut nodes, bvh.order(), Refit::default()).unwrap();
    assert_eq!(nodes, bvh.nodes());
    let (positions, triangles) = (model.mesh().positions().unwrap(), model.mesh().triangles());
    let fresh = Model::new(positions.to_vec(), triangles.to_vec()).unwrap();
    assert_eq!(certified(model), certified(&fresh));
    assert!(model.sphere().is_some_and(|sphere| {
        let reach = |p: &[f32; 3]| (0..3).map(|k| (p[k] - sphere.centre[k]).powi(2)).sum::<f32>();
        positions.iter().all(|p| reach(p).sqrt() <= sphere.radius * 1.00001)
    }));
}

/// Whether each vertex is certified.
fn certified(model: &Model) -> Vec<bool> {
    let (certified, vertices) = (model.certificates(), model.mesh().vertex_count() as u32);
    (0..vertices).map(|vertex| certified.is_certified(vertex)).collect()
}

/// The sheet after some of its vertices have gone up and aside.
fn shifted(soup: &MeshData, by: f32, which: impl Fn(usize) -> bool) -> Vec<[f32; 3]> {
    let by = |i: usize| if which(i) { by } else { 0.0 };
    let shifted = soup.positions.iter().enumerate();
    shifted.map(|(i, p)| [p[0] + by(i), p[1], p[2] + by(i)]).collect()
}

#[test]
fn few_moves_are_refitted_by_a_table_and_many_without() {
    let soup = bumpy(SIDE);
    let mut model = model(&soup);
    let bytes = model.bytes();
    model.set_positions(&shifted(&soup, 0.1, |_| true)).unwrap();
    assert_eq!(model.bytes(), bytes);
    model.set_positions(&shifted(&soup, 0.1, |i| i > 20)).unwrap();
    assert!(model.bytes() > bytes + model.bvh().nodes().len() * 8);
    assert_fits(&model);
}

#[test]
fn what_was_asked_for_long_ago_is_brought_up_to_date() {
    let soup = bumpy(SIDE);
    let mut model = model(&soup);
    assert!(model.certificates().is_certified(200) && model.sphere().is_some());
    // Near vertex 200, which the tree is told of, but not the certificates.
    model.set_positions_unfitted(&shifted(&soup, 9.0, |i| i == 200 || i == 202)).unwrap();
    model.bvh().assert_well_formed();
    // Then elsewhere.
    let moved = shifted(&soup, 9.0, |i| i == 200 || i == 202 || i == 400);
    model.set_positions_unfitted(&moved).unwrap();
    let fresh = Model::new(moved, soup.triangles.clone()).unwrap();
    let count = |model: &Model| certified(model).iter().filter(|&&is| is).count();
    assert!(count(&fresh) < count(&self::model(&soup)));
    assert_fits(&model);
    let [found, expected] = [model.sphere(), fresh.sphere()].map(Option::unwrap);
    assert!((found.radius - expected.radius).abs() < 0.1, "{found:?}");
}

#[test]
fn a_stamp_says_what_is_the_same() {
    let soup = bumpy(SIDE);
    let mut model = model(&soup);
    let (first, copy) = (model.stamp(), model.clone());
    let parts = |model: &Model| {
        let stamp = model.stamp();
        (stamp.mesh() == first.mesh(), stamp.tree() == first.tree())
    };
    assert_ne!(self::model(&soup).stamp(), first, "of a mesh built twice");
    assert!(model.set_positions(&[[f32::NAN; 3]; 1]).is_err());
    assert!(model.set_positions_unfitted(&shifted(&soup, f32::NAN, |i| i > 99)).is_err());
    model.set_positions(&soup.positions).unwrap();
    model.set_positions_unfitted(&soup.positions).unwrap();
    model.fit();
    assert_eq!(model.stamp(), first, "nothing has changed");
    let moved = shifted(&soup, 0.1, |_| true);
    model.set_positions_unfitted(&moved).unwrap();
    let second = model.stamp();
    assert!(second != first && parts(&model) == (true, true));
    let later = model.clone();
    assert!(later.bvh().nodes() != copy.bvh().nodes() && later.stamp() == second);
    model.fit();
    assert_eq!(model.stamp(), second, "a refit changes nothing that a stamp tells");
    assert_eq!(model.bvh().nodes(), later.bvh().nodes());
    model.set_positions(&soup.positions).unwrap();
    assert!(![first, second].contains(&model.stamp()), "nobody knows that it is back");
    assert_eq!(copy.stamp(), first);
    let zeros = shifted(&soup, 0.0, |_| true).iter().map(|p| p.map(|x| x - x)).collect::<Vec<_>>();
    model.set_positions(&zeros).unwrap();
    let third = model.stamp();
    model.set_positions(&zeros.iter().map(|p| p.map(|x| -x)).collect::<Vec<_>>()).unwrap();
    assert_ne!(model.stamp(), third, "zeros with their signs");
}

/// The sheet torn into triangles that lie about at random, far apart or not.
fn torn() -> (Model, Vec<[f32; 3]>) {
    let soup = bumpy(SIDE);
    let vertices = soup.triangles.as_flattened();
    let corners: Vec<_> = vertices.iter().map(|&v| soup.positions[v as usize]).collect();
    let triangles = (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let thrown = |i: usize| [1, 7, 13].map(|by| ((i / 3 * by * 37) % 101) as f32 * 0.05);
    let scattered = corners.iter().enumerate().map(|(i, p)| {
        let to = thrown(i);
        [0, 1, 2].map(|k| p[k] + to[k])
    });
    let scattered = scattered.collect();
    (Model::new(corners, triangles).unwrap(), scattered)
}

#[test]
fn a_worn_tree_is_rebuilt_and_the_stamp_says_so() {
    let (model, scattered) = torn();
    let fresh = Model::new(scattered.clone(), model.mesh().triangles().to_vec()).unwrap();
    let (mut eager, mut lazy, mut fitted) = (model.clone(), model.clone(), model.clone());
    eager.set_positions(&scattered).unwrap();
    assert_eq!(eager.bvh().nodes(), fresh.bvh().nodes());
    assert_ne!(eager.stamp().tree(), model.stamp().tree());

    fitted.set_positions_unfitted(&scattered).unwrap();
    assert_eq!(fitted.stamp().tree(), model.stamp().tree());
    fitted.fit();
    assert_eq!(fitted.bvh().nodes(), fresh.bvh().nodes());
    assert_ne!(fitted.stamp().tree(), model.stamp().tree());

    lazy.set_positions_unfitted(&scattered).unwrap();
    assert_eq!(lazy.bvh().order(), model.bvh().order());
    assert_eq!(lazy.stamp().tree(), model.stamp().tree());
    let mut again = scattered;
    again[0][0] += 1.0;
    let fresh = Model::new(again.clone(), model.mesh().triangles().to_vec()).unwrap();
    lazy.set_positions_unfitted(&again).unwrap();
    let announced = lazy.stamp();
    assert_ne!(announced.tree(), model.stamp().tree());
    assert_eq!(lazy.clone().bvh().nodes(), fresh.bvh().nodes());
    assert_eq!(lazy.bvh().nodes(), fresh.bvh().nodes());
    lazy.fit();
    assert_eq!(lazy.stamp(), announced);
    assert_fits(&lazy);
}
