//! The relations of all bodies of a scene, and whether they are allowed.

use super::SceneQuery;
use super::body::Body;
use super::pairs::BodyPairs;
use super::report::{Allowed, CheckReport, CheckedPair};
use crate::environment::with_default;
use crate::executor::{self, CpuPart};
use crate::memory::push;
use crate::{AnyPose, Between, Error, Model, NotSolid, PairQuery, Pose, Pose64, Relation, Solid};
use pfront_core::bvtt::Query;
use std::collections::BTreeMap;
use std::sync::Arc;

impl SceneQuery {
    /// The relation of every two bodies whose boxes overlap, and whether it is allowed: is this assembly right? With
    /// [`SceneQuery::within`], bodies that are apart are near if they are at most that far apart.
    ///
    /// Each pair is asked in the frame of its first body, by the relative pose, in f64 unless neither body is turned or moved: so
    /// parts that are flush and turned alike stay flush.
    ///
    /// # Errors
    /// As [`SceneQuery::intersecting_bodies`]. A body that is no solid is no error, but in the report.
    ///
    /// # Complexity
    /// A [`Solid`] for each model that meets the box of another, and [`PairQuery::relation`] for each pair, which several threads divide;
    /// a GPU is not asked.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Allowed, Model, Pose, Relation, SceneQuery};
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let part = Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    /// let (part, mut scene) = (std::sync::Arc::new(part), SceneQuery::new());
    /// scene.add(part.clone(), Pose::IDENTITY)?;
    /// let other = scene.add(part, Pose::from_translation([1.0, 0.0, 0.0]))?;
    /// assert!(scene.check(&Allowed::default())?.is_allowed(), "they touch");
    /// scene.set_pose(other, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// let report = scene.check(&Allowed::default())?;
    /// assert!(!report.is_allowed() && report.pairs[0].relation == Some(Relation::Crossing));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn check(&mut self, allowed: &Allowed) -> Result<CheckReport, Error> {
        self.start();
        with_default(|| {
            self.find_overlaps()?;
            let candidates = BodyPairs::since(0, &self.bodies, &self.broad);
            let mut asked: Vec<[&Body; 2]> = Vec::new();
            for [a, b] in candidates.pairs().filter(|[a, b]| a != b) {
                if let (Some(a), Some(b)) = (self.bodies.at(a), self.bodies.at(b)) {
                    push(&mut asked, [a, b])?;
                }
            }
            let part = CpuPart::new();
            let solids = self.solids(&asked, &part)?;
            let within = self.bodies.within.get();
            let alone = self.history.executor().alone();
            let check = |pairs: &[[&Body; 2]], out: &mut Vec<CheckedPair>| {
                part.works();
                let mut query = PairQuery::new().within(within)?.on(&alone);
                for &bodies in pairs {
                    push(out, checked(&mut query, bodies, &solids, allowed)?)?;
                }
                Ok(())
            };
            let mut pairs = Vec::new();
            let done = self.history.by_pieces(&asked, check, &mut pairs);
            let mut refused = Vec::new();
            for body in self.bodies.iter() {
                if let Some(Err(error)) = solids.get(&key(body.model())) {
                    push(&mut refused, (body.id(), *error))?;
                }
            }
            self.history.note_cpu(part.backend());
            done?;
            pairs.sort_unstable_by_key(|pair| pair.bodies);
            Ok(CheckReport { refused, pairs })
        })
    }

    /// The solid of each model that is asked about, by its key.
    fn solids(&self, asked: &[[&Body; 2]], part: &CpuPart) -> Result<Solids, Error> {
        let models: BTreeMap<_, _> =
            asked.iter().flatten().map(|body| (key(body.model()), body.model())).collect();
        let models: Vec<_> = models.into_iter().collect();
        let make = |models: &[(usize, &Arc<Model>)], out: &mut Vec<_>| {
            part.works();
            for &(key, model) in models {
                executor::check(self.history.executor().cancel_flag())?;
                let solid = match Solid::new(model.clone()) {
                    Ok(solid) => Ok(solid),
                    Err(Error::Solid(error)) => Err(error),
                    Err(error) => return Err(error),
                };
                push(out, (key, solid))?;
            }
            Ok(())
        };
        let mut solids = Vec::new();
        self.history.by_pieces(&models, make, &mut solids)?;
        Ok(solids.into_iter().collect())
    }
}

/// Solids, or why there is none, by the address of their models.
type Solids = BTreeMap<usize, Result<Solid, NotSolid>>;

fn key(model: &Arc<Model>) -> usize {
    Arc::as_ptr(model) as usize
}

/// The pose of the second body in the frame of the first. Bodies that are turned alike are not turned against each other.
fn relative(a: &Body, b: &Body) -> Option<AnyPose> {
    let (pose_a, pose_b) = (a.pose(), b.pose());
    if pose_a.same_bits(&pose_b) {
        return Some(Pose::IDENTITY.into());
    }
    let [own, other] = [pose_a, pose_b].map(|pose| pose.to_f64());
    if own == Pose64::IDENTITY {
        return Some(pose_b);
    }
    let mut relative = own.inverse()? * other;
    let is_turned_alike = (0..3).all(|i| own.rows[i][..3] == other.rows[i][..3]);
    if is_turned_alike {
        let offset = [0, 1, 2].map(|k| other.rows[k][3] - own.rows[k][3]);
        let mut back = own.inverse()?;
        back.rows.iter_mut().for_each(|row| row[3] = 0.0);
        relative = Pose64::from_translation(back.apply(offset));
    }
    Some(relative.into())
}

fn checked(
    query: &mut PairQuery,
    [a, b]: [&Body; 2],
    solids: &Solids,
    allowed: &Allowed,
) -> Result<CheckedPair, Error> {
    let mut found = CheckedPair {
        bodies: [a.id(), b.id()],
        relation: None,
        meets: false,
        overlap_volume: None,
        gap: None,
        pair: None,
        place: None,
        is_allowed: false,
    };
    let Some(pose) = relative(a, b) else { return Ok(found) };
    match [a, b].map(|body| solids.get(&key(body.model()))) {
        [Some(Ok(own)), Some(Ok(other))] => {
            let Between { relation, meets, pair, .. } = query.relation(own, other, pose)?;
            (found.relation, found.meets, found.pair) = (relation, meets, pair);
            if relation == Some(Relation::Crossing) {
                found.overlap_volume = match query.overlap_volume(own, other, pose) {
                    Ok(volume) => Some(volume),
                    Err(Error::Solid(_)) => None,
                    Err(error) => return Err(error),
                };
            }
        }
        // Meshes that are no solids have surfaces all the same.
        _ => {
            found.pair = query.any(a.model(), b.model(), pose)?;
            found.meets = found.pair.is_some();
        }
    }
    if found.relation == Some(Relation::Near) {
        found.gap = query.distance(a.model(), b.model(), pose)?.map(|gap| gap.interval);
    }
    if let Some(pair) = found.pair {
        let tree = pose.pair([a.model().bvh(), b.model().bvh()])?;
        let contact = tree.contact_f64(pair);
        found.place = contact.map(|contact| a.pose().to_f64().apply(contact.segment[0]));
    }
    let is_small = found.overlap_volume.is_some_and(|[_, high]| high <= allowed.overlap_volume);
    found.is_allowed =
        found.relation.is_some_and(|relation| allowed.relations.contains(&relation)) || is_small;
    Ok(found)
}
