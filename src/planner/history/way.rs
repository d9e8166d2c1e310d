//! Offers of ways, decisions among them, and their outcome.

/// A way to answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    Alone,
    Threads(u32),
    Gpu,
}

/// The ways without their numbers, as indices.
pub(crate) const WAYS: usize = 3;
pub(super) const ALONE: usize = 0;
pub(super) const THREADS: usize = 1;
pub(super) const GPU: usize = 2;

impl Way {
    pub(super) fn family(self) -> usize {
        match self {
            Self::Alone => ALONE,
            Self::Threads(_) => THREADS,
            Self::Gpu => GPU,
        }
    }
}

/// The ways that there are for a question.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Offer {
    /// The most threads; 1 if there are no others.
    pub(crate) threads: u32,
    /// What has to be brought to the GPU first, in nanoseconds; `None` if it cannot be asked.
    pub(crate) gpu: Option<f64>,
    /// What the GPU has to do first in each frame, in nanoseconds.
    pub(crate) gpu_upkeep: f64,
    /// What it is.
    pub(crate) known: Known,
    /// Whether vertices have been moved for it.
    pub(crate) moves: bool,
    /// The number of queries that it consists of.
    pub(crate) queries: usize,
    /// What has to be done first on the CPU in each frame, in nanoseconds, unless the GPU does it.
    pub(crate) upkeep: f64,
    /// What has to be made there once.
    pub(crate) unmade: f64,
}

/// A decision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    pub(crate) way: Way,
    /// The calling thread goes on up to this cost, and then looks again: see [`super::History::look`].
    pub(crate) alone_until: Option<f64>,
    /// Expected box tests.
    pub(crate) expected: Option<f64>,
    /// `gpu_upkeep` and `known` of the offer.
    pub(crate) gpu_upkeep: f64,
    pub(crate) known: Known,
    /// Predicted nanoseconds of each way.
    pub(crate) times: [Option<f64>; WAYS],
    /// Whether the way is the one with the least of them.
    pub(crate) is_best: bool,
}

impl Choice {
    /// Alone, to the end.
    pub(super) fn alone(offer: &Offer) -> Self {
        Self {
            way: Way::Alone,
            alone_until: None,
            expected: None,
            gpu_upkeep: offer.gpu_upkeep,
            known: offer.known,
            times: [None; WAYS],
            is_best: true,
        }
    }

    /// The cost up to which the calling thread goes on, if it is to at all.
    pub(crate) fn alone_to(&self) -> Option<f64> {
        let end = (self.way == Way::Alone).then_some(f64::INFINITY);
        self.alone_until.or(end)
    }

    /// What it will take, in nanoseconds, if that is known.
    pub(crate) fn time(&self) -> Option<f64> {
        self.times[self.way.family()]
    }
}

/// The knowledge of a question before work begins.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Known {
    /// Whether the first pair will do.
    pub(crate) until_first: bool,
    /// What it may cost in box tests to its end, if nothing else is known.
    pub(crate) guess: Option<f64>,
    /// How large it is, in a unit of its own, to compare it with the last one.
    pub(crate) size: Option<f64>,
}

impl Known {
    /// What it may cost, if there was none like it.
    pub(super) fn expected(&self) -> Option<f64> {
        // However much there is, the first pair may be near.
        self.guess.filter(|_| !self.until_first)
    }
}

/// How the calling thread begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Begin {
    /// The cost at which it looks where it is, and decides.
    pub(crate) until: f64,
    /// Whether it needs to know how long that took.
    pub(crate) is_timed: bool,
}

/// How far a question has come that was begun on the calling thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    /// What it has cost up to now, in box tests.
    pub(crate) spent: f64,
    /// What the rest may cost, by its boxes.
    pub(crate) rest: f64,
    /// What it has taken up to now, if that was timed.
    pub(crate) nanoseconds: Option<f64>,
}

/// What a frame took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    pub(crate) nanoseconds: f64,
    /// The part that was not for the question itself: a refit before it, and work begun in vain.
    pub(crate) beside: f64,
    /// `gpu_upkeep` of the offer.
    pub(crate) gpu_upkeep: f64,
    pub(crate) cost: Option<f64>,
    pub(crate) leaf_pairs: Option<u32>,
    /// `known` of the offer.
    pub(crate) known: Known,
    /// The first look at it.
    pub(crate) look: Option<Look>,
    /// Nanoseconds of a box test on the calling thread, if that has begun and was timed.
    pub(crate) pace: Option<f64>,
}
