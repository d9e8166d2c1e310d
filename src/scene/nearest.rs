//! The smallest distance of a body to the others.

use super::SceneQuery;
use super::body::Body;
use super::id::BodyId;
use crate::environment::with_default;
use crate::memory::push;
use crate::{Aabb, Distance, Error};
use pfront_core::bvtt::{Gap, PairBvtt};

impl SceneQuery {
    /// The body that is nearest to one, and their smallest distance in the world, 0 if they intersect; of bodies that are equally near,
    /// as far as the upper ends of the intervals tell, the one that was added first. Bodies that may not meet it, by their groups or
    /// because the two are [ignored](SceneQuery::ignore), are left out. `None` if there is no other body with triangles, or this one has none.
    ///
    /// Triangle `a` of [`Gap::pair`] is of the body that is asked about. The threads of the executor divide each search that is worth it;
    /// a GPU is not asked. The pair that was nearest to a body is tried first when it is asked about again.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if the body is not there; [`Error::Cancelled`] or [`Error::Memory`].
    ///
    /// # Complexity
    /// O(n log n) for n bodies, and a search for each whose box is nearer than the answer.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, Pose, SceneQuery};
    /// let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// let at = |z| Pose::from_translation([0.0, 0.0, z]);
    /// let (floor, lamp, roof) = (scene.add(tile.clone(), at(0.0))?, scene.add(tile.clone(), at(2.0))?, scene.add(tile, at(2.5))?);
    /// let (nearest, gap) = scene.distance(lamp)?.expect("there are other bodies");
    /// assert_eq!(nearest, roof);
    /// assert!(gap.interval[0] <= 0.5 && 0.5 <= gap.interval[1]);
    /// assert_eq!(scene.distance_below(floor, 1.5)?, None);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn distance(&mut self, body: BodyId) -> Result<Option<(BodyId, Gap)>, Error> {
        with_default(|| self.nearest(body, None))
    }

    /// [`SceneQuery::distance`], if it is at most `limit`: exactly, and sooner, as farther bodies and triangles are left out.
    ///
    /// # Errors
    /// As [`SceneQuery::distance`]; [`Error::Distance`] if the limit is NaN, infinite or negative.
    pub fn distance_below(
        &mut self,
        body: BodyId,
        limit: f32,
    ) -> Result<Option<(BodyId, Gap)>, Error> {
        let limit = Distance::new(limit)?;
        with_default(|| self.nearest(body, Some(limit)))
    }

    fn nearest(
        &mut self,
        id: BodyId,
        limit: Option<Distance>,
    ) -> Result<Option<(BodyId, Gap)>, Error> {
        self.bodies.compact();
        let (place, body) = self.bodies.placed(id)?;
        let mut others = Vec::new();
        if let Some(own) = body.aabb() {
            for (other, at) in self.bodies.iter().zip(0..) {
                let may_meet = at != place && self.bodies.may_meet([place.min(at), place.max(at)]);
                if let Some(aabb) = other.aabb().filter(|_| may_meet) {
                    push(&mut others, (apart(&own, &aabb), other))?;
                }
            }
        }
        let seed = self.nearest.get(&id).copied();
        // The nearest boxes first, but before all others the last answer.
        let is_other = |other: &Body| seed.is_none_or(|(last, _)| last != other.id());
        others.sort_unstable_by(|(x, a), (y, b)| {
            is_other(a).cmp(&is_other(b)).then(x.total_cmp(y)).then(a.id().cmp(&b.id()))
        });
        let (mut found, mut at_most) = (Vec::new(), limit);
        for (least, other) in others {
            if at_most.is_some_and(|at_most| least > f64::from(at_most.get())) {
                continue;
            }
            let seed = seed.filter(|(last, _)| *last == other.id()).map(|(_, pair)| pair);
            let tree = PairBvtt::in_world(body.placed(), other.placed());
            if let Some(gap) = self.history.distance(&tree, at_most, seed)? {
                push(&mut found, (other, gap))?;
                at_most = tighter(at_most, gap.interval[1]);
            }
        }
        let high = |(other, gap): &(&Body, Gap)| (gap.interval[1], other.id());
        let nearest = found.iter().copied().min_by(|x, y| {
            let ((x, a), (y, b)) = (high(x), high(y));
            x.total_cmp(&y).then(a.cmp(&b))
        });
        let Some((nearest, mut gap)) = nearest else { return Ok(None) };
        // Bodies that were asked about before the bound was this small count only if they are within it.
        let mut low = gap.interval[0];
        for (other, own) in found.iter().filter(|(_, own)| own.interval[0] < gap.interval[0]) {
            let tree = PairBvtt::in_world(body.placed(), other.placed());
            let within = self.history.distance(&tree, at_most, Some(own.pair))?;
            low = within.map_or(low, |within| low.min(within.interval[0]));
        }
        gap.interval[0] = low;
        self.nearest.insert(id, (nearest.id(), gap.pair));
        Ok(Some((nearest.id(), gap)))
    }
}

/// A bound that is above the upper end of an interval, so that it does not cut another off at the same number; none if no f32 is as
/// large.
fn tighter(at_most: Option<Distance>, high: f64) -> Option<Distance> {
    let above = Distance::at_least(high).ok().and_then(|d| Distance::new(d.get().next_up()).ok());
    match (at_most, above) {
        (Some(at_most), Some(above)) => Some(if above < at_most { above } else { at_most }),
        (at_most, above) => at_most.or(above),
    }
}

/// No more than the distance of what two boxes contain.
fn apart(a: &Aabb, b: &Aabb) -> f64 {
    let along = |k: usize| {
        let (low, high) = (a.min[k].max(b.min[k]), a.max[k].min(b.max[k]));
        (f64::from(low) - f64::from(high)).max(0.0)
    };
    // Less by far more than f64 rounds.
    (0..3).map(|k| along(k) * along(k)).sum::<f64>().sqrt() * 0.999_999
}
