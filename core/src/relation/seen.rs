//! The evidence about two solids.

use super::Relation;
use crate::bvtt::TrianglePair;

/// Points in both solids, only in the first, only in the second: all that decides a relation.
pub(super) const BOTH: u8 = 1;
pub(super) const ONLY_A: u8 = 2;
pub(super) const ONLY_B: u8 = 4;
const CROSSING: u8 = BOTH | ONLY_A | ONLY_B;

/// The number of words that [`Seen`] takes: a bit for each patch of both solids.
#[must_use]
pub const fn seen_bound(patches: usize) -> usize {
    patches.div_ceil(32)
}

/// The evidence about two solids so far: which classes of points occur, whether the surfaces meet, and which patches meet the other
/// along a line. The evidence of several workers is joined, in any order.
#[derive(Debug)]
pub struct Seen<'s> {
    pub(super) classes: u8,
    pub(super) meets: bool,
    /// A pair that shows the relation, so far.
    pub(super) pair: Option<TrianglePair>,
    /// The lowest pair with a marked triangle.
    pub(super) undetermined: Option<TrianglePair>,
    /// Whether a pair has been passed over that only a solid of the posed mesh decides.
    pub(super) is_rounded: bool,
    pub(super) lines: &'s mut [u32],
}

impl Seen<'_> {
    /// Adds what another worker has seen of the same solids.
    pub fn join(&mut self, other: &Seen<'_>) {
        let lower = |p: Option<TrianglePair>, q: Option<TrianglePair>| match (p, q) {
            (Some(p), Some(q)) => Some(p.min(q)),
            (p, q) => p.or(q),
        };
        self.pair = match (self.is_crossing(), other.is_crossing()) {
            (true, false) => self.pair,
            (false, true) => other.pair,
            _ => lower(self.pair, other.pair),
        };
        self.classes |= other.classes;
        self.meets |= other.meets;
        self.is_rounded |= other.is_rounded;
        self.undetermined = lower(self.undetermined, other.undetermined);
        self.lines.iter_mut().zip(&*other.lines).for_each(|(own, other)| *own |= other);
    }

    /// Whether the solids cross, so that nothing more need be seen.
    #[must_use]
    pub fn is_crossing(&self) -> bool {
        self.classes == CROSSING
    }

    pub(super) fn is_on_line(&self, patch: u32) -> bool {
        self.lines[patch as usize / 32] >> (patch % 32) & 1 != 0
    }
}

/// The relation of solids of which points of these classes occur.
pub(super) fn relation_of(classes: u8, meets: bool) -> Relation {
    match (classes & BOTH != 0, classes & ONLY_A != 0, classes & ONLY_B != 0) {
        (false, ..) if meets => Relation::Touching,
        (false, ..) => Relation::Apart,
        (true, true, true) => Relation::Crossing,
        (true, true, false) => Relation::BInA,
        (true, false, true) => Relation::AInB,
        (true, false, false) => Relation::Equal,
    }
}
