//! The subjects of questions: two models, or one and itself.

use crate::model::{Outline, Stamp};
use crate::{Adjacency, AnyPose, Error, Model};
use pfront_core::bvtt::{AnyBvtt, SelfBvtt};
use std::borrow::Borrow;

/// A subject of a frame, which borrows its models or shares them.
#[derive(Clone, Debug)]
pub(crate) enum Subject<M> {
    /// Two models, the second in a pose that suits it.
    Pair { models: [M; 2], a_from_b: AnyPose },
    /// A model and itself.
    Within { models: [M; 1], adjacency: Adjacency },
}

/// All that an answer about a subject depends on: of equal keys the same answer is true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Key {
    models: [Stamp; 2],
    /// None within one mesh.
    a_from_b: Option<AnyPose>,
    adjacency: Adjacency,
}

impl Key {
    /// The numbers of the meshes.
    pub(crate) fn meshes(&self) -> [u64; 2] {
        self.models.map(Stamp::mesh)
    }
}

impl<'m> Subject<&'m Model> {
    /// Two models. Fits no BVH, unless the second mesh may be out of range.
    ///
    /// # Errors
    /// [`Error::Pose`] if the pose does not suit the second.
    pub(crate) fn pair(models: [&'m Model; 2], a_from_b: AnyPose) -> Result<Self, Error> {
        let [_, b] = models;
        // Vertices that no triangle has are in the outline too.
        if a_from_b.check(b.outline(&Outline::default())).is_err() {
            a_from_b.check(b.bvh())?;
        }
        Ok(Self::Pair { models, a_from_b })
    }
}

impl<M: Borrow<Model>> Subject<M> {
    /// The models, of which a lone one counts twice.
    pub(crate) fn both(&self) -> [&M; 2] {
        match self {
            Self::Pair { models: [a, b], .. } => [a, b],
            Self::Within { models: [model], .. } => [model; 2],
        }
    }

    pub(crate) fn key(&self) -> Key {
        let (a_from_b, adjacency) = match self {
            Self::Pair { a_from_b, .. } => (Some(*a_from_b), Adjacency::default()),
            Self::Within { adjacency, .. } => (None, *adjacency),
        };
        let models = self.both().map(|model| model.borrow().stamp());
        Key { models, a_from_b, adjacency }
    }

    /// The tree that the CPU traverses. Fits the BVHs to the positions, if that has not been done.
    ///
    /// # Errors
    /// [`Error::Memory`] if there is no memory for what the traversal goes by.
    pub(crate) fn tree(&self) -> Result<AnyBvtt<'_>, Error> {
        match self {
            Self::Pair { models, a_from_b } => {
                let bvhs = models.each_ref().map(|model| model.borrow().bvh());
                Ok(AnyBvtt::Pair(a_from_b.pair(bvhs)?))
            }
            Self::Within { models: [model], adjacency } => Ok(within(model.borrow(), *adjacency)),
        }
    }

    /// The same for what looks at single triangles and at poses, and traverses nothing: BVHs that do not fit are left alone.
    pub(crate) fn untraversed<'q>(
        &'q self,
        [of_a, of_b]: &'q [Outline; 2],
    ) -> Result<AnyBvtt<'q>, Error> {
        Ok(match self {
            Self::Pair { models: [a, b], a_from_b } => {
                let bvhs = [a.borrow().outline(of_a), b.borrow().outline(of_b)];
                AnyBvtt::Pair(a_from_b.pair(bvhs)?)
            }
            Self::Within { models: [model], .. } => {
                AnyBvtt::Within(SelfBvtt::new(model.borrow().outline(of_a)))
            }
        })
    }

    pub(crate) fn models(&self) -> &[M] {
        match self {
            Self::Pair { models, .. } => models,
            Self::Within { models, .. } => models,
        }
    }

    /// Whether no GPU answers: about a model in f64 and itself.
    pub(crate) fn is_for_cpu(&self) -> bool {
        matches!(self, Self::Within { models: [model], .. } if model.borrow().is_f64())
    }
}

/// The tree of a model and itself. Fits its BVH and its certificates, if that has not been done.
pub(crate) fn within(model: &Model, adjacency: Adjacency) -> AnyBvtt<'_> {
    let tree = SelfBvtt::new(model.bvh()).with_adjacency(adjacency);
    AnyBvtt::Within(tree.with_certificates(model.certificates()))
}
