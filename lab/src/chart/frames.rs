//! Whole queries in every configuration: accuracy × who computes × leaf size.
//!
//! A frame is one site of a set: all pairs of two bodies, or of one with itself. Each is asked twice and the
//! second time counts, so a front has the costs of a frame like it, as in coherent motion. Truth is by the
//! oracle, over all pairs whose boxes overlap; of these, wrong answers are counted.

use super::{ChartError, Look, Point};
use crate::judge::Tally;
use crate::median;
use crate::suite::{Body, Candidate, Contacts, Site};
#[cfg(feature = "gpu")]
use pfront::gpu::{Gpu, GpuModel, GpuPairQuery, GpuSelfQuery};
use pfront::threads::{Schedule, Settings, Traversal};
use pfront::{Accuracy, BuildOptions, Executor, Model, PairQuery, SelfQuery, TrianglePair};
use pfront_testkit::oracle::{intersect, self_hit};
use rayon::prelude::*;
use std::num::NonZero;
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::Instant;

const ACCURACIES: [Accuracy; 3] = [Accuracy::Exact, Accuracy::Conservative, Accuracy::Fast];
const LEAF_SIZES: [u32; 3] = [1, 4, 8];

/// What there is to measure on.
#[derive(Clone, Debug)]
pub struct Machine {
    /// CPU threads to use.
    pub threads: usize,
    /// A GPU, if there is one.
    #[cfg(feature = "gpu")]
    pub gpu: Option<Gpu>,
}

impl Machine {
    /// All threads of this one, and its best GPU if it has one.
    #[must_use]
    pub fn this() -> Self {
        Self {
            threads: available_parallelism().map_or(1, NonZero::get),
            #[cfg(feature = "gpu")]
            gpu: Gpu::new().ok(),
        }
    }
}

/// Who computes.
enum Asker {
    Cpu(Box<(PairQuery, SelfQuery)>),
    #[cfg(feature = "gpu")]
    Gpu(Box<(GpuPairQuery, GpuSelfQuery)>),
}

/// One configuration.
struct Lane {
    name: String,
    look: Look,
    leaf_size: usize,
    asker: Asker,
    /// Of each round, milliseconds a frame.
    times: Vec<f64>,
}

/// A site with its bodies built anew, and on the device.
struct Frame {
    site: Site,
    #[cfg(feature = "gpu")]
    on_device: Option<(GpuModel, GpuModel)>,
}

/// Measures all configurations on the first `frames` sites of some contacts.
///
/// # Errors
/// [`ChartError`] if a query fails.
pub fn measure(
    contacts: &Contacts,
    machine: &Machine,
    frames: usize,
    rounds: usize,
) -> Result<Vec<Point>, ChartError> {
    let sites = &contacts.sites()[..contacts.sites().len().min(frames)];
    let truths: Vec<_> = sites.iter().map(truth).collect();
    let frame = |site: &Site, leaf_size| Frame::new(site, leaf_size, machine);
    let mut layouts: Vec<Vec<Frame>> = Vec::new();
    for leaf_size in LEAF_SIZES {
        let frames = sites.iter().map(|site| frame(site, leaf_size));
        layouts.push(frames.collect::<Result<_, _>>()?);
    }
    let mut lanes = lanes(machine)?;
    let mut tallies = vec![Tally::default(); lanes.len()];
    for round in 0..rounds.max(1) {
        let mut times = vec![0.0; lanes.len()];
        for (i, truth) in truths.iter().enumerate() {
            for (k, lane) in lanes.iter_mut().enumerate() {
                let frame = &layouts[lane.leaf_size][i];
                lane.asker.ask(frame)?;
                let clock = Instant::now();
                let found = lane.asker.ask(frame)?;
                times[k] += 1e3 * clock.elapsed().as_secs_f64() / sites.len() as f64;
                if round == 0 {
                    tallies[k].add(&truth.tally(found));
                }
            }
        }
        lanes.iter_mut().zip(times).for_each(|(lane, time)| lane.times.push(time));
    }
    let point = |(mut lane, tally): (Lane, Tally)| Point {
        set: contacts.name().to_owned(),
        is_real: true,
        configuration: lane.name,
        look: lane.look,
        time: median(&mut lane.times),
        tally,
    };
    Ok(lanes.into_iter().zip(tallies).map(point).collect())
}

/// The pairs of a site that meet, of so many whose boxes overlap.
struct Truth {
    candidates: u64,
    pairs: Vec<TrianglePair>,
}

fn truth(site: &Site) -> Truth {
    let candidates = site.candidates();
    let meets = |Candidate { indices, triangles: [a, b] }: &Candidate| match site {
        Site::Pair { .. } => intersect(a, b),
        Site::Within(body) => {
            let [ta, tb] = indices.map(|t| body.mesh().triangles()[t as usize]);
            self_hit(ta, tb, body.mesh().positions())
        }
    };
    let hits = candidates.par_iter().filter(|candidate| meets(candidate));
    let pairs = hits.map(|c| TrianglePair { a: c.indices[0], b: c.indices[1] }).collect();
    Truth { candidates: candidates.len() as u64, pairs }
}

impl Truth {
    /// Of pairs found, in order as the true ones are.
    fn tally(&self, found: &[TrianglePair]) -> Tally {
        let not_in = |these: &[TrianglePair], others: &[TrianglePair]| {
            these.iter().filter(|pair| others.binary_search(pair).is_err()).count() as u64
        };
        Tally {
            pairs: self.candidates,
            hits: self.pairs.len() as u64,
            missed: not_in(&self.pairs, found),
            false_hits: not_in(found, &self.pairs),
        }
    }
}

fn lanes(machine: &Machine) -> Result<Vec<Lane>, ChartError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(machine.threads).build()?;
    let pool = Arc::new(pool);
    let p = machine.threads;
    let schedules = [
        ("1 thread".to_owned(), None),
        (format!("{p} threads, static"), Some(Schedule::Static)),
        (format!("{p} threads, stealing"), Some(Schedule::Stealing)),
        (format!("{p} threads, hybrid"), Some(Schedule::Hybrid)),
    ];
    let mut lanes = Vec::new();
    for (layout, leaf_size) in LEAF_SIZES.into_iter().enumerate() {
        let lane = |name: String, shape, colour: usize, asker| Lane {
            name: format!("{name}, leaves of {leaf_size}"),
            look: Look { name, shape, colour, tag: leaf_size.to_string(), line: colour },
            leaf_size: layout,
            asker,
            times: Vec::new(),
        };
        for (shape, (who, schedule)) in schedules.iter().enumerate() {
            for (colour, accuracy) in ACCURACIES.into_iter().enumerate() {
                let mut pair = PairQuery::new().with_accuracy(accuracy);
                let mut within = SelfQuery::new().with_accuracy(accuracy);
                if let Some(schedule) = *schedule {
                    let settings = Settings { schedule, ..Settings::default() };
                    let traversal = Traversal::with_pool(pool.clone()).with_settings(settings);
                    let executor = Executor::from(traversal);
                    pair = pair.on(&executor);
                    within = within.on(&executor);
                }
                let asker = Asker::Cpu(Box::new((pair, within)));
                lanes.push(lane(format!("{accuracy:?}, {who}"), shape, colour, asker));
            }
        }
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &machine.gpu {
            let queries = (GpuPairQuery::new(gpu)?, GpuSelfQuery::new(gpu)?);
            let asker = Asker::Gpu(Box::new(queries));
            let adapter = gpu.device().adapter_info().name;
            let adapter = adapter.split(" (").next().unwrap_or_default();
            lanes.push(lane(format!("Exact, {adapter}"), schedules.len(), 0, asker));
        }
    }
    Ok(lanes)
}

impl Frame {
    #[cfg_attr(not(feature = "gpu"), expect(unused_variables, reason = "only a GPU needs it"))]
    fn new(site: &Site, leaf_size: u32, machine: &Machine) -> Result<Self, ChartError> {
        let built = |body: &Body| {
            let (mesh, options) =
                (body.mesh(), BuildOptions { leaf_size, ..BuildOptions::default() });
            let (positions, triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
            Model::with_options(positions, triangles, options).map(Arc::new)
        };
        let site = match site {
            Site::Pair { a, b, a_from_b } => {
                let same = Arc::ptr_eq(a, b);
                let a = built(a)?;
                let b = if same { a.clone() } else { built(b)? };
                Site::Pair { a, b, a_from_b: *a_from_b }
            }
            Site::Within(body) => Site::Within(built(body)?),
        };
        #[cfg(feature = "gpu")]
        let on_device = match (&machine.gpu, &site) {
            (None, _) => None,
            (Some(gpu), Site::Pair { a, b, .. }) => {
                Some((GpuModel::new(gpu, a.bvh())?, GpuModel::new(gpu, b.bvh())?))
            }
            (Some(gpu), Site::Within(body)) => {
                Some((GpuModel::new(gpu, body.bvh())?, GpuModel::new(gpu, body.bvh())?))
            }
        };
        Ok(Self {
            site,
            #[cfg(feature = "gpu")]
            on_device,
        })
    }
}

impl Asker {
    fn ask(&mut self, frame: &Frame) -> Result<&[TrianglePair], ChartError> {
        match self {
            Self::Cpu(queries) => match &frame.site {
                Site::Pair { a, b, a_from_b } => {
                    queries.0.forget();
                    Ok(queries.0.all(a, b, a_from_b)?)
                }
                Site::Within(body) => {
                    queries.1.forget();
                    Ok(queries.1.all(body)?)
                }
            },
            #[cfg(feature = "gpu")]
            Self::Gpu(queries) => match (&frame.site, &frame.on_device) {
                (Site::Pair { a_from_b, .. }, Some((a, b))) => Ok(queries.0.all(a, b, a_from_b)?),
                (Site::Within(_), Some((body, _))) => Ok(queries.1.all(body)?),
                (_, None) => Ok(&[]),
            },
        }
    }
}
