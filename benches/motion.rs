//! Steps of a motion: a cloth that falls on a ball, and 12 steps of a garment, of the recorded data.
//!
//! `cargo bench --bench motion [-- ROUNDS [THREADS]]`, with the data in `$PFRONT_DATA` or `../shared/data`: the best times of some rounds on
//! one thread and on some or all, beside the static query about the same positions, and tests as multiples of those of the same traversal at rest.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use pfront::{Bvh, Executor, Impact, Model, Motion, Pose, SelfQuery, TrianglePair};
use pfront_core::bvh::{Refit, refit};
use pfront_core::bvtt::{PosedBvh, SelfBvtt, Work};
use pfront_core::motion::MovingBvh;
use pfront_testkit::{checksum, data_folder};
use std::ops::ControlFlow;
use std::thread::available_parallelism;
use std::time::Instant;

fn main() {
    let mut numbers = std::env::args().filter_map(|arg| arg.parse().ok());
    let rounds = numbers.next().unwrap_or(5);
    let threads = numbers.next().unwrap_or_else(|| available_parallelism().unwrap().get());
    let data = data_folder();
    if !data.join("cloth").exists() {
        println!("no recorded cloth in {}", data.display());
        return;
    }
    let model = |file: &str| {
        let mesh = pfront_files::read_f32(&data.join("cloth").join(file)).unwrap();
        Model::new(mesh.positions, mesh.triangles).unwrap()
    };
    let ball = [92, 93].map(|frame| model(&format!("cloth_ball/cloth_ball{frame}.ply")));
    time("ball", &[ball], rounds, threads);
    let garment = model("kick/kick_frame000.ply");
    let bytes = std::fs::read(data.join("cloth/kick/kick_positions_121x12811x3.f32le")).unwrap();
    let (words, _) = bytes.as_chunks::<4>();
    let positions: Vec<_> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
    let (positions, _) = positions.as_chunks::<3>();
    let frame = |frame: usize| {
        let mut model = garment.clone();
        model.set_positions(&positions[frame * 12_811..][..12_811]).unwrap();
        model
    };
    let steps: Vec<_> = (0..12).map(|step| [frame(10 * step), frame(10 * step + 1)]).collect();
    time("kick", &steps, rounds, threads);
}

/// Prints how long a step takes in the mean.
fn time(name: &str, steps: &[[Model; 2]], rounds: usize, threads: usize) {
    let motions: Vec<_> = steps.iter().map(|[p, q]| Motion::between(p, q).unwrap()).collect();
    let best = |of: &mut dyn FnMut()| {
        let mut once = || {
            let begin = Instant::now();
            of();
            begin.elapsed().as_secs_f64() * 1e3 / steps.len() as f64
        };
        (0..rounds).map(|_| once()).fold(f64::INFINITY, f64::min)
    };
    let mut found: Vec<Vec<(TrianglePair, Impact)>> = Vec::new();
    let (mut firsts, mut query) = (Vec::new(), SelfQuery::new());
    let one = best(&mut || {
        found = motions.iter().map(|motion| query.impacts(motion).unwrap()).collect();
    });
    let first = best(&mut || {
        firsts = motions.iter().map(|motion| query.first_impact(motion).unwrap()).collect();
    });
    let mut many = SelfQuery::new().on(&Executor::threads(threads));
    let all = best(&mut || {
        let mut answers = motions.iter().zip(&found);
        assert!(answers.all(|(motion, found)| many.impacts(motion).unwrap() == *found));
    });
    let first_of_all = best(&mut || {
        let mut answers = motions.iter().zip(&firsts);
        assert!(answers.all(|(motion, first)| many.first_impact(motion).unwrap() == *first));
    });
    let still = best(&mut || {
        for [start, _] in steps {
            query.forget();
            query.count(start).unwrap();
        }
    });
    let [moving, at_rest] = work(steps);
    let pairs: Vec<_> = found.iter().flatten().collect();
    let proven = pairs.iter().filter(|(_, impact)| impact.is_proven()).count();
    // By it answers of two programs are compared.
    let digest = checksum(pairs.iter().flat_map(|(pair, impact)| {
        let words = [pair.a.into(), pair.b.into(), impact.from.to_bits(), impact.to.to_bits()];
        words.into_iter().flat_map(u64::to_le_bytes)
    }));
    println!("{name}: {} pairs, {proven} proven, digest {digest:016x}", pairs.len());
    println!(
        "  impacts {one:.2} ms, on {threads} threads {all:.2} ms; first {first:.2} ms, on threads {first_of_all:.2} ms; static {still:.2} ms"
    );
    let times = |of: fn(&Work) -> u64| of(&moving) as f64 / of(&at_rest) as f64;
    let [boxes, triangles] = [times(|work| work.box_tests), times(|work| work.triangle_tests)];
    println!("  box tests {} x {boxes:.3}", moving.box_tests);
    println!("  triangle tests {} x {triangles:.3}", moving.triangle_tests);
}

/// Tests of the motions, and of the same traversal from the start to itself.
fn work(steps: &[[Model; 2]]) -> [Work; 2] {
    let mut works = [Work::default(); 2];
    for [start, end] in steps {
        let (bvh, mut nodes) = (start.bvh(), start.bvh().nodes().to_vec());
        refit(end.mesh(), &mut nodes, bvh.order(), Refit::default()).unwrap();
        let moved = Bvh::new_unchecked(end.mesh(), &nodes, bvh.order());
        let [start, moved] = [bvh, moved].map(|bvh| PosedBvh::new(bvh, &Pose::IDENTITY).unwrap());
        for (work, to) in works.iter_mut().zip([moved, start]) {
            let tree = SelfBvtt::moving(MovingBvh::new(start, to).unwrap());
            let root = tree.root().unwrap();
            let _ = tree.visit_below(root, work, |_, _| ControlFlow::Continue(()));
        }
    }
    works
}
