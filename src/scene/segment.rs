//! Triangles that a segment meets, and bodies that contain a point.

use super::SceneQuery;
use super::body::Body;
use super::id::BodyId;
use crate::environment::with_default;
use crate::executor::{self, Backend};
use crate::memory::push;
use crate::model::hits;
use crate::{Aabb, Error, Location, NotSolid, SegmentHit};
use pfront_core::segment::Segment;

/// Where a point is, as a body sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyLocation {
    /// The body.
    pub body: BodyId,
    /// Where the point is; or the edge that is open, so that there is no inside.
    pub location: Result<Location, NotSolid>,
}

impl SceneQuery {
    /// The triangles that the closed segment between two points of the world meets, with their bodies, sorted: exactly for the bodies as
    /// they are posed, each in the precision of its own model and pose. Otherwise as [`Model::segment`](crate::Model::segment). On the calling
    /// thread.
    ///
    /// # Errors
    /// As [`SceneQuery::bodies_in`]; [`Error::Mesh`] if a coordinate is NaN or beyond ±2^125.
    ///
    /// # Complexity
    /// As [`SceneQuery::bodies_in`] for the box of the segment, and [`Model::segment`](crate::Model::segment) for each of those bodies.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, Pose, SceneQuery};
    /// let tile = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// let floor = scene.add(tile.clone(), Pose::IDENTITY)?;
    /// let roof = scene.add(tile, Pose::from_translation([0.0, 0.0, 3.0]))?;
    /// let hits = scene.segment([0.5, 0.5, 4.0], [0.5, 0.5, 0.0])?;
    /// assert_eq!(hits.iter().map(|(body, hit)| (*body, hit.at)).collect::<Vec<_>>(), [(floor, 1.0), (roof, 0.25)]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn segment(
        &mut self,
        from: [impl Into<f64>; 3],
        to: [impl Into<f64>; 3],
    ) -> Result<Vec<(BodyId, SegmentHit)>, Error> {
        with_default(|| {
            let segment = Segment::new(from, to)?;
            let mut found = Vec::new();
            let places = self.places_around(segment.points())?;
            for body in self.bodies_at(&places) {
                executor::check(self.history.executor().cancel_flag())?;
                for hit in hits(&segment, &body.placed())? {
                    push(&mut found, (body.id(), hit))?;
                }
            }
            Ok(found)
        })
    }

    /// The first triangle along the segment from one point of the world to another, with its body: exactly; of triangles that it meets in one
    /// point, that of the body that was added first, and of its triangles the one with the lowest index.
    ///
    /// # Errors
    /// As [`SceneQuery::segment`].
    ///
    /// # Complexity
    /// As [`SceneQuery::segment`], without nodes beyond the first triangle that has been found so far.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// let floor = scene.add(tile.clone(), Pose::IDENTITY)?;
    /// let roof = scene.add(tile, Pose::from_translation([0.0, 0.0, 3.0]))?;
    /// let first = scene.segment_first([0.5, 0.5, 4.0], [0.5, 0.5, 0.0])?;
    /// assert_eq!(first.map(|(body, hit)| (body, hit.at)), Some((roof, 0.25)));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn segment_first(
        &mut self,
        from: [impl Into<f64>; 3],
        to: [impl Into<f64>; 3],
    ) -> Result<Option<(BodyId, SegmentHit)>, Error> {
        with_default(|| {
            let segment = Segment::new(from, to)?;
            let places = self.places_around(segment.points())?;
            // The flag may be cleared again before all is over.
            let (flag, mut heard) = (self.history.executor().cancel_flag(), Ok(()));
            let bodies = self.bodies_at(&places).take_while(|_| {
                heard = executor::check(flag);
                heard.is_ok()
            });
            let first = segment.first(bodies.map(Body::placed));
            heard?;
            let body = |number| self.bodies_at(&places).nth(number).map(Body::id);
            Ok(first.and_then(|(number, hit)| Some((body(number)?, hit))))
        })
    }

    /// The bodies that contain a point of the world, in their interior or on their surface, in the order of adding: exactly, as
    /// [`Solid::inside`](crate::Solid::inside) tells of the posed mesh. Bodies whose box contains the point and whose mesh is open are among
    /// them, with the edge. On the calling thread.
    ///
    /// # Errors
    /// As [`SceneQuery::segment`].
    ///
    /// # Complexity
    /// As [`SceneQuery::bodies_in`] for the point, and a ray for each of those bodies; and O(n log n) for each of their models, of n
    /// triangles, that is asked for the first time since it changed.
    ///
    /// # Examples
    /// ```
    /// use pfront::{BodyLocation, Location, Model, Pose, SceneQuery};
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let part = Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    /// let (part, mut scene) = (std::sync::Arc::new(part), SceneQuery::new());
    /// let near = scene.add(part.clone(), Pose::IDENTITY)?;
    /// let far = scene.add(part, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// let inside = BodyLocation { body: near, location: Ok(Location::Inside) };
    /// let on_surface = BodyLocation { body: far, location: Ok(Location::Surface) };
    /// assert_eq!(scene.inside([0.25, 0.25, 0.25])?, [inside]);
    /// assert_eq!(scene.inside([0.5, 0.125, 0.25])?, [inside, on_surface]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn inside(&mut self, point: [impl Into<f64>; 3]) -> Result<Vec<BodyLocation>, Error> {
        with_default(|| {
            let [point, _] = Segment::new(point.map(Into::into), [0.0; 3])?.points();
            let mut found = Vec::new();
            let places = self.places_around([point; 2])?;
            for body in self.bodies_at(&places) {
                executor::check(self.history.executor().cancel_flag())?;
                let rule = body.model().rule()?;
                let location = match rule.map(|rule| rule.inside(&body.placed(), point)) {
                    Ok(Ok(Location::Outside)) => continue,
                    Ok(location) => Ok(location?),
                    Err(error) => Err(error),
                };
                push(&mut found, BodyLocation { body: body.id(), location })?;
            }
            Ok(found)
        })
    }

    /// The places of the bodies whose box overlaps that of two points, ascending.
    fn places_around(&mut self, points: [[f64; 3]; 2]) -> Result<Vec<u32>, Error> {
        self.start();
        self.find_overlaps()?;
        self.history.note_cpu(Backend::Sequential);
        let (mut places, mut pushed) = (Vec::new(), Ok(()));
        self.broad.in_box(&rounded_out(points), |place| {
            if pushed.is_ok() {
                pushed = push(&mut places, place);
            }
        });
        pushed?;
        places.sort_unstable();
        Ok(places)
    }

    fn bodies_at(&self, places: &[u32]) -> impl Iterator<Item = &Body> {
        places.iter().filter_map(|&place| self.bodies.at(place))
    }
}

/// A box in f32 that contains two points.
fn rounded_out([p, q]: [[f64; 3]; 2]) -> Aabb {
    let mut out = Aabb::EMPTY;
    for k in 0..3 {
        let (low, high) = (p[k].min(q[k]), p[k].max(q[k]));
        let (min, max) = (low as f32, high as f32);
        out.min[k] = if f64::from(min) > low { min.next_down() } else { min };
        out.max[k] = if f64::from(max) < high { max.next_up() } else { max };
    }
    out
}
