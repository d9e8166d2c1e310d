//! Questions about the models of a frame.

use crate::model::Stamp;
use crate::{Accuracy, Adjacency, Error, Model, Pose, core};
use pfront_core::bvtt::Query;
use pfront_core::front::estimate;

/// What a mesh that hardly meets itself costs for each triangle, in box tests: its neighbours.
const PER_TRIANGLE: f64 = 40.0;
/// Nanoseconds per triangle that the first one-ring certificates of a model take.
const CERTIFY: f64 = 80.0;
/// No more pairs of triangles than this are small change.
const SMALL: usize = 256;

/// A question about models, before it is settled who answers and how exactly.
pub(crate) trait Question {
    /// What the CPU walks. Fits the BVHs to the positions, if that has not been done.
    fn query(&self, accuracy: Accuracy) -> impl Query + Sync;

    /// Whether to think about who answers would take longer than the answer.
    fn is_small(&self) -> bool;

    /// What it may cost in box tests, before anything is known.
    fn guess(&self) -> Option<f64>;

    /// How large it is, to compare it with others of its kind, if that takes little time to know.
    fn size(&self) -> Option<f64>;

    /// What the CPU has to make before it can be asked for the first time, in nanoseconds.
    fn unmade(&self) -> f64;

    /// What an answer is about: the same one is true of whatever is equal.
    fn subject(&self) -> Subject;

    /// What has to be true of an answer.
    fn accuracy(&self) -> Accuracy;

    #[cfg(feature = "gpu")]
    /// What a GPU is asked.
    fn on_gpu(&self) -> OnGpu<'_>;
}

/// What a question is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Subject {
    pub(crate) models: [Stamp; 2],
    /// None within one mesh.
    pub(crate) a_from_b: Option<Pose>,
    pub(crate) accuracy: Accuracy,
    pub(crate) adjacency: Adjacency,
}

#[cfg(feature = "gpu")]
#[derive(Clone, Copy)]
pub(crate) enum OnGpu<'m> {
    Pair([&'m Model; 2], &'m Pose),
    Within(&'m Model, Adjacency),
}

/// Whether two models meet.
pub(crate) struct OfTwo<'m> {
    models: [&'m Model; 2],
    a_from_b: Pose,
    query: core::bvtt::PairQuery<'m>,
    accuracy: Accuracy,
}

impl<'m> OfTwo<'m> {
    pub(crate) fn new(
        models: [&'m Model; 2],
        a_from_b: &Pose,
        accuracy: Accuracy,
    ) -> Result<Self, Error> {
        let [a, b] = models.map(Model::bvh);
        let query = core::bvtt::PairQuery::new(a, b, *a_from_b)?;
        Ok(Self { models, a_from_b: *a_from_b, query, accuracy })
    }
}

impl Question for OfTwo<'_> {
    fn query(&self, accuracy: Accuracy) -> impl Query + Sync {
        self.query.with_accuracy(accuracy)
    }

    fn is_small(&self) -> bool {
        let [a, b] = self.models.map(|model| model.mesh().triangles().len());
        a.saturating_mul(b) <= SMALL || self.query.root().is_none()
    }

    /// `None`: the work depends on how the models lie.
    fn guess(&self) -> Option<f64> {
        None
    }

    fn size(&self) -> Option<f64> {
        // Boxes shrink and grow as bodies turn, which costs nothing: that is half believed.
        self.query.root().map(|root| estimate(&self.query, root).sqrt())
    }

    fn unmade(&self) -> f64 {
        0.0
    }

    fn subject(&self) -> Subject {
        Subject {
            models: self.models.map(Model::stamp),
            a_from_b: Some(self.a_from_b),
            accuracy: self.accuracy,
            adjacency: Adjacency::default(),
        }
    }

    fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(&self) -> OnGpu<'_> {
        OnGpu::Pair(self.models, &self.a_from_b)
    }
}

/// Whether a model meets itself.
pub(crate) struct OfOne<'m> {
    pub(crate) model: &'m Model,
    pub(crate) adjacency: Adjacency,
    pub(crate) accuracy: Accuracy,
}

impl Question for OfOne<'_> {
    fn query(&self, accuracy: Accuracy) -> impl Query + Sync {
        core::bvtt::SelfQuery::new(self.model.bvh())
            .with_accuracy(accuracy)
            .with_adjacency(self.adjacency)
            .with_certificates(self.model.certificates())
    }

    fn is_small(&self) -> bool {
        let n = self.model.mesh().triangles().len();
        n.saturating_mul(n) <= SMALL
    }

    fn guess(&self) -> Option<f64> {
        Some(PER_TRIANGLE * self.model.mesh().triangles().len() as f64)
    }

    fn size(&self) -> Option<f64> {
        None
    }

    fn unmade(&self) -> f64 {
        if self.model.has_certificates() {
            0.0
        } else {
            CERTIFY * self.model.mesh().triangles().len() as f64
        }
    }

    fn subject(&self) -> Subject {
        Subject {
            models: [self.model.stamp(); 2],
            a_from_b: None,
            accuracy: self.accuracy,
            adjacency: self.adjacency,
        }
    }

    fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(&self) -> OnGpu<'_> {
        OnGpu::Within(self.model, self.adjacency)
    }
}
