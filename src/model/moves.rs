//! The vertices that have moved, as long as these are few.

use crate::memory::reserve;
use pfront_core::bvh::{Moved, mark_moved};

/// Vertices that have moved since the tree fitted. Too many are never wrong, only slower.
#[derive(Clone, Debug, Default)]
pub(super) struct Moves {
    marks: Vec<Moved>,
    many: bool,
}

/// Vertices are many when so many of them, or of the words that their marks fill, are not.
///
/// Measured on a sheet of 92,000 triangles, and on a sheet and a sphere of a million: where those that have
/// moved lie together, a quarter of the words are those of a fifth of the vertices, for which a partial
/// refit takes 0.4 to 0.6 of the time of a whole one; where they are scattered, those of a hundredth, for
/// which it takes 0.9. The same holds for certificates.
pub(super) const MANY: usize = 4;

/// How many vertices are compared before all are.
const SAMPLE: usize = 64;

impl Moves {
    /// Adds what differs between two lists of positions.
    pub(super) fn add(&mut self, before: &[[f32; 3]], after: &[[f32; 3]]) {
        self.many = self.many || many_differ(before, after);
        if !self.many {
            let words = after.len().div_ceil(32);
            let more = words.saturating_sub(self.marks.len());
            if reserve(&mut self.marks, more).is_err() {
                return self.add_all();
            }
            self.marks.resize(words, Moved::default());
            let words = mark_moved(before, after, &mut self.marks);
            self.many = words.is_ok_and(|words| words > self.marks.len() / MANY);
        }
    }

    /// Takes all vertices for moved.
    pub(super) fn add_all(&mut self) {
        self.many = true;
    }

    /// Makes room to mark so many vertices.
    pub(super) fn reserve(&mut self, vertices: usize) {
        // Without it, all vertices count as moved.
        let _ = self.marks.try_reserve(vertices.div_ceil(32) - self.marks.len());
    }

    pub(super) fn clear(&mut self) {
        self.marks.clear();
        self.many = false;
    }

    /// `None` if many have moved.
    pub(super) fn few(&self) -> Option<&[Moved]> {
        (!self.many).then_some(&self.marks)
    }

    pub(super) fn bytes(&self) -> usize {
        self.marks.capacity() * size_of::<Moved>()
    }
}

/// Whether many of some vertices at equal distances have moved: with most meshes that deform, all have.
fn many_differ(before: &[[f32; 3]], after: &[[f32; 3]]) -> bool {
    let step = before.len().div_ceil(SAMPLE).max(1);
    let pairs = || before.iter().zip(after).step_by(step);
    pairs().filter(|(p, q)| !same_bits(&[**p], &[**q])).count() > pairs().count() / MANY
}

/// Whether the same numbers are in both, zeros with their signs.
pub(super) fn same_bits(a: &[[f32; 3]], b: &[[f32; 3]]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    // Chunks without a branch compile to vector instructions.
    let mut chunks = a.as_flattened().chunks(64).zip(b.as_flattened().chunks(64));
    chunks.all(|(a, b)| a.iter().zip(b).fold(0, |x, (a, b)| x | (a.to_bits() ^ b.to_bits())) == 0)
}
