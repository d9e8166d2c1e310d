//! Solids: closed models, with what has to be known of them once.

use crate::environment::with_default;
use crate::memory::filled;
use crate::{AnyPose, Error, Location, Model, TrianglePair};
use pfront_core::relation::{Rule, Solid as View, solid_bound, solid_scratch_bound};
use std::sync::Arc;

/// A closed model with what has to be known of it once to tell its relation to others: the triangles around each edge, which of
/// them meet their own mesh elsewhere, and where the inside is. Takes 36 bytes a triangle and 44 a vertex beside the model.
///
/// Equal positions are one vertex, so that a soup of triangles, as STL files have it, is closed too. Several bodies in one mesh
/// are one solid; see [`Rule`] for the inside of what overlaps. Triangles that meet their own mesh beyond the corners that they
/// share are allowed, and a relation that hangs on one of them is undetermined.
///
/// # Examples
/// ```
/// use pfront::{Error, Model, NotSolid, Solid};
/// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let solid = Solid::new(Model::new(corners.clone(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?)?;
/// assert!(solid.marked_pair().is_none());
/// let open = Solid::new(Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2]])?);
/// assert!(matches!(open.err(), Some(Error::Solid(NotSolid::OpenEdge { triangle: 0, edge: 1 }))));
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Solid {
    model: Arc<Model>,
    words: Vec<u32>,
}

impl Solid {
    /// Finds what has to be known of a model, which is shared.
    ///
    /// # Errors
    /// [`Error::Solid`] names the triangle for which it is no solid; [`Error::Memory`].
    ///
    /// # Complexity
    /// O(n log n) for n triangles, and a query of the model about itself.
    pub fn new(model: impl Into<Arc<Model>>) -> Result<Self, Error> {
        Self::of(model.into(), false)
    }

    /// The same of a model that is asked about as a surface: it may be open and meet itself, and has no interior. To a solid it is apart,
    /// touching, crossing or inside; to another surface apart, touching or crossing, or undetermined where they meet along edges alone.
    ///
    /// # Errors
    /// [`Error::Solid`] if no triangle has an area; [`Error::Memory`].
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose, Relation, Solid};
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let open = Solid::surface(Model::new(corners.clone(), vec![[1, 2, 3]])?)?;
    /// let solid = Solid::new(Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?)?;
    /// let mut query = PairQuery::new();
    /// let mut at = |s| query.relation(&open, &solid, Pose::new([[s, 0.0, 0.0, -0.25], [0.0, s, 0.0, -0.25], [0.0, 0.0, s, -0.25]]));
    /// assert_eq!(at(4.0)?.relation, Some(Relation::AInB));
    /// assert_eq!(at(1.5)?.relation, Some(Relation::Apart));
    /// assert_eq!(at(1.75)?.relation, Some(Relation::Touching));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn surface(model: impl Into<Arc<Model>>) -> Result<Self, Error> {
        Self::of(model.into(), true)
    }

    fn of(model: Arc<Model>, is_surface: bool) -> Result<Self, Error> {
        let (vertices, n) = (model.mesh().vertex_count(), model.mesh().triangles().len());
        let mut words = filled(0, solid_bound(vertices, n))?;
        let mut scratch = filled(0, solid_scratch_bound(vertices, n))?;
        with_default(|| match is_surface {
            true => View::surface(model.bvh(), &mut words, &mut scratch).map(drop),
            false => View::new(model.bvh(), &mut words, &mut scratch).map(drop),
        })?;
        Ok(Self { model, words })
    }

    /// Its model.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The rule for its interior.
    #[must_use]
    pub fn rule(&self) -> Rule {
        self.view().rule()
    }

    /// The lowest pair of triangles that meet beyond the corners that they share, if there is one.
    #[must_use]
    pub fn marked_pair(&self) -> Option<TrianglePair> {
        self.view().marked_pair()
    }

    /// Where a point is, in the frame of the model: exactly, by its winding number and the [rule](Solid::rule), also where triangles meet
    /// their own mesh. Coordinates may be of any type that f64 holds.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is NaN or beyond ±2^125.
    ///
    /// # Complexity
    /// A ray: O(nodes whose boxes it reaches).
    ///
    /// # Examples
    /// ```
    /// use pfront::{Location, Model, Solid};
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let solid = Solid::new(Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?)?;
    /// assert_eq!(solid.inside([0.25, 0.25, 0.25])?, Location::Inside);
    /// assert_eq!(solid.inside([0.25, 0.25, 0.5])?, Location::Surface);
    /// assert_eq!(solid.inside([1, 1, 1])?, Location::Outside);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn inside(&self, point: [impl Into<f64>; 3]) -> Result<Location, Error> {
        Ok(with_default(|| self.view().inside(point))?)
    }

    pub(crate) fn view(&self) -> View<'_> {
        View::new_unchecked(self.model.bvh(), &self.words)
    }

    /// The solid of the posed mesh.
    pub(crate) fn posed(&self, pose: &AnyPose, is_f64: bool) -> Result<Self, Error> {
        let mesh = self.model.mesh();
        let triangles = mesh.triangles().to_vec();
        let model = match pose {
            AnyPose::F32(pose) if !is_f64 => {
                let posed = mesh.shadow().iter().map(|&p| pose.apply(p));
                Model::new(posed.collect(), triangles)?
            }
            pose => {
                let pose = pose.to_f64();
                let posed = match mesh.positions_f64() {
                    Some(positions) => positions.iter().map(|&p| pose.apply(p)).collect(),
                    None => mesh.shadow().iter().map(|p| pose.apply(p.map(f64::from))).collect(),
                };
                Model::from_f64(posed, triangles)?
            }
        };
        Self::of(Arc::new(model), self.rule() == Rule::Surface)
    }
}
