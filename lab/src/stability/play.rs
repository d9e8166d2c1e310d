//! Playing a scene with many numbers of workers and all methods, each frame checked against one core.

use super::limit::{Bound, Census, Hardness, THIN};
use super::plain::Plain;
use super::scene::{Actors, Scene, Step};
use anyhow::Result;
use pfront::pfront_core::bvtt::{PairBvtt, Query, SelfBvtt};
use pfront::threads::{Pool, Report, Schedule, Settings, Traversal};
use pfront::{Model, Pose, TrianglePair};
use std::ops::ControlFlow;

/// The most triangle tests of a frame that the oracle looks at: as many as it does in about a second.
const ORACLE: u64 = 150_000;

/// The g of the matrix.
const GRAIN: f64 = 16.0;

/// The way in which work is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// [`Traversal`] with a static schedule and g = 16: nothing but the front and its dealing makes up the
    /// balance.
    Ours,
    /// [`Plain`] with the paper's g = 2.
    Printed,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Ours, Self::Printed];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours => "pfront, g = 16",
            Self::Printed => "eqs. 1-3, g = 2",
        }
    }
}

/// A method at work.
enum Divider {
    Ours(Box<Traversal>),
    Plain(Box<Plain>),
}

impl Divider {
    fn new(method: Method, workers: usize) -> Self {
        let settings = Settings { schedule: Schedule::Static, g: GRAIN, ..Settings::default() };
        match method {
            Method::Ours => {
                Self::Ours(Box::new(Traversal::new(&Pool::new(workers).with_settings(settings))))
            }
            Method::Printed => Self::Plain(Box::new(Plain::new(workers, 2.0))),
        }
    }

    fn all<Q: Query + Sync>(&mut self, query: &Q, out: &mut Vec<TrianglePair>) {
        match self {
            // Without memory the list is empty, and counts as wrong.
            Self::Ours(traversal) => _ = traversal.all(std::slice::from_ref(query), out),
            Self::Plain(plain) => plain.all(query, out),
        }
    }

    fn report(&self) -> &Report {
        match self {
            Self::Ours(traversal) => &traversal.report,
            Self::Plain(plain) => plain.report(),
        }
    }
}

/// The result of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The name of what happened in it.
    pub what: &'static str,
    /// Whether the pairs were those that one core finds, and the oracle where it looked.
    pub right: bool,
    /// Whether all that was counted and predicted is a number.
    pub finite: bool,
    /// Busiest worker over mean.
    pub imbalance: f64,
    /// The limit of the imbalance.
    pub limit: f64,
    /// Whether the limit is wider than usual, as workers had so little to do, see [`Hardness`].
    pub widened: bool,
    /// Nodes of the front; 1 where one worker traversed from the root.
    pub nodes: usize,
}

impl Frame {
    /// Whether the answer is right, all figures are numbers, and the balance is within its limit.
    pub fn holds(&self) -> bool {
        self.right && self.finite && self.imbalance <= self.limit
    }

    fn new(
        what: &'static str,
        bound: Bound,
        report: &Report,
        census: &Census,
        right: bool,
    ) -> Self {
        let costs = report.shares.iter().map(|share| share.work.cost());
        let mut predicted = report.shares.iter().map(|share| share.predicted);
        let (total, p) = (costs.sum::<f64>(), report.shares.len() as f64);
        let relative = |w: f64| if total > 0.0 { w * p / total } else { 0.0 };
        let (dominance, rise) = (relative(census.w_max), relative(census.w_rise));
        let hardness = Hardness { dominance, rise, thin: total / p < THIN };
        let (imbalance, limit) = (report.imbalance(), bound.limit(hardness));
        Self {
            what,
            right,
            finite: imbalance.is_finite() && predicted.all(f64::is_finite),
            imbalance,
            limit,
            widened: limit > bound.usual(hardness),
            nodes: report.nodes.max(1),
        }
    }
}

/// The frames of one scene with one method and number of workers.
#[derive(Clone, Debug)]
pub struct Series {
    /// The scene.
    pub scene: &'static str,
    /// The method.
    pub method: Method,
    /// p.
    pub workers: usize,
    /// Each frame.
    pub frames: Vec<Frame>,
}

/// Plays a scene with each of `workers` and every method; calls `tick` after each frame. Returns a series for each of both,
/// and how many frames the oracle looked at: the first of each kind, where it is small.
///
/// # Errors
/// If a pose or a shape is refused, which those of the matrix are not.
pub fn play(
    scene: &mut Scene,
    workers: &[usize],
    tick: &mut dyn FnMut(),
) -> Result<(Vec<Series>, usize)> {
    let all = workers.iter().flat_map(|&p| Method::ALL.map(move |method| (p, method)));
    let (mut series, mut dividers) = (Vec::new(), Vec::new());
    for (workers, method) in all {
        series.push(Series { scene: scene.name, method, workers, frames: Vec::new() });
        dividers.push(Divider::new(method, workers));
    }
    let mut player =
        Player { series, dividers, by_oracle: 0, census: Census::default(), last: "", tick };
    player.play(scene)?;
    Ok((player.series, player.by_oracle))
}

struct Player<'t> {
    series: Vec<Series>,
    dividers: Vec<Divider>,
    by_oracle: usize,
    census: Census,
    /// The name of what happened in the last frame.
    last: &'static str,
    tick: &'t mut dyn FnMut(),
}

impl Player<'_> {
    /// Judges every frame of a scene.
    ///
    /// # Errors
    /// If a pose or a shape is refused, which those of the matrix are not.
    fn play(&mut self, scene: &mut Scene) -> Result<()> {
        for (index, step) in scene.steps.iter().enumerate() {
            match &mut scene.actors {
                Actors::Two(models) => {
                    let [a, b] = &**models;
                    let query = PairBvtt::new(a.bvh(), b.bvh(), step.a_from_b)?;
                    self.frame(step, &query, || pairs(a, b, &step.a_from_b));
                }
                Actors::Sheet(model, sheet, first) => {
                    let mut positions = Vec::new();
                    sheet.positions(*first + index, &mut positions);
                    model.set_positions(&positions)?;
                    self.frame(step, &SelfBvtt::new(model.bvh()), || self_pairs(model));
                }
            }
        }
        Ok(())
    }

    /// Judges a frame; `oracle` finds the true pairs by brute force, sorted.
    fn frame<Q: Query + Sync>(
        &mut self,
        step: &Step,
        query: &Q,
        oracle: impl Fn() -> Vec<TrianglePair>,
    ) {
        let (expected, triangle_tests) = one_core(query);
        let is_new = std::mem::replace(&mut self.last, step.what) != step.what;
        let mut agreed = true;
        if is_new && triangle_tests <= ORACLE {
            agreed = expected == oracle();
            self.by_oracle += 1;
        }
        self.census.take(query);
        let mut pairs = Vec::new();
        for (series, divider) in self.series.iter_mut().zip(&mut self.dividers) {
            divider.all(query, &mut pairs);
            let right = agreed && pairs == expected;
            let frame = Frame::new(step.what, step.bound, divider.report(), &self.census, right);
            series.frames.push(frame);
        }
        (self.tick)();
    }
}

fn pairs(a: &Model, b: &Model, a_from_b: &Pose) -> Vec<TrianglePair> {
    let (a, b) = (a.mesh(), b.mesh());
    let posed: Vec<_> = b.shadow().iter().map(|&p| a_from_b.apply(p)).collect();
    sorted(pfront_testkit::oracle::pairs(a.shadow(), a.triangles(), &posed, b.triangles()))
}

fn self_pairs(model: &Model) -> Vec<TrianglePair> {
    let mesh = model.mesh();
    sorted(pfront_testkit::oracle::self_pairs(mesh.shadow(), mesh.triangles()))
}

fn sorted(pairs: Vec<(u32, u32)>) -> Vec<TrianglePair> {
    pairs.into_iter().map(|(a, b)| TrianglePair { a, b }).collect()
}

/// The pairs that one core finds, sorted, and the number of its triangle tests.
fn one_core(query: &impl Query) -> (Vec<TrianglePair>, u64) {
    let (mut pairs, mut cursor) = (Vec::new(), query.start());
    // Never broken off.
    let _ = query.visit(&mut cursor, |pair| {
        pairs.push(pair);
        ControlFlow::Continue(())
    });
    pairs.sort_unstable();
    (pairs, cursor.work.triangle_tests)
}
