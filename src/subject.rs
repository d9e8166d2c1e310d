//! The subjects of questions: two models, or one and itself.

use crate::model::{Outline, Stamp};
use crate::{Adjacency, AnyPose, Distance, Error, Model};
use pfront_core::bvtt::{AnyBvtt, SelfBvtt};
use std::borrow::Borrow;

/// The largest distance about which a GPU is asked. It refuses all above: boxes that grow by more are not finite.
const LARGEST_ON_GPU: f32 = f32::MAX / 4.0;

/// A subject of a frame, which borrows its models or shares them, and the distance within which pairs are hits.
#[derive(Clone, Debug)]
pub(crate) enum Subject<M> {
    /// Two models, the second in a pose that suits it.
    Pair { models: [M; 2], a_from_b: AnyPose, within: Distance },
    /// A model and itself.
    Itself { models: [M; 1], adjacency: Adjacency, within: Distance },
}

/// All that an answer about a subject depends on: of equal keys the same answer is true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Key {
    models: [Stamp; 2],
    /// None within one mesh.
    a_from_b: Option<AnyPose>,
    adjacency: Adjacency,
    within: Distance,
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
    pub(crate) fn pair(
        models: [&'m Model; 2],
        a_from_b: AnyPose,
        within: Distance,
    ) -> Result<Self, Error> {
        let [_, b] = models;
        // Vertices that no triangle has are in the outline too.
        if a_from_b.check(b.outline(&Outline::default())).is_err() {
            a_from_b.check(b.bvh())?;
        }
        Ok(Self::Pair { models, a_from_b, within })
    }
}

impl<M: Borrow<Model>> Subject<M> {
    /// The models, of which a lone one counts twice.
    pub(crate) fn both(&self) -> [&M; 2] {
        match self {
            Self::Pair { models: [a, b], .. } => [a, b],
            Self::Itself { models: [model], .. } => [model; 2],
        }
    }

    pub(crate) fn key(&self) -> Key {
        let (a_from_b, adjacency, within) = match self {
            Self::Pair { a_from_b, within, .. } => (Some(*a_from_b), Adjacency::default(), *within),
            Self::Itself { adjacency, within, .. } => (None, *adjacency, *within),
        };
        let models = self.both().map(|model| model.borrow().stamp());
        Key { models, a_from_b, adjacency, within }
    }

    /// The tree that the CPU traverses. Fits the BVHs to the positions, if that has not been done.
    ///
    /// # Errors
    /// [`Error::Memory`] if there is no memory for what the traversal goes by.
    pub(crate) fn tree(&self) -> Result<AnyBvtt<'_>, Error> {
        match self {
            Self::Pair { models, a_from_b, within } => {
                let bvhs = models.each_ref().map(|model| model.borrow().bvh());
                Ok(AnyBvtt::Pair(a_from_b.pair(bvhs)?.within(*within)))
            }
            Self::Itself { models: [model], adjacency, within } => {
                Ok(itself(model.borrow(), *adjacency, *within))
            }
        }
    }

    /// The same for what looks at single triangles and at poses, and traverses nothing: BVHs that do not fit are left alone.
    pub(crate) fn untraversed<'q>(
        &'q self,
        [of_a, of_b]: &'q [Outline; 2],
    ) -> Result<AnyBvtt<'q>, Error> {
        Ok(match self {
            Self::Pair { models: [a, b], a_from_b, .. } => {
                let bvhs = [a.borrow().outline(of_a), b.borrow().outline(of_b)];
                AnyBvtt::Pair(a_from_b.pair(bvhs)?)
            }
            Self::Itself { models: [model], .. } => {
                AnyBvtt::Itself(SelfBvtt::new(model.borrow().outline(of_a)))
            }
        })
    }

    /// The distance within which pairs are hits.
    pub(crate) fn distance(&self) -> Distance {
        match self {
            Self::Pair { within, .. } | Self::Itself { within, .. } => *within,
        }
    }

    pub(crate) fn models(&self) -> &[M] {
        match self {
            Self::Pair { models, .. } => models,
            Self::Itself { models, .. } => models,
        }
    }

    /// Whether no GPU answers: about a model and itself if it is in f64, or pairs within a distance are asked for; and within distances
    /// that are beyond a GPU.
    pub(crate) fn is_for_cpu(&self) -> bool {
        match self {
            Self::Pair { .. } => self.distance().get() > LARGEST_ON_GPU,
            Self::Itself { models: [model], .. } => {
                self.distance() > Distance::default() || model.borrow().is_f64()
            }
        }
    }
}

/// The tree of a model and itself. Fits its BVH and its certificates, if that has not been done.
pub(crate) fn itself(model: &Model, adjacency: Adjacency, within: Distance) -> AnyBvtt<'_> {
    let tree = SelfBvtt::new(model.bvh()).with_adjacency(adjacency).within(within);
    AnyBvtt::Itself(tree.with_certificates(model.certificates_for(adjacency)))
}
