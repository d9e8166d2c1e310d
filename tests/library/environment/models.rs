//! Everything that makes, moves or reads a model.

use super::Soup;
use pfront::threads::{Pool, rayon};
use pfront::{BuildOptions, Executor, Model};
use std::sync::Arc;

pub(crate) struct Inputs {
    soup: Soup,
    /// Other positions of the same triangles.
    moved: Soup,
    /// A sheet whose vertices are shared, with its positions.
    sheet: Model,
    bent: Vec<[f32; 3]>,
    blob: Vec<u8>,
    pool: Arc<rayon::ThreadPool>,
}

impl Inputs {
    pub(crate) fn new() -> Self {
        let (soup, moved) = (Soup::new(5, 100), Soup::new(6, 100));
        // So many triangles that threads take part.
        let (side, least) = (40, |units: usize| f32::from_bits(units as u32));
        let at = |i: usize, up: usize| [least(i % side * 5), least(i / side * 7), least(up)];
        let flat = (0..side * side).map(|i| at(i, 0)).collect();
        let cells = (0..side - 1).flat_map(|j| (0..side - 1).map(move |i| (j * side + i) as u32));
        let corners = |k: u32| [[k, k + 1, k + 40], [k + 1, k + 41, k + 40]];
        let sheet = Model::new(flat, cells.flat_map(corners).collect()).unwrap();
        Self {
            blob: soup.model().to_blob().unwrap(),
            bent: (0..side * side).map(|i| at(i, i * i % 11)).collect(),
            soup,
            moved,
            sheet,
            pool: Arc::new(rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap()),
        }
    }
}

/// A model for each way to make one.
pub(crate) fn all(inputs: &Inputs) -> Vec<(&'static str, Model)> {
    let Inputs { soup, moved, sheet, bent, blob, pool } = inputs;
    let options = BuildOptions::default();
    let with = |change: &dyn Fn(&mut Model)| {
        let mut model = soup.model();
        change(&mut model);
        model
    };
    let mut in_f64 = soup.model_f64();
    in_f64.set_positions(&moved.positions_f64).unwrap();
    let mut folded = sheet.clone();
    let _ = folded.certificates();
    for _ in 0..5 {
        folded.set_positions(bent).unwrap();
        folded.set_positions(sheet.mesh().shadow()).unwrap();
    }
    folded.set_positions(bent).unwrap();
    let executor = Executor::from(Pool::from(pool.clone()));
    let mesh = sheet.mesh();
    let (flat, cells) = (mesh.shadow().to_vec(), mesh.triangles().to_vec());
    let mut refitted = sheet.clone();
    executor.refit(&mut refitted, bent).unwrap();
    vec![
        ("new", soup.model()),
        ("build", executor.build(flat, cells, options).unwrap()),
        ("from_f64", soup.model_f64()),
        ("from_blob", Model::from_blob(blob).unwrap()),
        ("to_blob", Model::from_blob(&soup.model().to_blob().unwrap()).unwrap()),
        ("set_positions", with(&|model| model.set_positions(&moved.positions).unwrap())),
        ("refit", refitted),
        ("set_positions", in_f64),
        (
            "set_positions_unfitted, fit",
            with(&|model| {
                model.set_positions_unfitted(&moved.positions).unwrap();
                model.fit();
            }),
        ),
        (
            "bvh",
            with(&|model| {
                model.set_positions_unfitted(&moved.positions).unwrap();
                let _ = (model.bvh(), model.sphere(), model.bytes(), model.try_clone().unwrap());
            }),
        ),
        ("certificates", folded),
    ]
}

/// Whether two models are alike, and what is made of them lazily.
pub(crate) fn compare(made: &Model, expected: &Model, name: &str) {
    assert_eq!(made.mesh().shadow(), expected.mesh().shadow(), "{name}");
    assert_eq!(made.bvh().nodes(), expected.bvh().nodes(), "{name}");
    assert_eq!(made.bvh().order(), expected.bvh().order(), "{name}");
    assert_eq!(made.sphere(), expected.sphere(), "{name}");
    let certified = |model: &Model| -> Vec<bool> {
        let vertices = 0..model.mesh().vertex_count() as u32;
        vertices.map(|vertex| model.certificates().is_certified(vertex)).collect()
    };
    assert_eq!(certified(made), certified(expected), "{name}");
}
