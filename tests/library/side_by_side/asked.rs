//! Every verb of every kind of query, compared with the truth.

use super::truth::{Contacts, Truth, Verb};
use pfront::{
    AnyPose, BodyId, Contact, Error, Model, PairQuery, SceneHit, SceneQuery, SelfQuery,
    TrianglePair,
};
use std::fmt::Debug;
use std::ops::ControlFlow;

/// A query, and what it is asked about.
pub(crate) trait Asked {
    type Hit: Copy + Ord + Debug;

    fn all(&mut self) -> Result<&[Self::Hit], Error>;
    fn any(&mut self) -> Result<Option<Self::Hit>, Error>;
    fn count(&mut self) -> Result<u64, Error>;
    fn visit(
        &mut self,
        visit: impl FnMut(Self::Hit) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, Error>;
    fn contacts(&mut self) -> Result<&[(Self::Hit, Contact)], Error>;
    fn contacts_f64(&mut self) -> Result<Contacts<Self::Hit, f64>, Error>;

    /// The bodies of which some should meet.
    fn check_bodies(&mut self, hits: &[Self::Hit]) -> Result<(), Error> {
        assert_eq!(self.all()?, hits);
        Ok(())
    }

    /// Asks, and compares with the truth. A visitor breaks after so many hits.
    fn compare(&mut self, truth: &Truth<Self::Hit>, verb: Verb, most: usize) -> Result<(), Error> {
        let Truth { hits, contacts, contacts_f64 } = truth;
        match verb {
            Verb::All => assert_eq!(self.all()?, hits),
            Verb::Any => {
                let any = self.any()?;
                let is_right = any.map_or(hits.is_empty(), |hit| hits.binary_search(&hit).is_ok());
                assert!(is_right, "{any:?} of {hits:?}");
            }
            Verb::Count => assert_eq!(self.count()?, hits.len() as u64),
            Verb::Visit => {
                let mut visited = Vec::new();
                let end = self.visit(|hit| {
                    visited.push(hit);
                    match visited.len() == most {
                        true => ControlFlow::Break(()),
                        false => ControlFlow::Continue(()),
                    }
                })?;
                visited.sort_unstable();
                assert_eq!(
                    (end.is_break(), visited.len()),
                    (hits.len() >= most, hits.len().min(most))
                );
                assert!(visited.iter().all(|hit| hits.binary_search(hit).is_ok()));
                assert!(visited.windows(2).all(|two| two[0] != two[1]));
            }
            Verb::Contacts => assert_eq!(self.contacts()?, contacts),
            Verb::ContactsF64 => assert_eq!(&self.contacts_f64()?, contacts_f64),
            Verb::IntersectingBodies => self.check_bodies(hits)?,
        }
        Ok(())
    }
}

/// Two models.
pub(crate) struct Between<'q>(
    pub(crate) &'q mut PairQuery,
    pub(crate) [&'q Model; 2],
    pub(crate) AnyPose,
);

/// A model and itself.
pub(crate) struct Within<'q>(pub(crate) &'q mut SelfQuery, pub(crate) &'q Model);

macro_rules! verbs {
    ($hit:ty, |$own:ident| $query:expr, ($($with:expr),*)) => {
        type Hit = $hit;

        fn all(&mut self) -> Result<&[$hit], Error> {
            let $own = self;
            $query.all($($with),*)
        }

        fn any(&mut self) -> Result<Option<$hit>, Error> {
            let $own = self;
            $query.any($($with),*)
        }

        fn count(&mut self) -> Result<u64, Error> {
            let $own = self;
            $query.count($($with),*)
        }

        fn visit(
            &mut self,
            visit: impl FnMut($hit) -> ControlFlow<()>,
        ) -> Result<ControlFlow<()>, Error> {
            let $own = self;
            $query.visit($($with,)* visit)
        }

        fn contacts(&mut self) -> Result<&[($hit, Contact)], Error> {
            let $own = self;
            $query.contacts($($with),*)
        }

        fn contacts_f64(&mut self) -> Result<Contacts<$hit, f64>, Error> {
            let $own = self;
            $query.contacts_f64($($with),*)
        }
    };
}

impl Asked for Between<'_> {
    verbs!(TrianglePair, |own| own.0, (own.1[0], own.1[1], own.2));
}

impl Asked for Within<'_> {
    verbs!(TrianglePair, |own| own.0, (own.1));
}

impl Asked for SceneQuery {
    verbs!(SceneHit, |own| own, ());

    fn check_bodies(&mut self, hits: &[SceneHit]) -> Result<(), Error> {
        let mut pairs: Vec<[BodyId; 2]> = hits.iter().map(|hit| hit.bodies).collect();
        pairs.dedup();
        assert_eq!(self.intersecting_bodies()?, pairs);
        Ok(())
    }
}
