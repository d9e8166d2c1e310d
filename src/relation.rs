//! The relation of two solids.

use crate::environment::with_default;
use crate::subject::Subject;
use crate::{AnyPose, Distance, Error, PairQuery, Pose, Pose64, Solid};
use pfront_core::relation::{Between, Overlap, Relation, RelationQuery};

impl PairQuery {
    /// The relation of two solids, exactly: apart, touching, crossing, one inside the other, or equal; undetermined where it
    /// hangs on triangles that meet their own mesh. With [`PairQuery::within`], solids that are apart are near if they are at most
    /// that far apart.
    ///
    /// The second solid is posed into the frame of the first, where rounding alone can make flush parts cross by a trifle: ask
    /// for their [overlap volume](PairQuery::overlap_volume) before calling that a clash. If the pose rounds positions and the answer could hang
    /// on that, a solid is made of the posed mesh.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    ///
    /// # Complexity
    /// Where solids cross, mostly that of [`PairQuery::any`]; else that of [`PairQuery::all`] and about a microsecond a pair, which several
    /// threads divide, and a ray for each part of a surface that meets the other nowhere.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose, Relation, Solid};
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let solid = Solid::new(Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?)?;
    /// let mut query = PairQuery::new();
    /// let mut at = |x| query.relation(&solid, &solid, Pose::from_translation([x, 0.0, 0.0]));
    /// assert_eq!(at(0.0)?.relation, Some(Relation::Equal));
    /// assert_eq!(at(0.25)?.relation, Some(Relation::Crossing));
    /// assert_eq!(at(1.0)?.relation, Some(Relation::Touching));
    /// assert_eq!(at(1.5)?.relation, Some(Relation::Apart));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn relation(
        &mut self,
        a: &Solid,
        b: &Solid,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<Between, Error> {
        let pose = a_from_b.into();
        with_default(|| {
            let subject = Subject::pair([&**a.model(), &**b.model()], pose, Distance::default())?;
            let mut between = self.query.relation(&subject, [a, b], pose)?;
            if between.is_rounded {
                between.is_rounded = false;
                let is_f64 = pose.is_f64() || a.model().is_f64() || b.model().is_f64();
                match b.posed(&pose, is_f64) {
                    Ok(posed) => {
                        let pose = AnyPose::F32(Pose::IDENTITY);
                        let models = [&**a.model(), &**posed.model()];
                        let subject = Subject::pair(models, pose, Distance::default())?;
                        between = self.query.relation(&subject, [a, &posed], pose)?;
                    }
                    // The posed mesh is no solid any more: what it is to the other remains undetermined.
                    Err(Error::Solid(_)) => {}
                    Err(error) => return Err(error),
                }
            }
            if between.relation == Some(Relation::Apart) && self.within > Distance::default() {
                let subject = Subject::pair([&**a.model(), &**b.model()], pose, self.within)?;
                if let Some(pair) = self.query.any(&subject)? {
                    between.relation = Some(Relation::Near);
                    between.pair = Some(pair);
                }
            }
            Ok(between)
        })
    }

    /// The volume that two solids have in common: an interval that holds it, in the units of the first. It is found from the triangle
    /// pairs that intersect, without any new mesh. A pose is taken in f64, in which it rounds positions least.
    ///
    /// Where rounding has made a posed mesh meet itself, points that it surrounds more than once count as often.
    ///
    /// # Errors
    /// As [`PairQuery::all`]; [`Error::Solid`] if triangles of one of the two meet their own mesh inside the other solid or on its
    /// surface.
    ///
    /// # Complexity
    /// As [`PairQuery::all`], about a microsecond a pair, and a ray for each part of a surface.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose, Solid};
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let solid = Solid::new(Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?)?;
    /// let half = Pose::from_translation([0.5, 0.0, 0.0]);
    /// let [low, high] = PairQuery::new().overlap_volume(&solid, &solid, half)?;
    /// assert!(low <= 1.0 / 48.0 && 1.0 / 48.0 <= high && high - low < 1e-12);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn overlap_volume(
        &mut self,
        a: &Solid,
        b: &Solid,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<[f64; 2], Error> {
        let mut pose = a_from_b.into();
        if pose.to_f64() != Pose64::IDENTITY {
            pose = pose.to_f64().into();
        }
        with_default(|| {
            let models = [&**a.model(), &**b.model()];
            let subject = Subject::pair(models, pose, Distance::default())?;
            let [a, b] = [a.view(), b.view()];
            let query = RelationQuery::of_pair(pose.pair([a.bvh(), b.bvh()])?, &a, &b);
            let mut overlap = Overlap::new(&query);
            self.query.all(&subject)?.iter().for_each(|&pair| overlap.add(pair));
            Ok(overlap.conclude()?)
        })
    }
}
