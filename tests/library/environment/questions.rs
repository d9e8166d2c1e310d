//! Every verb of every query.

use super::{Soup, read};
use pfront::pfront_core::bvtt::Query;
use pfront::threads::{Pool, Traversal};
use pfront::*;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Triangles of a model: enough for a front, and few, since each operation on such small numbers takes long.
const COUNT: u32 = 20;

/// The models that are asked about, made in the default environment, and positions that one of them is moved to.
pub(crate) struct Subjects {
    models: [Arc<Model>; 2],
    in_f64: [Arc<Model>; 2],
    other: Soup,
}

impl Subjects {
    pub(crate) fn new() -> Self {
        let soups = [Soup::new(1, COUNT), Soup::new(2, COUNT)];
        Self {
            models: soups.each_ref().map(|soup| Arc::new(soup.model())),
            in_f64: soups.each_ref().map(|soup| Arc::new(soup.model_f64())),
            other: Soup::new(3, COUNT),
        }
    }
}

/// An answer to any verb.
#[derive(Debug, PartialEq)]
pub(crate) enum Answer {
    Found(bool),
    Count(u64),
    Pairs(Vec<TrianglePair>),
    Contacts(Vec<(TrianglePair, Contact)>),
    ContactsF64(Vec<(TrianglePair, Contact<f64>)>),
    Patches(Vec<ContactPatch>),
    Impacts(Vec<(TrianglePair, Impact)>),
    /// The intervals, since any of the pairs that intersect may be told.
    Gaps(Vec<Option<[f64; 2]>>),
    /// Bodies by the order in which they were added.
    Hits(Vec<([usize; 2], TrianglePair)>),
}

impl From<Vec<Option<[f64; 2]>>> for Answer {
    fn from(intervals: Vec<Option<[f64; 2]>>) -> Self {
        Self::Gaps(intervals)
    }
}

impl From<Vec<Option<Gap>>> for Answer {
    fn from(gaps: Vec<Option<Gap>>) -> Self {
        Self::Gaps(gaps.into_iter().map(|gap| gap.map(|gap| gap.interval)).collect())
    }
}

impl<T> From<Option<T>> for Answer {
    fn from(found: Option<T>) -> Self {
        Self::Found(found.is_some())
    }
}

pub(crate) type Named = Vec<(String, Answer)>;

pub(crate) fn compare(found: &Named, expected: &Named, place: &str) {
    assert_eq!(found.len(), expected.len());
    for ((name, found), (_, expected)) in found.iter().zip(expected) {
        assert!(found == expected, "{name}, {place}");
    }
}

/// The answers to all of them by an executor, with their names.
pub(crate) fn all(subjects: &Subjects, executor: &Executor) -> Named {
    let mut named = Vec::new();
    let least = Pose::from_translation([0.0, 0.0, f32::from_bits(1)]);
    let least_f64 = Pose64::from_translation([0.0, f64::from_bits(1), 0.0]);
    let poses = [AnyPose::F32(Pose::IDENTITY), AnyPose::F32(least), AnyPose::F64(least_f64)];
    for (kind, models) in [("f32", &subjects.models), ("f64", &subjects.in_f64)] {
        let (first, last) = if kind == "f32" { (0, 2) } else { (1, 3) };
        for (number, &pose) in poses[first..last].iter().enumerate() {
            pairs(&mut named, &format!("{kind}, pose {number}, "), models, pose, executor);
        }
        within(&mut named, &format!("{kind}, "), &models[0], executor);
        batch(&mut named, &format!("{kind}, "), models, &poses, executor);
    }
    deforming(&mut named, subjects, executor);
    solids(&mut named, executor);
    segments(&mut named, executor);
    motions(&mut named, subjects, executor);
    scene(&mut named, subjects, executor);
    named
}

/// The motion is subnormal, as all positions are.
fn motions(named: &mut Named, subjects: &Subjects, on: &Executor) {
    let mut add = |verb: &str, answer| named.push((verb.to_owned(), answer));
    let count = |[proven, all]: [u64; 2]| Answer::Count(proven << 32 | all);
    for (kind, [a, b]) in [("f32", &subjects.models), ("f64", &subjects.in_f64)] {
        let (mut query, rest) = (PairQuery::new().on(on), Motion::at_rest(a));
        let at = |x: u32| Pose::from_translation([-f32::from_bits(x), f32::from_bits(1), 0.0]);
        let moving = Motion::new(b, at(0), at(300)).unwrap();
        let mut add = |verb: &str, answer| add(&format!("PairQuery::{verb}, {kind}"), answer);
        add("impacts", Answer::Impacts(query.impacts(&rest, &moving).unwrap()));
        let first = query.first_impact(&rest, &moving).unwrap();
        add("first_impact", Answer::Impacts(Vec::from_iter(first)));
        add("any_impact", query.any_impact(&rest, &moving).unwrap().into());
        add("count_impacts", count(query.count_impacts(&rest, &moving).unwrap()));
    }
    let (model, mut end) = (&*subjects.models[0], subjects.models[0].try_clone().unwrap());
    end.set_positions(&subjects.other.positions).unwrap();
    let (mut query, motion) = (SelfQuery::new().on(on), Motion::between(model, &end).unwrap());
    add("SelfQuery::impacts", Answer::Impacts(query.impacts(&motion).unwrap()));
    let first = query.first_impact(&motion).unwrap();
    add("SelfQuery::first_impact", Answer::Impacts(Vec::from_iter(first)));
    add("SelfQuery::any_impact", query.any_impact(&motion).unwrap().into());
    add("SelfQuery::count_impacts", count(query.count_impacts(&motion).unwrap()));
}

fn pairs(named: &mut Named, kind: &str, [a, b]: &[Arc<Model>; 2], pose: AnyPose, on: &Executor) {
    let mut query = PairQuery::new().on(on);
    let mut add = |verb: &str, answer| named.push((format!("PairQuery::{verb}, {kind}"), answer));
    add("any", query.any(a, b, pose).unwrap().into());
    add("count", Answer::Count(query.count(a, b, pose).unwrap()));
    add("all", Answer::Pairs(query.all(a, b, pose).unwrap().to_vec()));
    add("contacts", Answer::Contacts(query.contacts(a, b, pose).unwrap().to_vec()));
    add("contacts_f64", Answer::ContactsF64(query.contacts_f64(a, b, pose).unwrap()));
    add("patches", Answer::Patches(query.patches(a, b, pose).unwrap()));
    add("distance", vec![query.distance(a, b, pose).unwrap()].into());
    add("distance_below", vec![query.distance_below(a, b, pose, 1e-40).unwrap()].into());
    let mut count = 0;
    let visited = query.visit(a, b, pose, |_| {
        count += 1;
        ControlFlow::Continue(())
    });
    assert!(visited.unwrap().is_continue());
    add("visit", Answer::Count(count));
    add(
        "AnyPose::pair",
        Answer::Count(
            pose.pair([a.bvh(), b.bvh()])
                .map_or(0, |query| pfront_core::environment::with_default(|| query.count())),
        ),
    );
    let to_f64 = pose.to_f64().rows.map(|row| row.map(f64::to_bits));
    add("AnyPose::to_f64", Answer::Count(to_f64.as_flattened().iter().fold(0, |x, y| x ^ y)));
}

fn within(named: &mut Named, kind: &str, model: &Model, on: &Executor) {
    // Certificates are made by the question.
    let model = &model.clone();
    let mut query = SelfQuery::new().on(on);
    let mut add = |verb: &str, answer| named.push((format!("SelfQuery::{verb}, {kind}"), answer));
    add("any", query.any(model).unwrap().into());
    add("count", Answer::Count(query.count(model).unwrap()));
    add("all", Answer::Pairs(query.all(model).unwrap().to_vec()));
    add("contacts", Answer::Contacts(query.contacts(model).unwrap().to_vec()));
    add("contacts_f64", Answer::ContactsF64(query.contacts_f64(model).unwrap()));
    let mut count = 0;
    assert!(
        SelfQuery::new()
            .visit(model, |_| {
                count += 1;
                ControlFlow::Continue(())
            })
            .unwrap()
            .is_continue()
    );
    add("visit", Answer::Count(count));
}

/// Solids, which are made in the environment, in poses that round.
fn solids(named: &mut Named, on: &Executor) {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let model = Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap();
    let model = Arc::new(model);
    let solid = Solid::new(model.clone()).unwrap();
    let surface = Solid::surface(model.clone()).unwrap();
    let mut query = PairQuery::new().on(on);
    let offsets =
        [[0.0; 3], [1e-40, 0.0, 1e-39], [0.1, 0.3, 0.0], [0.7, 1e-40, 0.1], [1.0, 0.0, 0.0]];
    for (number, offset) in offsets.into_iter().enumerate() {
        let pose = Pose::from_translation(offset);
        let between = query.relation(&solid, &solid, pose).unwrap();
        let word = between.relation.map_or(99, |relation| relation as u64);
        named.push((format!("PairQuery::relation, {number}"), Answer::Count(word)));
        let between = query.relation(&surface, &solid, pose).unwrap();
        let word = between.relation.map_or(99, |relation| relation as u64);
        named.push((format!("PairQuery::relation, surface, {number}"), Answer::Count(word)));
        let volume = query.overlap_volume(&solid, &solid, pose).unwrap();
        named.push((format!("PairQuery::overlap_volume, {number}"), vec![Some(volume)].into()));
        let mut scene = SceneQuery::new().on(on);
        scene.add(model.clone(), Pose::IDENTITY).unwrap();
        scene.add(model.clone(), pose).unwrap();
        let patches = query.patches(&model, &model, pose).unwrap();
        let size = ContactSize::of(&patches);
        let sizes = size.map_or([None; 2], |size| [Some(size.length), Some(size.area)]);
        named.push((format!("ContactSize::of, {number}"), sizes.to_vec().into()));
        let allowed = Allowed { with_contacts: true, ..Allowed::default() };
        let report = scene.check(&allowed).unwrap();
        let relations = report.pairs.iter().map(|pair| pair.relation.map_or(99, |r| r as u64));
        named.push((format!("SceneQuery::check, {number}"), Answer::Count(relations.sum())));
    }
}

/// Points and segments of which f32 holds some only as subnormal numbers, and f64 others.
fn segments(named: &mut Named, on: &Executor) {
    let size = f32::from_bits(9);
    let corners = vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
    let model = Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap();
    let model = Arc::new(model);
    let solid = Solid::new(model.clone()).unwrap();
    let mut scene = SceneQuery::new().on(on);
    scene.add(model.clone(), Pose::IDENTITY).unwrap();
    scene.add(model.clone(), Pose::from_translation([size, 0.0, 0.0])).unwrap();
    for number in 0..6 {
        let near = [f32::from_bits(number), f32::from_bits(number / 2), f32::from_bits(3)];
        let far = [f32::from_bits(number), f32::from_bits(3), f32::MIN_POSITIVE];
        let mut add = |verb: &str, answer| named.push((format!("{verb}, {number}"), answer));
        let location = solid.inside(near).unwrap();
        add("Solid::inside", Answer::Count(location as u64));
        let bodies = scene.inside(near).unwrap();
        let sum = bodies.iter().map(|body| 1 + body.location.unwrap() as u64).sum();
        add("SceneQuery::inside", Answer::Count(sum));
        let bits = |hits: &[SegmentHit]| {
            let bits = hits.iter().map(|hit| hit.at.to_bits() ^ u64::from(hit.triangle) << 52);
            Answer::Count(bits.fold(hits.len() as u64, |x, y| x.rotate_left(3) ^ y))
        };
        add("Model::segment", bits(&model.segment(near, far).unwrap()));
        add("Model::segment_first", bits(model.segment_first(near, far).unwrap().as_slice()));
        let hits: Vec<_> = scene.segment(near, far).unwrap().iter().map(|(_, hit)| *hit).collect();
        add("SceneQuery::segment", bits(&hits));
        let first = scene.segment_first(far, near).unwrap().map(|(_, hit)| hit);
        add("SceneQuery::segment_first", bits(first.as_slice()));
    }
}

/// Positions that the query sets.
fn deforming(named: &mut Named, subjects: &Subjects, on: &Executor) {
    let (mut model, mut query) = ((*subjects.models[0]).clone(), SelfQuery::new().on(on));
    query.count(&model).unwrap();
    query.set_positions(&mut model, &subjects.other.positions).unwrap();
    let moved = query.all(&model).unwrap().to_vec();
    named.push(("SelfQuery::set_positions".to_owned(), Answer::Pairs(moved)));
}

fn batch(
    named: &mut Named,
    kind: &str,
    models: &[Arc<Model>; 2],
    poses: &[AnyPose],
    on: &Executor,
) {
    let mut batch = Batch::new();
    for &pose in poses {
        batch.pair(&models[0], &models[1], pose).unwrap();
    }
    batch.itself(&models[0], Adjacency::default());
    let mut add = |verb: &str, answer| named.push((format!("Batch::{verb}, {kind}"), answer));
    let mut ticket = batch.count(on).unwrap();
    while !ticket.is_ready() {
        std::thread::yield_now();
    }
    let counts = ticket.try_read().unwrap().unwrap();
    counts.iter().for_each(|&count| add("count", Answer::Count(count)));
    let found = batch.any(on).unwrap().read().unwrap();
    found.into_iter().for_each(|found| add("any", found.into()));
    let lists = batch.all(on).unwrap().read().unwrap();
    lists.iter().for_each(|list| add("all", Answer::Pairs(list.to_vec())));
    let mut pairs = Batch::new();
    pairs.pair(&models[0], &models[1], poses[0]).unwrap();
    let gaps = pairs.distance(on).unwrap().read().unwrap();
    add("distance", gaps.into());
    let gaps = pairs.distance_below(on, 1e-40).unwrap().read().unwrap();
    add("distance_below", gaps.into());
    // A single question, which all threads divide, awaited in slices.
    let mut single = Batch::new();
    single.pair(&models[0], &models[1], poses[0]).unwrap();
    let mut ticket = single.all(on).unwrap();
    let list = loop {
        if let Some(lists) = ticket.wait(std::time::Duration::from_millis(2)).unwrap() {
            break lists[0].to_vec();
        }
    };
    add("all of one", Answer::Pairs(list));
}

fn scene(named: &mut Named, subjects: &Subjects, on: &Executor) {
    let [a, b] = &subjects.models;
    let mut scene = SceneQuery::new().on(on);
    let mut bodies: Vec<BodyId> = Vec::new();
    let unit = |x: u32| Pose::from_translation([f32::from_bits(x), 0.0, 0.0]);
    for (model, pose) in [(a, unit(0)), (b, unit(40)), (&subjects.in_f64[0], unit(3))] {
        bodies.push(scene.add(model.clone(), pose).unwrap());
    }
    each_verb(named, "add", &mut scene, &bodies);
    scene.set_pose(bodies[1], unit(60)).unwrap();
    scene.set_positions(bodies[0], &subjects.other.positions).unwrap();
    scene.set_positions(bodies[2], &subjects.other.positions_f64).unwrap();
    each_verb(named, "set_pose, set_positions", &mut scene, &bodies);
    scene.set_model(bodies[1], a.clone()).unwrap();
    let pieces = scene.split(bodies[1], |triangle| triangle % 3).unwrap();
    bodies.extend(pieces.iter().map(|piece| piece.body));
    each_verb(named, "set_model, split", &mut scene, &bodies);
    scene.remove(bodies[0]).unwrap();
    each_verb(named, "remove", &mut scene, &bodies);
}

fn each_verb(named: &mut Named, change: &str, scene: &mut SceneQuery, bodies: &[BodyId]) {
    let mut add =
        |verb: &str, answer| named.push((format!("SceneQuery::{verb} after {change}"), answer));
    let number = |two: [BodyId; 2]| two.map(|id| bodies.iter().position(|&own| own == id).unwrap());
    let count = scene.count().unwrap();
    add("count", Answer::Count(count));
    add("any", scene.any().unwrap().into());
    let mut visited = 0;
    assert!(
        scene
            .visit(|_| {
                visited += 1;
                ControlFlow::Continue(())
            })
            .unwrap()
            .is_continue()
    );
    add("visit", Answer::Count(visited));
    let met = scene
        .intersecting_bodies()
        .unwrap()
        .into_iter()
        .map(|two| (number(two), TrianglePair::default()));
    add("intersecting_bodies", Answer::Hits(met.collect()));
    for body in bodies {
        // One of them has been removed, in the end.
        if scene.body(*body).is_ok() {
            let gaps = [scene.distance(*body), scene.distance_below(*body, 1e-40)];
            let gaps = gaps.map(|gap| gap.unwrap().map(|(_, gap)| gap));
            add("distance, distance_below", gaps.to_vec().into());
        }
    }
    // All but the first move, by a subnormal number and more.
    let moved = Pose::from_translation([-0.25, f32::from_bits(1), 0.0]);
    let ends: Vec<_> = scene.bodies().skip(1).map(|body| (body.id(), moved)).collect();
    let impacts = scene.impacts(&ends).unwrap();
    let first = scene.first_impact(&ends).unwrap();
    let without_bodies = impacts.into_iter().chain(first).map(|(hit, impact)| (hit.pair, impact));
    add("impacts, first_impact", Answer::Impacts(without_bodies.collect()));
    add("any_impact", scene.any_impact(&ends).unwrap().into());
    let [proven, all] = scene.count_impacts(&ends).unwrap();
    add("count_impacts", Answer::Count(proven << 32 | all));
    scene.update().unwrap();
    let hits = scene.all().unwrap().iter().map(|hit| (number(hit.bodies), hit.pair));
    add("all", Answer::Hits(hits.collect()));
    let contacts = scene.contacts().unwrap().iter().map(|&(hit, contact)| (hit.pair, contact));
    add("contacts", Answer::Contacts(contacts.collect()));
    let contacts =
        scene.contacts_f64().unwrap().into_iter().map(|(hit, contact)| (hit.pair, contact));
    add("contacts_f64", Answer::ContactsF64(contacts.collect()));
}

/// The control registers that visitors see, and how often each was called: of pairs, of one model, of a scene, and on threads,
/// whose pool is made here.
pub(crate) fn seen_by_visitors(subjects: &Subjects) -> ([u32; 4], [u32; 4]) {
    let [a, b] = &subjects.models;
    let seen = [0; 4].map(|_| AtomicU32::new(u32::MAX));
    let calls = [0; 4].map(|_| AtomicU32::new(0));
    let visit = |number: usize| {
        // Whichever differs from the first is kept.
        let register = read() & !super::FLAGS;
        if calls[number].fetch_add(1, Relaxed) == 0 || register == super::DEFAULT {
            seen[number].store(register, Relaxed);
        }
        ControlFlow::Continue(())
    };
    let _ = PairQuery::new().visit(a, b, Pose::IDENTITY, |_| visit(0)).unwrap();
    let _ = SelfQuery::new().visit(a, |_| visit(1)).unwrap();
    let mut scene = SceneQuery::new();
    for model in [a, b] {
        scene.add(model.clone(), Pose::IDENTITY).unwrap();
    }
    let _ = scene.visit(|_| visit(2)).unwrap();
    let pool = threads::rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let pair = AnyPose::F32(Pose::IDENTITY).pair([a.bvh(), b.bvh()]).unwrap();
    let mut traversal = Traversal::new(&Pool::from(Arc::new(pool)));
    let _ = traversal.visit(&[pair], |_| visit(3)).unwrap();
    (seen.map(AtomicU32::into_inner), calls.map(AtomicU32::into_inner))
}

pub(crate) fn panics_in_a_visitor(subjects: &Subjects) -> bool {
    let [a, b] = &subjects.models;
    let visit = AssertUnwindSafe(|| {
        let _ = PairQuery::new().visit(a, b, Pose::IDENTITY, |_| resume_unwind(Box::new(0)));
    });
    catch_unwind(visit).is_err()
}
