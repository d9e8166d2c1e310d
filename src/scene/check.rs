//! The relations of all bodies of a scene, and whether they are allowed.

use super::SceneQuery;
use super::body::Body;
use super::broad::Places;
use super::pairs::BodyPairs;
use super::report::{Allowed, CheckReport, CheckedPair};
use crate::environment::with_default;
use crate::executor::{self, CpuPart};
use crate::memory::push;
use crate::{
    AnyPose, Between, ContactSize, Distance, Error, Model, NotSolid, PairQuery, Pose64, Relation,
    Solid,
};
use pfront_core::bvtt::{PairBvtt, Query};
use std::collections::BTreeMap;
use std::sync::Arc;

impl SceneQuery {
    /// The relation of every two bodies whose boxes overlap, and whether it is allowed: is this assembly right? With
    /// [`SceneQuery::within`], bodies that are apart are near if they are at most that far apart.
    ///
    /// Each pair is asked in the frame of its first body, by the relative pose in f64. Bodies whose poses are equal to the bit are asked
    /// as they are modelled, so that what is flush stays flush; in other poses rounding can make flush parts cross by a trifle.
    /// Volumes, gaps and distances are those of the world.
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
            let mut asked = Vec::new();
            for places in candidates.pairs().filter(|[a, b]| a != b) {
                push(&mut asked, places)?;
            }
            let part = CpuPart::new();
            let solids = self.solids(&asked, &part)?;
            let within = self.bodies.within;
            let alone = self.history.executor().alone();
            let check = |pairs: &[Places], out: &mut Vec<CheckedPair>| {
                part.works();
                let mut query = PairQuery::new().on(&alone);
                for &places in pairs {
                    executor::check(alone.cancel_flag())?;
                    let [Some(a), Some(b)] = places.map(|place| self.bodies.at(place)) else {
                        continue;
                    };
                    push(out, checked(&mut query, [a, b], within, &solids, allowed)?)?;
                }
                Ok(())
            };
            let mut pairs = Vec::new();
            let done = self.history.by_pieces(&asked, 1, check, &mut pairs);
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
    fn solids(&self, asked: &[Places], part: &CpuPart) -> Result<Solids, Error> {
        let bodies = asked.iter().flatten().filter_map(|&place| self.bodies.at(place));
        let models: BTreeMap<_, _> = bodies.map(|body| (key(body.model()), body.model())).collect();
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
        self.history.by_pieces(&models, 1, make, &mut solids)?;
        Ok(solids.into_iter().collect())
    }
}

/// Solids, or why there is none, by the address of their models.
type Solids = BTreeMap<usize, Result<Solid, NotSolid>>;

fn key(model: &Arc<Model>) -> usize {
    Arc::as_ptr(model) as usize
}

/// The pose of the second body in the frame of the first: none if both have the same.
fn relative(a: &Body, b: &Body) -> Option<Pose64> {
    let (pose_a, pose_b) = (a.pose(), b.pose());
    if pose_a.same_bits(&pose_b) {
        return Some(Pose64::IDENTITY);
    }
    let [own, other] = [pose_a, pose_b].map(|pose| pose.to_f64());
    if own == Pose64::IDENTITY {
        return Some(other);
    }
    Some(own.inverse()? * other)
}

/// How many times as large a volume is in the world as in the frame of a body, at least and at most.
fn scale(pose: &Pose64) -> [f64; 2] {
    let row = |k: usize| [pose.rows[k][0], pose.rows[k][1], pose.rows[k][2]];
    let [x, y, z] = [row(0), row(1), row(2)];
    let minor = |i: usize, j: usize| y[i] * z[j] - y[j] * z[i];
    let scale = (x[0] * minor(1, 2) + x[1] * minor(2, 0) + x[2] * minor(0, 1)).abs();
    // Products of three and their sum are rounded by at most 2^-50 of what Hadamard's bound allows.
    let length = |row: [f64; 3]| row.iter().map(|x| x.abs()).sum::<f64>();
    let error = length(x) * length(y) * length(z) * (4.0 * f64::EPSILON);
    if *pose == Pose64::IDENTITY { [1.0; 2] } else { [scale - error, scale + error] }
}

fn checked(
    query: &mut PairQuery,
    [a, b]: [&Body; 2],
    within: Distance,
    solids: &Solids,
    allowed: &Allowed,
) -> Result<CheckedPair, Error> {
    let mut found = CheckedPair {
        bodies: [a.id(), b.id()],
        relation: None,
        meets: false,
        overlap_volume: None,
        contact: None,
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
                    Ok([low, high]) => {
                        let [least, most] = scale(&a.pose().to_f64());
                        Some([(low * least).next_down().max(0.0), (high * most).next_up()])
                    }
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
    if let Some(pair) = found.pair {
        let tree = AnyPose::from(pose).pair([a.model().bvh(), b.model().bvh()])?;
        let contact = tree.contact_f64(pair);
        found.place = contact.map(|contact| a.pose().to_f64().apply(contact.segment[0]));
    }
    if found.meets && allowed.with_contacts {
        let models = [&**a.model(), &**b.model()];
        let patches = query.patches_in(models, pose.into(), &a.pose().to_f64())?;
        found.contact = ContactSize::of(&patches);
    }
    if found.relation == Some(Relation::Apart)
        && within > Distance::default()
        && let Some(gap) = PairBvtt::in_world(a.placed(), b.placed()).distance(Some(within), None)
    {
        found.relation = Some(Relation::Near);
        (found.gap, found.pair) = (Some(gap.interval), Some(gap.pair));
    }
    let is_small = found.overlap_volume.is_some_and(|[_, high]| high <= allowed.overlap_volume);
    found.is_allowed =
        found.relation.is_some_and(|relation| allowed.relations.contains(&relation)) || is_small;
    Ok(found)
}
