//! Queries that start from node pairs of the host's: what the device finds below some, with what the core
//! finds below the others, is the whole answer.

use crate::common::{Both, gpu, sorted, truth};
use pfront_core::bvh::BuildOptions;
use pfront_core::bvtt::{self, Cursor, NodePair, Query, TrianglePair};
use pfront_core::{Mesh, Pose};
use pfront_gpu::{Budget, Deforming, Error, Model, PairQuery, Pending, SelfQuery, Settings};
use pfront_oracle::generate::soup::{Soup, family, sheet, sphere};
use pfront_oracle::generate::{self, Family};
use pfront_scenes::Scene;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::ops::ControlFlow;

/// Nodes of the BVTT `levels` below its root, and the leaf pairs above.
fn front(query: &impl Query, levels: u32) -> Vec<NodePair> {
    let mut front = Vec::from_iter(query.root());
    for _ in 0..levels {
        let mut next = Vec::new();
        for &pair in &front {
            if query.expand(pair, &mut |child| next.push(child)) == 0 {
                next.push(pair);
            }
        }
        front = next;
    }
    front
}

/// Submits what `record` records.
fn asked<'q>(
    record: impl FnOnce(&mut pfront_gpu::wgpu::CommandEncoder) -> Result<Pending<'q>, Error>,
) -> Vec<TrianglePair> {
    let mut encoder = gpu().device().create_command_encoder(&Default::default());
    let pending = record(&mut encoder).unwrap();
    gpu().queue().submit([encoder.finish()]);
    pending.read().unwrap().to_vec()
}

/// Checks that the core below some nodes and the device below the others find the truth. The device gets
/// every node of which `is_mine` says so by its number.
fn check(
    core: &impl Query,
    levels: u32,
    is_mine: impl Fn(usize) -> bool,
    device: impl FnOnce(&[NodePair]) -> Vec<TrianglePair>,
) -> usize {
    let truth = sorted(core);
    let mut pairs = Vec::new();
    let (mut mine, mut number) = (front(core, levels), 0);
    mine.retain(|&pair| {
        number += 1;
        if !is_mine(number) {
            let _ = core.visit(&mut Cursor::at(pair), |pair| {
                pairs.push(pair);
                ControlFlow::Continue(())
            });
        }
        is_mine(number)
    });
    let found = device(&mine);
    assert!(found.is_sorted());
    pairs.extend(found);
    pairs.sort();
    assert!(pairs == truth, "{} pairs, not {}, from {}", pairs.len(), truth.len(), mine.len());
    truth.len()
}

fn both(soup: &Soup, leaf_size: u32) -> Both {
    Both::new(&soup.positions, &soup.triangles, leaf_size)
}

fn with_budget(bytes: u64) -> Settings {
    Settings { budget: Budget { bytes }, ..gpu().settings() }
}

#[test]
fn two_meshes_from_every_level() {
    let knots = Scene::by_name("torus-knots", Some(6_000)).unwrap();
    let mut poses = Vec::new();
    knots.poses(knots.frames() / 2, &mut poses);
    let [a, b] = [0, 1].map(|i| &knots.meshes[knots.objects[i]]);
    let [a, b] = [a, b].map(|mesh| Both::new(&mesh.positions, &mesh.triangles, 4));
    let flat = both(&sheet(20, |_, _| 0.0), 4);
    // In the least budget a front has 1,024 nodes, fewer than the deepest of these.
    for bytes in [Budget::LEAST.bytes, 16 << 20] {
        let mut query = PairQuery::with_settings(gpu(), with_budget(bytes)).unwrap();
        for (a, b, pose) in [(&a, &b, Pose::new(poses[1])), (&flat, &flat, Pose::IDENTITY)] {
            let core = bvtt::PairQuery::new(a.bvh(), b.bvh(), pose).unwrap();
            for levels in [0, 3, 7, 40] {
                for modulus in [1, 5] {
                    let found = check(
                        &core,
                        levels,
                        |i| i % modulus == 0,
                        |front| {
                            asked(|encoder| {
                                query.record_below(encoder, &a.model, &b.model, &pose, front)
                            })
                        },
                    );
                    assert!(found > 500);
                }
            }
            // All of it still is what it was.
            assert!(query.all(&a.model, &b.model, &pose).unwrap() == truth(a, b, &pose));
        }
    }
}

#[test]
fn one_mesh_from_every_level() {
    let scene = Scene::by_name("sheet", Some(6_000)).unwrap();
    let (mut positions, mut moved) = (Vec::new(), Vec::new());
    scene.positions(0, &mut positions);
    let mut sheet = Both::new(&positions, &scene.meshes[0].triangles, 4);
    let mut moving = Deforming::new(gpu(), sheet.bvh()).unwrap();
    for bytes in [Budget::LEAST.bytes, 16 << 20] {
        let mut query = SelfQuery::with_settings(gpu(), with_budget(bytes)).unwrap();
        // Refitted here and there, it keeps its tree.
        for (frame, levels) in [(60, 0), (61, 2), (150, 4), (61, 6), (100, 40)] {
            scene.positions(frame, &mut moved);
            sheet.set_positions(&moved);
            moving.set_positions(&moved).unwrap();
            let core = bvtt::SelfQuery::new(sheet.bvh());
            for modulus in [1, 3] {
                let found = check(
                    &core,
                    levels,
                    |i| i % modulus == 0,
                    |front| asked(|encoder| query.record_below(encoder, &moving, front)),
                );
                assert!(found > 0);
            }
        }
    }
}

#[test]
fn soups_of_every_family() {
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let (mut pair, mut own) = (PairQuery::new(gpu()).unwrap(), SelfQuery::new(gpu()).unwrap());
    for f in Family::ALL {
        for leaf_size in [1, 4] {
            let [a, b] = [0; 2].map(|_| both(&family(f, 80, &mut rng), leaf_size));
            let pose = match f {
                Family::Huge | Family::RawBits => Pose::IDENTITY,
                _ => Pose::new(generate::soup::pose_rows(0.1, &mut rng)),
            };
            let core = bvtt::PairQuery::new(a.bvh(), b.bvh(), pose).unwrap();
            check(
                &core,
                3,
                |i| i % 2 == 0,
                |front| {
                    asked(|encoder| pair.record_below(encoder, &a.model, &b.model, &pose, front))
                },
            );
            check(
                &bvtt::SelfQuery::new(a.bvh()),
                3,
                |i| i % 2 == 1,
                |front| asked(|encoder| own.record_below(encoder, &a.model, front)),
            );
        }
    }
}

#[test]
fn nothing_to_start_from() {
    let mut query = PairQuery::new(gpu()).unwrap().with_time().unwrap();
    let (none, ball) = (both(&Soup::default(), 4), both(&sphere(12), 4));
    let far = Pose::from_translation([9.0, 0.0, 0.0]);
    for (a, b) in [(&none, &none), (&none, &ball), (&ball, &none), (&ball, &ball)] {
        assert_eq!(asked(|e| query.record_below(e, &a.model, &b.model, &far, &[])), []);
        assert_eq!(query.timings().unwrap(), []);
    }
    // The roots, apart.
    let roots = [NodePair { a: 0, b: 0 }];
    assert_eq!(asked(|e| query.record_below(e, &ball.model, &ball.model, &far, &roots)), []);
}

#[test]
fn what_cannot_be_asked_is_an_error() {
    let ball = both(&sphere(12), 4);
    let nodes = ball.bvh().nodes().len() as u32;
    let roots = [NodePair { a: 0, b: 0 }];
    let mut encoder = gpu().device().create_command_encoder(&Default::default());
    let mut own = SelfQuery::new(gpu()).unwrap();
    let mut refused = |model: &Model, front: &[NodePair]| {
        own.record_below(&mut encoder, model, front).unwrap_err()
    };
    let front = [roots[0], NodePair { a: 0, b: nodes }];
    assert_eq!(refused(&ball.model, &front), Error::NoSuchNode { node: nodes, nodes });
    let empty = both(&Soup::default(), 4);
    assert_eq!(refused(&empty.model, &roots), Error::NoSuchNode { node: 0, nodes: 0 });

    let soup = sphere(12);
    let mesh = Mesh::new(&soup.positions, &soup.triangles).unwrap();
    let built = Deforming::build(gpu(), mesh, &BuildOptions::default()).unwrap();
    assert_eq!(refused(&built, &roots), Error::BuiltOnDevice);
    let mut rebuilt = Deforming::new(gpu(), ball.bvh()).unwrap();
    rebuilt.rebuild().unwrap();
    assert_eq!(refused(&rebuilt, &roots), Error::BuiltOnDevice);

    let mut pair = PairQuery::new(gpu()).unwrap();
    let pose = Pose::IDENTITY;
    let error = pair.record_below(&mut encoder, &ball.model, &built, &pose, &roots).unwrap_err();
    assert_eq!(error, Error::BuiltOnDevice);
    // Nothing came of it.
    let pose = Pose::from_translation([0.3, 0.0, 0.0]);
    assert_eq!(pair.all(&ball.model, &ball.model, &pose).unwrap(), truth(&ball, &ball, &pose));
}
