//! How fast pfront is beside others: update and query, on one thread, all pairs that meet.
//!
//! `cargo bench --bench peers` measures pfront, which is exact, against parry3d, and with
//! `--features bench-embree` against Embree, which Debian has as libembree-dev. Times are those of one
//! frame, the mean over the frames of a workload; posing and refitting are part of it, building is
//! not. Everybody makes a list of the hits; only pfront sorts it.
//!
//! - "parry" tests two triangles by parry's own GJK. Each "+ fast test" is parry's or Embree's BVH
//!   under the same plain f32 test, pfront's [`pfront::Accuracy::Fast`], so that the trees are compared.
//! - Within the sheet, only pfront judges triangles that share a vertex, and answers for them as well;
//!   the others leave them out.
//! - Each body of the 500 has a mesh of its own, as if no two were alike.
//! - Flush contact is between two voxel solids on one grid: coplanar faces that overlap, touch along
//!   edges or at corners. "posed" is wrong there because a quaternion does not rotate exactly.
//!
//! Answers are checked in every frame before anything is timed: what an exact test leaves of all
//! candidates of parry's BVHs has to be what pfront finds. What the others miss and invent is printed.
//! This takes 20 seconds, and is what `-- --test` does; all of it takes a minute and a half.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

#[cfg(feature = "bench-embree")]
mod embree;
mod ours;
mod parry;
mod work;

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::{Duration, Instant};
use work::{Finder, Hit, Work};

fn all_pairs(c: &mut Criterion) {
    let works = [
        Work::course("two bodies 70K", 70_000),
        Work::course("two bodies 500K", 500_000),
        Work::sheet("sheet 92K", 92_000),
        Work::crowd("500 bodies 800K", 500),
        Work::voxels("flush contact 5K", 5000),
    ];
    for work in &works {
        let truth = truth(work);
        let mut finders = vec![
            ("pfront", ours::all(work)),
            ("parry", parry::all(work, parry::own)),
            ("parry tree + fast test", parry::all(work, parry::fast)),
        ];
        if work.meshes.len() == 2 {
            finders.push(("parry posed tree + fast test", parry::posed(work, parry::fast)));
        }
        #[cfg(feature = "bench-embree")]
        finders.push(("Embree tree + fast test", embree::all(work)));
        let mut group = group(c, &work.name);
        for (name, mut finder) in finders {
            judge(work, name, &mut finder, &truth);
            time(&mut group, work, name, &mut finder);
        }
    }
}

fn first_hit(c: &mut Criterion) {
    let work = Work::course("first hit of two bodies 70K", 70_000);
    let finders = [
        ("pfront", ours::first(&work)),
        ("parry", parry::first(&work)),
        ("parry posed tree + fast test", parry::first_posed(&work, parry::fast)),
    ];
    let mut group = group(c, &work.name);
    for (name, mut finder) in finders {
        let right = (0..work.frames()).filter(|&frame| {
            let hits = found(&work, &mut finder, frame);
            hits.len() == 1 && work.exact(frame, hits.clone()) == hits
        });
        let right = right.count();
        eprintln!("{}: {name} is right in {right} of {} frames", work.name, work.frames());
        assert!(right == work.frames() || name != "pfront");
        time(&mut group, &work, name, &mut finder);
    }
}

/// The pairs that pfront finds in each frame, checked against parry's candidates that pass an exact test.
fn truth(work: &Work) -> Vec<Vec<Hit>> {
    let mut ours = ours::all(work);
    let mut candidates = parry::all(work, |_, _| true);
    let frame = |frame| {
        let ours = found(work, &mut ours, frame);
        let theirs = work.exact(frame, found(work, &mut candidates, frame));
        assert!(ours == theirs && !ours.is_empty(), "{}, frame {frame}", work.name);
        ours
    };
    (0..work.frames()).map(frame).collect()
}

/// Says how many hits are missed and invented.
fn judge(work: &Work, name: &str, finder: &mut Finder<'_>, truth: &[Vec<Hit>]) {
    let (mut total, mut missed, mut invented) = (0, 0, 0);
    for (frame, truth) in truth.iter().enumerate() {
        let hits = found(work, finder, frame);
        let beyond = |hits: &[Hit], of: &[Hit]| {
            hits.iter().filter(|hit| of.binary_search(hit).is_err()).count()
        };
        total += truth.len();
        missed += beyond(truth, &hits);
        invented += beyond(&hits, truth);
    }
    eprintln!("{}: {name} misses {missed} and invents {invented} of {total} pairs", work.name);
}

/// The hits that all can be asked for, sorted.
fn found(work: &Work, finder: &mut Finder<'_>, frame: usize) -> Vec<Hit> {
    let mut hits = Vec::new();
    finder(frame, &mut hits);
    hits.retain(|hit| work.apart(hit));
    hits.sort_unstable();
    hits
}

type Group<'c> = criterion::BenchmarkGroup<'c, criterion::measurement::WallTime>;

fn group<'c>(c: &'c mut Criterion, name: &str) -> Group<'c> {
    let mut group = c.benchmark_group(name);
    group.sample_size(10);
    group.warm_up_time(Duration::from_millis(500));
    group.measurement_time(Duration::from_secs(2));
    group
}

/// Times all frames, and reports one.
fn time(group: &mut Group<'_>, work: &Work, name: &str, finder: &mut Finder<'_>) {
    let mut hits = Vec::new();
    group.bench_function(name, |bench| {
        bench.iter_custom(|times| {
            let start = Instant::now();
            for frame in (0..times).flat_map(|_| 0..work.frames()) {
                hits.clear();
                finder(frame, &mut hits);
                black_box(&hits);
            }
            start.elapsed() / work.frames() as u32
        });
    });
}

criterion_group!(benches, all_pairs, first_hit);
criterion_main!(benches);
