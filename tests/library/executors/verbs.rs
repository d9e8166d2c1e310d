//! All verbs of a query, of whichever kind, against those of another.

use pfront::{Contact, Model, PairQuery, Pose, SceneHit, SceneQuery, SelfQuery, TrianglePair};
use std::fmt::Debug;
use std::ops::ControlFlow;

/// A question to a query.
pub(crate) trait Verbs {
    type Hit: Copy + Ord + Debug;

    fn all(&mut self) -> Vec<Self::Hit>;
    fn any(&mut self) -> Option<Self::Hit>;
    fn count(&mut self) -> u64;
    fn contacts(&mut self) -> Vec<(Self::Hit, Contact)>;
    /// The hits that a visitor sees, sorted.
    fn visited(&mut self) -> Vec<Self::Hit>;
}

/// Two models.
pub(crate) struct Between<'q>(
    pub(crate) &'q mut PairQuery,
    pub(crate) [&'q Model; 2],
    pub(crate) Pose,
);

/// A model and itself.
pub(crate) struct Within<'q>(pub(crate) &'q mut SelfQuery, pub(crate) &'q Model);

impl Verbs for Between<'_> {
    type Hit = TrianglePair;

    fn all(&mut self) -> Vec<TrianglePair> {
        self.0.all(self.1[0], self.1[1], self.2).unwrap().to_vec()
    }

    fn any(&mut self) -> Option<TrianglePair> {
        self.0.any(self.1[0], self.1[1], self.2).unwrap()
    }

    fn count(&mut self) -> u64 {
        self.0.count(self.1[0], self.1[1], self.2).unwrap()
    }

    fn contacts(&mut self) -> Vec<(TrianglePair, Contact)> {
        self.0.contacts(self.1[0], self.1[1], self.2).unwrap().to_vec()
    }

    fn visited(&mut self) -> Vec<TrianglePair> {
        let Self(query, [a, b], pose) = self;
        sorted(|visit| query.visit(a, b, *pose, visit).unwrap())
    }
}

impl Verbs for Within<'_> {
    type Hit = TrianglePair;

    fn all(&mut self) -> Vec<TrianglePair> {
        self.0.all(self.1).unwrap().to_vec()
    }

    fn any(&mut self) -> Option<TrianglePair> {
        self.0.any(self.1).unwrap()
    }

    fn count(&mut self) -> u64 {
        self.0.count(self.1).unwrap()
    }

    fn contacts(&mut self) -> Vec<(TrianglePair, Contact)> {
        self.0.contacts(self.1).unwrap().to_vec()
    }

    fn visited(&mut self) -> Vec<TrianglePair> {
        sorted(|visit| self.0.visit(self.1, visit).unwrap())
    }
}

impl Verbs for SceneQuery {
    type Hit = SceneHit;

    fn all(&mut self) -> Vec<SceneHit> {
        Self::all(self).unwrap().to_vec()
    }

    fn any(&mut self) -> Option<SceneHit> {
        Self::any(self).unwrap()
    }

    fn count(&mut self) -> u64 {
        Self::count(self).unwrap()
    }

    fn contacts(&mut self) -> Vec<(SceneHit, Contact)> {
        Self::contacts(self).unwrap().to_vec()
    }

    fn visited(&mut self) -> Vec<SceneHit> {
        sorted(|visit| self.visit(visit).unwrap())
    }
}

fn sorted<H: Ord>(
    ask: impl FnOnce(&mut dyn FnMut(H) -> ControlFlow<()>) -> ControlFlow<()>,
) -> Vec<H> {
    let mut visited = Vec::new();
    let end = ask(&mut |hit| {
        visited.push(hit);
        ControlFlow::Continue(())
    });
    assert!(end.is_continue());
    visited.sort_unstable();
    visited
}

/// Asks every verb, in an order that begins with another one in each frame, since later ones may be answered by what is kept
/// of earlier ones; then all again. Returns how many pairs meet.
pub(crate) fn check<V: Verbs>(
    own: &mut V,
    truth: &mut impl Verbs<Hit = V::Hit>,
    frame: usize,
    name: &str,
) -> usize {
    let (all, contacts) = (truth.all(), truth.contacts());
    for verb in (0..5).map(|i| (i + frame) % 5).chain(0..5) {
        let what = format!("{name}, frame {frame}, verb {verb}");
        match verb {
            0 => {
                let any = own.any();
                assert!(
                    any.map_or(all.is_empty(), |hit| all.binary_search(&hit).is_ok()),
                    "{what}"
                );
            }
            1 => assert_eq!(own.count(), all.len() as u64, "{what}"),
            2 => assert!(own.all() == all, "{what}: {} pairs, not {}", own.all().len(), all.len()),
            3 => assert!(own.contacts() == contacts, "{what}"),
            _ => assert!(own.visited() == all, "{what}"),
        }
    }
    all.len()
}
