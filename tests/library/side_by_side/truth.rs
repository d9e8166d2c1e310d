//! The answers of fresh sequential queries about fresh models, kept as long as nothing changes.

use super::models::{Fresh, Points};
use pfront::{
    Adjacency, AnyPose, Contact, Model, PairQuery, Pose, Pose64, SelfQuery, TrianglePair,
};
use std::cell::OnceCell;
use std::collections::HashMap;
use std::rc::Rc;

/// Hits, with where they are.
pub(crate) type Contacts<H, T = f32> = Vec<(H, Contact<T>)>;

/// Answers that are kept at a time.
const KEPT: usize = 1 << 12;

enum Subject {
    Pair([Rc<Fresh>; 2], AnyPose),
    Itself(Rc<Fresh>, Adjacency),
}

/// The answer about one subject; contacts are found when they are first needed.
pub(crate) struct Answer {
    subject: Subject,
    pub(crate) pairs: Vec<TrianglePair>,
    contacts: OnceCell<Contacts<TrianglePair>>,
    contacts_f64: OnceCell<Contacts<TrianglePair, f64>>,
}

impl Answer {
    fn new(subject: Subject) -> Self {
        let pairs = match &subject {
            Subject::Pair([a, b], pose) => {
                PairQuery::new().all(&a.model, &b.model, pose).unwrap().to_vec()
            }
            Subject::Itself(a, adjacency) => within(*adjacency).all(&a.model).unwrap().to_vec(),
        };
        Self { subject, pairs, contacts: OnceCell::new(), contacts_f64: OnceCell::new() }
    }

    fn contacts(&self) -> &[(TrianglePair, Contact)] {
        self.contacts.get_or_init(|| match &self.subject {
            Subject::Pair([a, b], pose) => {
                PairQuery::new().contacts(&a.model, &b.model, pose).unwrap().to_vec()
            }
            Subject::Itself(a, adjacency) => {
                within(*adjacency).contacts(&a.model).unwrap().to_vec()
            }
        })
    }

    /// The contacts of a mesh and itself, posed in f64.
    fn posed_contacts(&self, pose: &Pose64) -> Contacts<TrianglePair, f64> {
        let Subject::Itself(a, adjacency) = &self.subject else { unreachable!("of two meshes") };
        let posed = |pose: &Pose64| match a.points.posed(&AnyPose::F64(*pose), true) {
            Points::F64(points) => points,
            Points::F32(_) => unreachable!("asked for in f64"),
        };
        let (points, triangles) = (posed(pose), a.model.mesh().triangles());
        let model = Model::from_f64(posed(&Pose64::IDENTITY), triangles.to_vec()).unwrap();
        let mut found = within(*adjacency).contacts_f64(&model).unwrap();
        for (pair, contact) in &mut found {
            contact.segment = contact.segment.map(|p| pose.apply(p));
            let corners = [pair.a, pair.b].map(|t| triangles[t as usize]);
            contact.normals = corners.map(|t| normal(t.map(|vertex| points[vertex as usize])));
        }
        found
    }

    fn contacts_f64(&self) -> &[(TrianglePair, Contact<f64>)] {
        self.contacts_f64.get_or_init(|| match &self.subject {
            Subject::Pair([a, b], pose) => {
                PairQuery::new().contacts_f64(&a.model, &b.model, pose).unwrap()
            }
            Subject::Itself(a, adjacency) => within(*adjacency).contacts_f64(&a.model).unwrap(),
        })
    }
}

/// The normal of a triangle, as that of any contact with itself.
fn normal(corners: [[f64; 3]; 3]) -> [f32; 3] {
    let alone = Model::from_f64(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
    let found = PairQuery::new().contacts_f64(&alone, &alone, Pose::IDENTITY).unwrap();
    found[0].1.normals[0]
}

fn within(adjacency: Adjacency) -> SelfQuery {
    SelfQuery::new().with_adjacency(adjacency)
}

type Key = ([u64; 2], bool, [u64; 12]);

fn bits(pose: &AnyPose) -> [u64; 12] {
    let of = |k: usize| match pose {
        AnyPose::F32(pose) => pose.rows[k / 4][k % 4].to_bits().into(),
        AnyPose::F64(pose) => pose.rows[k / 4][k % 4].to_bits(),
    };
    std::array::from_fn(of)
}

/// The last answers.
#[derive(Default)]
pub(crate) struct Answers {
    kept: HashMap<Key, Rc<Answer>>,
}

impl Answers {
    pub(crate) fn pair(&mut self, [a, b]: [&Rc<Fresh>; 2], pose: &AnyPose) -> Rc<Answer> {
        let key = ([a.number, b.number], pose.is_f64(), bits(pose));
        self.get(key, || Subject::Pair([a, b].map(Rc::clone), *pose))
    }

    pub(crate) fn within(&mut self, a: &Rc<Fresh>, adjacency: Adjacency) -> Rc<Answer> {
        // A number that no other model has.
        let other = u64::MAX - u64::from(adjacency == Adjacency::SkipNeighbours);
        let key = ([a.number, other], false, bits(&Pose::IDENTITY.into()));
        self.get(key, || Subject::Itself(a.clone(), adjacency))
    }

    fn get(&mut self, key: Key, subject: impl FnOnce() -> Subject) -> Rc<Answer> {
        if self.kept.len() >= KEPT {
            self.kept.clear();
        }
        self.kept.entry(key).or_insert_with(|| Rc::new(Answer::new(subject()))).clone()
    }
}

/// The right answer to a query; contacts only where these are asked for.
pub(crate) struct Truth<H> {
    pub(crate) hits: Vec<H>,
    pub(crate) contacts: Contacts<H>,
    pub(crate) contacts_f64: Contacts<H, f64>,
}

impl<H> Default for Truth<H> {
    fn default() -> Self {
        Self { hits: Vec::new(), contacts: Vec::new(), contacts_f64: Vec::new() }
    }
}

impl<H> Truth<H> {
    /// The same about a mesh and itself, whose contacts are posed.
    pub(crate) fn add_posed(
        &mut self,
        answer: &Answer,
        verb: Verb,
        pose: &AnyPose,
        named: impl Fn(TrianglePair) -> H,
    ) {
        self.hits.extend(answer.pairs.iter().map(|&pair| named(pair)));
        let contacts = |()| {
            let contacts = answer.posed_contacts(&pose.to_f64());
            contacts.into_iter().map(|(pair, contact)| (named(pair), contact))
        };
        match verb {
            Verb::Contacts => {
                self.contacts.extend(contacts(()).map(|(hit, contact)| (hit, contact.into())));
            }
            Verb::ContactsF64 => self.contacts_f64.extend(contacts(())),
            _ => {}
        }
    }

    /// Adds the answer about one subject, whose hits have a name.
    pub(crate) fn add(&mut self, answer: &Answer, verb: Verb, named: impl Fn(TrianglePair) -> H) {
        self.hits.extend(answer.pairs.iter().map(|&pair| named(pair)));
        match verb {
            Verb::Contacts => {
                let contacts = answer.contacts().iter();
                self.contacts.extend(contacts.map(|&(pair, contact)| (named(pair), contact)));
            }
            Verb::ContactsF64 => {
                let contacts = answer.contacts_f64().iter();
                self.contacts_f64.extend(contacts.map(|&(pair, contact)| (named(pair), contact)));
            }
            _ => {}
        }
    }
}

/// A question of any query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verb {
    All,
    Any,
    Count,
    Visit,
    Contacts,
    ContactsF64,
    /// Scenes alone have this verb; other queries are asked for all pairs.
    IntersectingBodies,
}

impl Verb {
    pub(crate) const ALL: [Self; 7] = [
        Self::All,
        Self::Any,
        Self::Count,
        Self::Visit,
        Self::Contacts,
        Self::ContactsF64,
        Self::IntersectingBodies,
    ];
}
