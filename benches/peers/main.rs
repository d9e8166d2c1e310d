//! How fast pfront is beside others: update and query, on one thread, all pairs that meet.
//!
//! `cargo bench --bench peers` measures pfront, which is exact, against parry3d. Times are those of one
//! frame, the mean over the frames of a workload; posing and refitting are part of it, except in "query
//! alone", and building is not. Everybody makes a list of the hits; only pfront sorts it.
//!
//! Measured are:
//! - "two bodies": torus knots of so many triangles each, in random poses; "two dragons" likewise.
//! - "sheet" and "cloth-ball": a mesh that deforms, with itself. Only pfront judges triangles that share
//!   a vertex, and answers for them as well; the others leave them out. The sheet is folded. Dragons
//!   and cloth-ball are recorded data, in `../shared/data` or the folder that `PFRONT_DATA` names, and left
//!   out where they are missing, as they may not be redistributed.
//! - "500 bodies": a crowd that moves, each with a mesh of its own, as if no two were alike.
//! - "flush contact": two voxel solids on one grid, whose faces are coplanar and overlap or touch.
//! - "first hit": whether two bodies meet, and "no hit": the same where they miss each other narrowly.
//!
//! Who is measured: "parry" tests two triangles by parry's own GJK. Each "+ fast test" is parry's BVH
//! under the same plain f32 test, [`pfront_testkit::inexact::fast`], so that the trees are
//! compared. A "posed" tree is not refitted: boxes and triangles are posed as they are met, by a
//! quaternion, which rounds, so that flush contact is missed.
//!
//! Answers are checked in every frame before anything is timed: what an exact test leaves of all
//! candidates of parry's BVHs has to be what pfront finds. Hits that the others miss or invent are
//! printed. Beside criterion's times stand the median, the sum and the worst of the frames, each at its fastest. This takes 50 seconds, and is what `-- --test` does; all of it takes some minutes.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

mod ours;
mod parry;
mod work;

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::{Duration, Instant};
use work::{Finder, Hit, Work};

/// Random poses of the second of two bodies.
const POSES: usize = 10;

fn all_pairs(c: &mut Criterion) {
    let mut works = vec![
        Work::course("two bodies 70K", 70_000, POSES),
        Work::course("two bodies 500K", 500_000, POSES),
        Work::course("two bodies 3M", 3_000_000, 3),
        Work::sheet("sheet 92K", 92_000),
        Work::crowd("500 bodies 800K", 500),
        Work::voxels("flush contact 5K", 5000),
    ];
    works.extend(Work::dragons("two dragons 871K", POSES));
    works.extend(Work::cloth_ball("cloth-ball 92K"));
    for work in &works {
        let truth = truth(work);
        assert!(truth.iter().all(|hits| !hits.is_empty()), "{}", work.name);
        let mut finders = vec![
            ("pfront", ours::all(work)),
            ("parry", parry::all(work, parry::own)),
            ("parry tree + fast test", parry::all(work, parry::fast)),
        ];
        if work.meshes.len() == 2 {
            finders.push(("parry posed tree + fast test", parry::posed(work, parry::fast)));
        }
        let mut group = group(c, &work.name);
        for (name, mut finder) in finders {
            judge(work, name, finder.as_mut(), &truth);
            time(&mut group, work, name, finder.as_mut());
        }
    }
}

fn any_pair(c: &mut Criterion) {
    let works = [
        (1, Work::course("first hit of two bodies 70K", 70_000, POSES)),
        (0, Work::near_miss("no hit of two bodies 70K", 70_000, POSES)),
    ];
    for (count, work) in &works {
        assert!(truth(work).iter().all(|hits| hits.len().min(1) == *count), "{}", work.name);
        let mut finders = vec![
            ("pfront", ours::first(work)),
            ("parry", parry::first(work)),
            ("parry posed tree + fast test", parry::first_posed(work, parry::fast)),
        ];
        if *count == 0 {
            finders.push(("parry tree + fast test", parry::all(work, parry::fast)));
        }
        let mut group = group(c, &work.name);
        for (name, mut finder) in finders {
            let right = (0..work.frames()).filter(|&frame| {
                let hits = found(work, finder.as_mut(), frame);
                hits.len() == *count && work.exact(frame, hits.clone()) == hits
            });
            let right = right.count();
            eprintln!("{}: {name} is right in {right} of {} frames", work.name, work.frames());
            assert!(right == work.frames() || name != "pfront");
            time(&mut group, work, name, finder.as_mut());
        }
    }
}

/// The pairs that pfront finds in each frame, checked against parry's candidates that pass an exact test.
fn truth(work: &Work) -> Vec<Vec<Hit>> {
    let mut ours = ours::all(work);
    let mut candidates = parry::all(work, |_, _| true);
    let frame = |frame| {
        let ours = found(work, ours.as_mut(), frame);
        let candidates = found(work, candidates.as_mut(), frame);
        assert!(!candidates.is_empty(), "{}, frame {frame}", work.name);
        assert!(ours == work.exact(frame, candidates), "{}, frame {frame}", work.name);
        ours
    };
    (0..work.frames()).map(frame).collect()
}

/// Says how many hits are missed and invented.
fn judge(work: &Work, name: &str, finder: &mut dyn Finder, truth: &[Vec<Hit>]) {
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
fn found(work: &Work, finder: &mut dyn Finder, frame: usize) -> Vec<Hit> {
    let mut hits = Vec::new();
    finder.place(frame);
    finder.find(frame, &mut hits);
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

/// Times all frames, and reports one; of two bodies also without placing them. Each frame's least time of all rounds is told
/// too, as their median, sum and largest.
fn time(group: &mut Group<'_>, work: &Work, name: &str, finder: &mut dyn Finder) {
    let mut hits = Vec::new();
    let rows = [(name.to_owned(), true), (format!("{name}, query alone"), false)];
    for (row, whole) in rows.into_iter().filter(|&(_, whole)| whole || work.meshes.len() == 2) {
        let mut least = vec![Duration::MAX; work.frames()];
        group.bench_function(&row, |bench| {
            bench.iter_custom(|times| {
                let mut spent = Duration::ZERO;
                for frame in (0..times).flat_map(|_| 0..work.frames()) {
                    hits.clear();
                    let start = Instant::now();
                    finder.place(frame);
                    let placed = Instant::now();
                    finder.find(frame, &mut hits);
                    black_box(&hits);
                    let time = if whole { start } else { placed }.elapsed();
                    least[frame] = least[frame].min(time);
                    spent += time;
                }
                spent / work.frames() as u32
            });
        });
        least.sort_unstable();
        let (median, worst) = (least[least.len() / 2], least[least.len() - 1]);
        let sum = least.iter().sum::<Duration>();
        eprintln!("{}: {row}: median {median:.1?}, sum {sum:.1?}, worst {worst:.1?}", work.name);
    }
}

criterion_group!(benches, all_pairs, any_pair);
criterion_main!(benches);
