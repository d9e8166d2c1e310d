//! Settings at their extremes, on scenes at rest: g and α, and capacities one below need.

use super::StabilityError;
use super::plain::Evidence;
use super::play::{Divider, Method, one_core};
use super::rows::Finding;
use super::scene::{Scene, Shown, Watch};
use pfront::TrianglePair;
use pfront::core::bvtt::Query;
use pfront::threads::{Schedule, Settings, Traversal};
use std::cmp::Ordering;

/// The most by which g and α may change the work.
const MOST_CHANGE: f64 = 0.15;

/// How much all work changes, that for the front included, when g is halved or doubled. A factor on α
/// cancels out in every share α·V/Σα·V.
pub(super) fn work(
    scene: &mut Scene,
    workers: &[usize],
    tick: &mut dyn FnMut(),
) -> Result<Vec<Finding>, StabilityError> {
    let sweeps = workers.iter().flat_map(|&p| [Sweep::of_ours(p), Sweep::of_plain(p)]).collect();
    let mut sweeps = Sweeps { sweeps, tick };
    scene.play(&mut sweeps)?;
    Ok(sweeps.sweeps.iter().filter_map(|sweep| sweep.worst(scene.name)).collect())
}

/// A method with its usual settings, and with others.
struct Sweep {
    method: Method,
    workers: usize,
    usual: Divider,
    others: Vec<(String, Divider)>,
}

impl Sweep {
    fn of_ours(workers: usize) -> Self {
        let usual = Settings { schedule: Schedule::Static, ..Settings::default() };
        let other =
            |name: &str, factor| (name.to_owned(), Settings { g: factor * usual.g, ..usual });
        let others = [other("g/2", 0.5), other("2g", 2.0)];
        let divider = |s| Divider::Ours(Box::new(Traversal::new(workers).with_settings(s)));
        let others = others.into_iter().map(|(name, settings)| (name, divider(settings))).collect();
        Self { method: Method::Ours, workers, usual: divider(usual), others }
    }

    fn of_plain(workers: usize) -> Self {
        let plain = |g| Divider::plain(workers, g, Evidence::LastFrame);
        let others = vec![("g/2".to_owned(), plain(1.0)), ("2g".to_owned(), plain(4.0))];
        Self { method: Method::Printed, workers, usual: plain(2.0), others }
    }

    /// The setting that changes the work of the last frame most.
    fn worst(&self, scene: &str) -> Option<Finding> {
        let work = |divider: &Divider| divider.report().work().cost();
        let usual = work(&self.usual);
        let found = self.others.iter().map(|(name, other)| {
            let change = (work(other) / usual - 1.0).abs();
            let place = format!("{scene}, {name}");
            Finding::new("change of work", self.method, self.workers, change, MOST_CHANGE, place)
        });
        Finding::worst(found)
    }
}

struct Sweeps<'t> {
    sweeps: Vec<Sweep>,
    tick: &'t mut dyn FnMut(),
}

impl Watch for Sweeps<'_> {
    fn frame<Q: Query + Sync>(&mut self, _: &Shown<'_>, query: &Q) {
        let mut pairs = Vec::new();
        for sweep in &mut self.sweeps {
            sweep.usual.all(query, &mut pairs);
            sweep.others.iter_mut().for_each(|(_, other)| other.all(query, &mut pairs));
        }
        (self.tick)();
    }
}

/// How many pairs are lost or invented where a front has room for one node fewer than it wants, for each p,
/// and, which is the same for each, where the output has room for one pair fewer than there are, or for one.
pub(super) fn capacity(
    scene: &mut Scene,
    workers: &[usize],
    tick: &mut dyn FnMut(),
) -> Result<Vec<Finding>, StabilityError> {
    let mut tight = Tight { workers, wrong: vec![0; workers.len()], tick };
    scene.play(&mut tight)?;
    let found = workers.iter().zip(&tight.wrong).map(|(&p, &wrong)| {
        let place = scene.name.to_owned();
        Finding::new("wrong pairs", Method::Ours, p, wrong as f64, 0.0, place)
    });
    Ok(found.collect())
}

struct Tight<'t> {
    workers: &'t [usize],
    /// Pairs for each p.
    wrong: Vec<usize>,
    tick: &'t mut dyn FnMut(),
}

impl Watch for Tight<'_> {
    fn frame<Q: Query + Sync>(&mut self, _: &Shown<'_>, query: &Q) {
        let (expected, _) = one_core(query);
        let capacities = [expected.len().saturating_sub(1).max(1), 1];
        let by_page = capacities.map(|capacity| differences(&pages(query, capacity), &expected));
        for (&p, wrong) in self.workers.iter().zip(&mut self.wrong) {
            let (mut roomy, mut pairs) = (Divider::ours(p, |_| ()), Vec::new());
            roomy.all(query, &mut pairs);
            *wrong += by_page.iter().sum::<usize>() + differences(&pairs, &expected);
            let max_nodes = roomy.report().nodes.saturating_sub(1);
            let mut tight = Divider::ours(p, |settings| settings.max_nodes = max_nodes);
            for _ in 0..2 {
                tight.all(query, &mut pairs);
                *wrong += differences(&pairs, &expected);
            }
        }
        (self.tick)();
    }
}

/// All pages of so many pairs, sorted.
fn pages(query: &impl Query, capacity: usize) -> Vec<TrianglePair> {
    let (mut page, mut all) = (vec![TrianglePair::default(); capacity], Vec::new());
    let mut cursor = query.start();
    while !cursor.is_done() {
        let n = query.page(&mut cursor, &mut page);
        all.extend_from_slice(&page[..n]);
    }
    all.sort_unstable();
    all
}

/// In how many pairs two sorted lists differ; one that is there twice differs too.
fn differences(found: &[TrianglePair], expected: &[TrianglePair]) -> usize {
    let [mut i, mut j, mut count] = [0; 3];
    while i < found.len() && j < expected.len() {
        match found[i].cmp(&expected[j]) {
            Ordering::Equal => (i, j) = (i + 1, j + 1),
            Ordering::Less => (i, count) = (i + 1, count + 1),
            Ordering::Greater => (j, count) = (j + 1, count + 1),
        }
    }
    count + found.len() - i + expected.len() - j
}
