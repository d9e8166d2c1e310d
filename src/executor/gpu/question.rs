//! Subjects as questions for a GPU.

use crate::gpu::{GpuError, GpuModel, GpuQuestion};
use crate::model::Outline;
use crate::subject::Subject;
use crate::{AnyPose, Distance, Error, Model, Pose};
use pfront_core::bvtt::{AnyBvtt, PairBvtt};
use std::borrow::Borrow;

impl<M: Borrow<Model>> Subject<M> {
    /// The models and the pose of two in f32.
    pub(crate) fn pair_in_f32(&self) -> Option<([&Model; 2], Pose)> {
        match self {
            Self::Pair { models, a_from_b: AnyPose::F32(a_from_b), .. } => {
                let models = models.each_ref().map(|model| model.borrow());
                models.iter().all(|model| !model.is_f64()).then_some((models, *a_from_b))
            }
            _ => None,
        }
    }

    /// The tree that decides the pairs that a GPU leaves open: of two of which a model or the pose is in f64, so that it goes by shadows,
    /// and of a question about pairs within a distance.
    pub(crate) fn left_open<'q>(
        &'q self,
        outlines: &'q [Outline; 2],
    ) -> Result<Option<PairBvtt<'q>>, Error> {
        let is_itself = matches!(self, Self::Itself { .. });
        if is_itself || self.pair_in_f32().is_some() && self.distance() == Distance::default() {
            return Ok(None);
        }
        let AnyBvtt::Pair(tree) = self.untraversed(outlines)? else { return Ok(None) };
        Ok(Some(tree.within(self.distance())))
    }

    /// The question for a GPU that has [`Subject::both`] models.
    pub(crate) fn question<'q>(
        &self,
        [a, b]: [&'q GpuModel; 2],
        left_open: Option<&PairBvtt<'_>>,
    ) -> Result<GpuQuestion<'q>, GpuError> {
        let question = match (self, left_open.and_then(PairBvtt::shadows)) {
            (Self::Itself { adjacency, .. }, _) => {
                GpuQuestion::Itself { model: a, adjacency: *adjacency }
            }
            (_, Some(shadows)) => GpuQuestion::shadows(a, b, &shadows),
            (Self::Pair { a_from_b: AnyPose::F32(a_from_b), .. }, None) => {
                GpuQuestion::pair(a, b, a_from_b)
            }
            // One of them is empty.
            (Self::Pair { a_from_b: AnyPose::F64(_), .. }, None) => {
                GpuQuestion::pair(a, b, &Pose::IDENTITY)
            }
        };
        question.within(self.distance())
    }
}
