//! The queries of a frame.

use pfront_core::bvtt::{NodePair, Query};

/// The queries that a [`Traversal`](crate::Traversal) asks at once, by their numbers: a list of them, or whatever makes one for each thread that
/// needs it. Making them is a good part of the time of many small queries, and they are most of the memory.
///
/// # Examples
/// ```
/// use pfront_core::{Bvh, Pose, bvtt::PairBvtt};
/// use pfront_cpu::Queries;
/// /// One mesh in many poses about another, which have been checked.
/// struct Course<'m>([Bvh<'m>; 2], Vec<Pose>);
///
/// impl<'m> Queries for Course<'m> {
///     type Query<'q> = PairBvtt<'m> where Self: 'q;
///     fn len(&self) -> usize {
///         self.1.len()
///     }
///     fn query(&self, number: u32) -> PairBvtt<'m> {
///         use pfront_core::bvtt::PosedBvh;
///         let [a, b] = [Pose::IDENTITY, self.1[number as usize]];
///         PairBvtt::in_world(PosedBvh::new_unchecked(self.0[0], &a), PosedBvh::new_unchecked(self.0[1], &b))
///     }
/// }
/// ```
pub trait Queries: Sync {
    /// A query.
    type Query<'q>: Query
    where
        Self: 'q;

    /// How many there are; at most 2^32.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A query, by its number. It is the same each time.
    ///
    /// # Panics
    /// May panic if there is no such number.
    fn query(&self, number: u32) -> Self::Query<'_>;

    /// The node pair at which the traversal of a query begins, if any. It may be a root whose boxes do not overlap, where that takes
    /// much to know: the traversal looks again.
    ///
    /// # Panics
    /// As [`Queries::query`].
    fn root(&self, number: u32) -> Option<NodePair> {
        self.query(number).root()
    }
}

macro_rules! list_of_queries {
    ($list:ty $(, const $n:ident)?) => {
        impl<Q: Query + Sync $(, const $n: usize)?> Queries for $list {
            type Query<'q>
                = &'q Q
            where
                Self: 'q;

            fn len(&self) -> usize {
                <[Q]>::len(self)
            }

            fn query(&self, number: u32) -> &Q {
                &self[number as usize]
            }
        }
    };
}

list_of_queries!([Q]);
list_of_queries!([Q; N], const N);
list_of_queries!(Vec<Q>);
