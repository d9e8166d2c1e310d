//! A scene by a planner.

use super::SceneHit;
#[cfg(feature = "threads")]
use super::crew::Crew;
#[cfg(feature = "gpu")]
use super::device::Device;
use super::frame::{Found, Frame};
#[cfg(feature = "threads")]
use crate::answer::cost;
use crate::answer::{End, Leash, Want, alone};
use crate::planner::{Decider, Offer, Plan, Planner, Way};
use std::ops::ControlFlow;

#[derive(Clone, Debug)]
pub(super) struct Planned {
    decider: Decider,
    #[cfg(feature = "threads")]
    crew: Option<Crew>,
    #[cfg(feature = "gpu")]
    device: Option<Device>,
    /// The most hits of a frame.
    most: u64,
}

/// What an answer says, beside the list.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Given {
    pub(super) count: u64,
    pub(super) first: Option<SceneHit>,
}

/// What one way came to.
struct Outcome {
    given: Found<Given>,
    cost: Option<f64>,
    leaf_pairs: Option<u32>,
    end: End,
}

impl Planned {
    pub(super) fn new(planner: Planner) -> Self {
        Self {
            #[cfg(feature = "threads")]
            crew: None,
            #[cfg(feature = "gpu")]
            device: Device::new(&planner),
            most: 0,
            decider: Decider::new(planner),
        }
    }

    pub(super) fn plan(&self) -> Option<Plan> {
        self.decider.plan()
    }

    pub(super) fn has_conceded(&self) -> bool {
        self.decider.has_conceded()
    }

    pub(super) fn planner(&self) -> &Planner {
        self.decider.planner()
    }

    pub(super) fn start(&mut self) {
        self.decider.start();
    }

    pub(super) fn keep(&mut self) {
        self.decider.keep();
    }

    /// Answers; into `hits`, which are empty, if all are wanted.
    pub(super) fn ask(
        &mut self,
        frame: &Frame<'_>,
        want: Want,
        hits: &mut Vec<SceneHit>,
    ) -> Found<Given> {
        if let Some(cost) = self.decider.brief(want == Want::Any) {
            let brief = self.on_one(frame, want, hits, cost);
            if brief.end == End::Complete {
                self.decider.was_brief(brief.cost.unwrap_or_default());
                return brief.given;
            }
            hits.clear();
        }
        // What it took so far to know which bodies may meet, it takes each way.
        self.decider.set_aside();
        let offer = self.offer(frame);
        let mut choice = self.decider.choose(&offer, want == Want::Any);
        let accuracy = self.decider.accuracy(frame.accuracy);
        let frame = &frame.with_accuracy(accuracy);
        let mut outcome = None;
        if choice.way == Way::Alone || choice.alone_first.is_some() {
            let most = choice.alone_first.unwrap_or(f64::INFINITY);
            let alone = self.on_one(frame, want, hits, most);
            if alone.end == End::Outgrown {
                let cost = alone.cost.unwrap_or_default();
                choice = self.decider.outgrown(&offer, &choice, cost);
                hits.clear();
            } else {
                choice.way = Way::Alone;
                outcome = Some(alone);
            }
        }
        let outcome = outcome.unwrap_or_else(|| self.others(frame, want, hits, &mut choice.way));
        if outcome.end == End::Complete {
            self.decider.end(choice.way, outcome.cost, outcome.leaf_pairs);
        } else {
            self.decider.end_incomplete(choice.way);
        }
        self.most = self.most.max(outcome.given.get().count);
        outcome.given
    }

    /// Answers on the calling thread.
    fn on_one(
        &self,
        frame: &Frame<'_>,
        want: Want,
        hits: &mut Vec<SceneHit>,
        most: f64,
    ) -> Outcome {
        let leash = Leash { cost: most, deadline: self.decider.deadline() };
        let mut given = Given::default();
        let (cost, end) = alone(frame.queries(), leash, |bodies, pair| {
            let hit = SceneHit { bodies, pair };
            given.count += 1;
            match want {
                Want::All => hits.push(hit),
                Want::Count => {}
                Want::Any => {
                    given.first = Some(hit);
                    return ControlFlow::Break(());
                }
            }
            ControlFlow::Continue(())
        });
        hits.chunk_by_mut(|x, y| x.bodies == y.bodies).for_each(<[_]>::sort_unstable);
        Outcome { given: Found::New(given), cost: Some(cost), leaf_pairs: None, end }
    }

    /// Answers on threads or a GPU; says by which way it was done in the end.
    fn others(
        &mut self,
        frame: &Frame<'_>,
        want: Want,
        hits: &mut Vec<SceneHit>,
        way: &mut Way,
    ) -> Outcome {
        #[cfg(feature = "gpu")]
        if let (Way::Gpu, Some(device)) = (*way, &mut self.device) {
            match device.ask(frame.bodies, want, hits) {
                Ok((given, leaf_pairs)) => {
                    let given = Found::All(given);
                    let end = End::Complete;
                    return Outcome { given, cost: None, leaf_pairs: Some(leaf_pairs), end };
                }
                Err(error) => {
                    self.device = None;
                    hits.clear();
                    *way = self.decider.gpu_failed(&error);
                }
            }
        }
        match *way {
            #[cfg(feature = "threads")]
            Way::Threads(workers) => self.on_threads(frame, want, hits, workers),
            _ => self.on_one(frame, want, hits, f64::INFINITY),
        }
    }

    #[cfg(feature = "threads")]
    fn on_threads(
        &mut self,
        frame: &Frame<'_>,
        want: Want,
        hits: &mut Vec<SceneHit>,
        workers: u32,
    ) -> Outcome {
        let planner = self.decider.planner();
        let crew = self.crew.get_or_insert_with(|| Crew::new(planner.traversal(workers)));
        crew.traversal.set_workers(workers as usize);
        crew.traversal.set_deadline(self.decider.deadline());
        let given = match want {
            Want::All => {
                crew.all(frame, hits);
                Given { count: hits.len() as u64, first: hits.first().copied() }
            }
            Want::Count => Given { count: crew.count(frame), first: None },
            Want::Any => {
                let first = crew.any(frame);
                Given { count: u64::from(first.is_some()), first }
            }
        };
        let report = crew.report();
        let end = if report.late { End::Late } else { End::Complete };
        Outcome { given: Found::New(given), cost: Some(cost(report.work())), leaf_pairs: None, end }
    }

    /// Which ways there are.
    fn offer(&self, frame: &Frame<'_>) -> Offer {
        let (gpu, gpu_upkeep) = self.gpu(frame);
        Offer {
            threads: self.decider.planner().threads(self.most),
            gpu,
            gpu_upkeep,
            both: false,
            guess: None,
            moves: false,
            queries: frame.len(),
            upkeep: 0.0,
        }
    }

    /// What has to be brought to the GPU first, and what it has to do in each frame.
    #[cfg(feature = "gpu")]
    fn gpu(&self, frame: &Frame<'_>) -> (Option<f64>, f64) {
        let planner = self.decider.planner();
        match &self.device {
            Some(device) if frame.accuracy == crate::Accuracy::Exact => {
                let upload = planner.upload(device.owed(frame.bodies));
                (upload, device.upkeep(frame.bodies, planner))
            }
            _ => (None, 0.0),
        }
    }

    #[cfg(not(feature = "gpu"))]
    fn gpu(&self, _: &Frame<'_>) -> (Option<f64>, f64) {
        (None, 0.0)
    }
}
