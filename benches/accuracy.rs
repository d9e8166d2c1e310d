//! The cost of exactness: the exact test of two triangles beside inexact ones, and the contacts of a query.
//!
//! `cargo bench --bench accuracy`. With recorded data (`PFRONT_DATA`, see test.sh) the two bunnies of
//! the oracles are added to the generated scenes. Answers are checked before anything is timed.

#![expect(clippy::panic, reason = "a bench fails by panicking")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use pfront::{Aabb, Model, PairQuery, Pose};
use pfront_core::Triangle;
use pfront_core::bvtt::{self, Query, TrianglePair};
use pfront_core::triangle::intersects;
use pfront_testkit::inexact;
use pfront_testkit::scenes::Scene;
use std::hint::black_box;
use std::sync::LazyLock;

type Test = fn(&Triangle, &Triangle) -> bool;

const TESTS: [(&str, Test); 3] =
    [("Exact", intersects), ("Conservative", inexact::conservative), ("Fast", inexact::fast)];

struct Case {
    name: &'static str,
    a: Model,
    b: Model,
    a_from_b: Pose,
}

/// Built once.
static CASES: LazyLock<Vec<Case>> = LazyLock::new(cases);

fn cases() -> Vec<Case> {
    let mut cases = ["torus-knots", "worm-gear"].map(|name| generated(name, 60)).to_vec();
    cases.extend(bunnies());
    cases
}

impl Clone for Case {
    fn clone(&self) -> Self {
        Self { a: self.a.clone(), b: self.b.clone(), ..*self }
    }
}

fn generated(name: &'static str, frame: usize) -> Case {
    let scene = Scene::by_name(name, Some(138_902)).unwrap_or_else(|e| panic!("{e}"));
    let model = |object: usize| {
        let mesh = &scene.meshes[scene.objects[object]];
        Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap_or_else(|e| panic!("{e}"))
    };
    let mut poses = Vec::new();
    scene.poses(frame, &mut poses);
    Case { name, a: model(0), b: model(1), a_from_b: Pose::new(poses[1]) }
}

/// The case `bunny_bunny_dx015625` of the recorded oracles.
fn bunnies() -> Option<Case> {
    let folder = std::env::var_os("PFRONT_DATA")?;
    let path = std::path::Path::new(&folder).join("classic/bunny_69451.obj");
    let mesh = pfront_files::read_f32(&path).unwrap_or_else(|e| panic!("{e}"));
    let model = Model::new(mesh.positions, mesh.triangles).unwrap_or_else(|e| panic!("{e}"));
    let a_from_b = Pose::from_translation([0.015625, 0.0, 0.0]);
    let count = PairQuery::new().count(&model, &model, a_from_b).unwrap_or(0);
    assert_eq!(count, 4994, "the recorded oracle");
    Some(Case { name: "bunnies", a: model.clone(), b: model, a_from_b })
}

fn all<'q>(query: &'q mut PairQuery, a: &Model, b: &Model, pose: &Pose) -> &'q [TrianglePair] {
    query.all(a, b, pose).unwrap_or_else(|e| panic!("{e}"))
}

fn triangle_pairs(c: &mut Criterion) {
    let mut group = c.benchmark_group("triangle pair");
    for case in CASES.iter() {
        let pairs = candidates(case);
        group.throughput(Throughput::Elements(pairs.len() as u64));
        for (name, test) in TESTS {
            group.bench_function(BenchmarkId::new(case.name, name), |bench| {
                bench.iter(|| {
                    let hit = |(a, b): &&(Triangle, Triangle)| test(a, b);
                    black_box(&pairs).iter().filter(hit).count()
                });
            });
        }
    }
    group.finish();
}

/// The triangle pairs whose boxes overlap: what a query tests.
fn candidates(case: &Case) -> Vec<(Triangle, Triangle)> {
    let (a, b) = (case.a.bvh(), case.b.bvh());
    let query = bvtt::PairBvtt::new(a, b, case.a_from_b).unwrap_or_else(|e| panic!("{e}"));
    let run = |bvh: &pfront::Bvh<'_>, node: u32| {
        let leaf = bvh.nodes()[node as usize];
        bvh.order()[leaf.first as usize..][..leaf.count as usize].to_vec()
    };
    let mut pending: Vec<_> = query.root().into_iter().collect();
    let mut found = Vec::new();
    while let Some(pair) = pending.pop() {
        if query.children(pair, &mut |child, _| pending.push(child)) > 0 {
            continue;
        }
        for ta in run(&a, pair.a) {
            for tb in run(&b, pair.b) {
                let ta = a.mesh().shadow_triangle(ta);
                let tb = b.mesh().shadow_triangle(tb).map(|p| case.a_from_b.apply(p));
                if Aabb::of(&ta).overlaps(&Aabb::of(&tb)) {
                    found.push((ta, tb));
                }
            }
        }
    }
    let hits = found.iter().filter(|(a, b)| intersects(a, b)).count();
    assert_eq!(hits as u64, query.count(), "{}: not all candidates", case.name);
    found
}

fn contacts(c: &mut Criterion) {
    let Case { a, b, a_from_b, .. } = &CASES[0];
    let mut query = PairQuery::new();
    let pairs = all(&mut query, a, b, a_from_b).to_vec();
    let mut contacts = || {
        query.forget();
        query.contacts(a, b, a_from_b).map_or(0, <[_]>::len)
    };
    assert_eq!(contacts(), pairs.len());
    let mut group = c.benchmark_group("contacts");
    group.throughput(Throughput::Elements(pairs.len() as u64));
    group.bench_function("torus-knots", |bench| {
        bench.iter(&mut contacts);
    });
    group.finish();
}

criterion_group!(benches, triangle_pairs, contacts);
criterion_main!(benches);
