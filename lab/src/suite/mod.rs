//! One named suite of triangle pairs with their truth.
//!
//! A set is made of one [`Family`] of hard pairs, or harvested from real [`Contacts`]: pairs of posed
//! meshes whose boxes overlap, which is what a query tests. Truth is by `pfront_testkit::oracle`, in big integers,
//! which shares no code with the predicates.
//!
//! A set is an endless stream of blocks of [`BLOCK`] pairs. A block follows from the seed, the name of the
//! set, its number and its length alone, so blocks come in parallel, on demand, and the same on every
//! machine; a suite of 10^8 pairs takes no memory.

mod contacts;

pub use contacts::Contacts;

use anyhow::Result;
use pfront::pfront_core::Triangle;
use pfront_testkit::oracle::intersect;
use pfront_testkit::rng::seeded;
use pfront_testkit::{checksum, families::Family};
use rayon::prelude::*;

/// Pairs of a block; the last one of a set may have fewer.
pub const BLOCK: usize = 4096;

/// A triangle pair and its truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case<T = Triangle> {
    /// One triangle.
    pub a: T,
    /// The other.
    pub b: T,
    /// Whether they share a point, as closed sets.
    pub meets: bool,
}

/// Some pairs of one set.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The number of the set.
    pub set: usize,
    /// The pairs.
    pub cases: Vec<Case>,
}

/// One set of a suite.
#[derive(Clone, Debug)]
pub enum Set {
    /// Pairs that are made to be hard.
    Family(Family),
    /// Pairs from the contacts of a scene.
    Contacts(Contacts),
}

impl Set {
    /// The name.
    pub fn name(&self) -> String {
        match self {
            Self::Family(family) => family.name(),
            Self::Contacts(contacts) => contacts.name.to_owned(),
        }
    }
}

/// The sets, and the seed of all that is random in them.
///
/// # Examples
/// ```
/// use pfront_lab::suite::Suite;
/// let suite = Suite::of_families(7);
/// let wave = suite.waves(290).next().unwrap();
/// assert_eq!((suite.sets.len(), wave[0].cases.len()), (29, 10));
/// ```
#[derive(Clone, Debug)]
pub struct Suite {
    seed: u64,
    /// The sets, in their order.
    pub sets: Vec<Set>,
}

impl Suite {
    /// A set for each [`Family`].
    pub fn of_families(seed: u64) -> Self {
        Self { seed, sets: Family::ALL.map(Set::Family).into() }
    }

    /// [`Suite::of_families`], and the contacts of the generated scenes: worm drive, swarm, torus
    /// knots and folded sheet, in about `size` triangles each or as many as is usual.
    ///
    /// # Errors
    /// If a scene is too coarse for its bodies to come near each other.
    pub fn generated(seed: u64, size: Option<usize>) -> Result<Self> {
        let mut suite = Self::of_families(seed);
        suite.sets.extend(contacts::all(size)?.into_iter().map(Set::Contacts));
        Ok(suite)
    }

    /// How many of `pairs` each set gets: equally many, the first ones one more if they must.
    pub fn shares(&self, pairs: u64) -> Vec<u64> {
        let sets = self.sets.len() as u64;
        (0..sets).map(|set| pairs / sets + u64::from(set < pairs % sets)).collect()
    }

    /// All blocks of a suite of so many pairs, in order, a wave at a time: as many as keep the rayon pool of
    /// the caller busy, which makes them.
    pub fn waves(&self, pairs: u64) -> impl Iterator<Item = Vec<Block>> {
        let mut plan = self.shares(pairs).into_iter().enumerate().flat_map(|(set, share)| {
            let blocks = share.div_ceil(BLOCK as u64);
            let length =
                move |block: u64| (share - block * BLOCK as u64).min(BLOCK as u64) as usize;
            (0..blocks).map(move |block| (set, block, length(block)))
        });
        let most = 8 * rayon::current_num_threads();
        std::iter::from_fn(move || {
            let wave: Vec<_> = plan.by_ref().take(most).collect();
            let block = |(set, block, length)| Block { set, cases: self.block(set, block, length) };
            (!wave.is_empty()).then(|| wave.into_par_iter().map(block).collect())
        })
    }

    /// A block of `length` pairs, [`BLOCK`] at most.
    ///
    /// # Panics
    /// If there is no such set.
    pub fn block(&self, set: usize, block: u64, length: usize) -> Vec<Case> {
        let set = &self.sets[set];
        let mut rng = seeded(self.seed ^ checksum(set.name().bytes()));
        rng.set_stream(block);
        let pairs: Vec<_> = match set {
            Set::Family(family) => (0..length.min(BLOCK)).map(|_| family.pair(&mut rng)).collect(),
            Set::Contacts(contacts) => contacts.harvest(block, length.min(BLOCK), &mut rng),
        };
        pairs.into_iter().map(|(a, b)| Case { a, b, meets: intersect(&a, &b) }).collect()
    }
}
