//! Sets of vertices that tell in constant time whether they hold any vertex of a range.
//!
//! A set has one bit per vertex, and beside each word of 32 bits the number of set bits in the words before. A range over
//! more than two words is empty if these numbers do not differ between its ends.

use crate::CapacityError;
use bytemuck::{Pod, Zeroable};

/// The number of vertices in a word.
const SHARE: usize = u32::BITS as usize;

/// One word of a set of vertices: which of 32 have moved. [`mark_moved`] fills an array of these.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Moved {
    bits: u32,
    /// The number of vertices in the words before that have moved.
    before: u32,
}

/// Returns the number of words in a set of so many vertices.
pub(crate) const fn moved_bound(vertices: usize) -> usize {
    vertices.div_ceil(SHARE)
}

/// Adds to a set the vertices whose positions differ in any bit; returns how many of its words are not
/// empty then.
///
/// Default words make an empty set; a word is for 32 vertices. `before` and `after` hold as many positions.
///
/// # Errors
/// [`CapacityError`] if `moved` is too short.
///
/// # Complexity
/// O(vertices).
///
/// # Examples
/// ```
/// use pfront_core::bvh::{Moved, mark_moved};
/// let mut moved = [Moved::default(); 2];
/// assert_eq!(mark_moved(&[[0.0; 3]; 40], &[[0.0; 3]; 40], &mut moved)?, 0);
/// assert_eq!(mark_moved(&[[0.0; 3]; 40], &[[-0.0; 3]; 40], &mut moved)?, 2);
/// # Ok::<(), pfront_core::CapacityError>(())
/// ```
pub fn mark_moved(
    before: &[[f32; 3]],
    after: &[[f32; 3]],
    moved: &mut [Moved],
) -> Result<usize, CapacityError> {
    CapacityError::check("moved", moved_bound(after.len()), moved.len())?;
    for ((before, after), word) in before.chunks(SHARE).zip(after.chunks(SHARE)).zip(&mut *moved) {
        let flat = before.as_flattened().iter().zip(after.as_flattened());
        if flat.fold(0, |bits, (x, y)| bits | (x.to_bits() ^ y.to_bits())) == 0 {
            continue;
        }
        for (bit, (p, q)) in before.iter().zip(after).enumerate() {
            let differing = (0..3).fold(0, |bits, k| bits | (p[k].to_bits() ^ q[k].to_bits()));
            word.bits |= u32::from(differing != 0) << bit;
        }
    }
    number(moved);
    Ok(moved.iter().filter(|word| word.bits != 0).count())
}

/// Counts the vertices before each word anew.
fn number(set: &mut [Moved]) {
    let mut count = 0;
    for word in set {
        word.before = count;
        count += word.bits.count_ones();
    }
}

/// Whether the set holds any vertex from the first to the last.
#[inline(always)]
pub(crate) fn holds_any(set: &[Moved], [first, last]: [u32; 2]) -> bool {
    let [low, high] = [first, last].map(|vertex| &set[(vertex / SHARE as u32) as usize]);
    let from_first = !0 << (first as usize % SHARE);
    let to_last = !0 >> (SHARE - 1 - last as usize % SHARE);
    if first as usize / SHARE == last as usize / SHARE {
        return low.bits & from_first & to_last != 0;
    }
    low.bits & from_first != 0
        || high.bits & to_last != 0
        || high.before != low.before + low.bits.count_ones()
}
