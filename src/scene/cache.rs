//! Answers that outlive their frame: two bodies that have not changed are not asked again.

use super::bodies::{Bodies, BodyId};
use super::{Contact, SceneHit};

/// An answer about two bodies.
pub(super) trait OfTwo: Copy {
    fn bodies(&self) -> [BodyId; 2];
}

impl OfTwo for SceneHit {
    fn bodies(&self) -> [BodyId; 2] {
        self.bodies
    }
}

impl OfTwo for (SceneHit, Contact) {
    fn bodies(&self) -> [BodyId; 2] {
        self.0.bodies
    }
}

/// A list in order of bodies, and when it was complete.
#[derive(Clone, Debug)]
pub(super) struct Cache<T> {
    list: Vec<T>,
    at: u64,
    /// Memory for the next list: empty.
    next: Vec<T>,
}

impl<T> Default for Cache<T> {
    fn default() -> Self {
        Self { list: Vec::new(), at: 0, next: Vec::new() }
    }
}

impl<T: OfTwo> Cache<T> {
    /// The time at which the list was complete; 0 if it never was.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    pub(super) fn list(&self) -> &[T] {
        &self.list
    }

    pub(super) fn forget(&mut self) {
        self.list.clear();
        self.at = 0;
    }

    /// Answers about bodies that are there and have not changed since, a piece for each two.
    pub(super) fn still_true(&self, bodies: &Bodies) -> impl Iterator<Item = &[T]> {
        let pieces = self.list.chunk_by(|x, y| x.bodies() == y.bodies());
        pieces.filter(|piece| bodies.changed(piece[0].bodies()) <= self.at)
    }

    /// Adds what is said of all others, likewise in order, as of now. Whole pieces are copied into another
    /// list, which takes half the time of closing gaps and opening others in place. Where every body has changed, `new` is the
    /// list, and is replaced by memory for another.
    pub(super) fn complete(&mut self, new: &mut Vec<T>, bodies: &Bodies) {
        if self.at == bodies.time() {
            return;
        }
        if bodies.all_changed_since(self.at) {
            std::mem::swap(&mut self.list, new);
            new.clear();
            new.reserve(self.list.len());
            self.next.reserve(self.list.len());
            self.at = bodies.time();
            return;
        }
        let mut rest = new.as_slice();
        let mut next = std::mem::take(&mut self.next);
        for piece in self.still_true(bodies) {
            let before = |said: &&T| said.bodies() < piece[0].bodies();
            let (first, others) = rest.split_at(rest.iter().take_while(before).count());
            next.extend_from_slice(first);
            next.extend_from_slice(piece);
            rest = others;
        }
        next.extend_from_slice(rest);
        self.next = std::mem::replace(&mut self.list, next);
        // The next list is the other one, whose turn comes later.
        self.next.clear();
        self.next.reserve(self.list.len());
        self.at = bodies.time();
    }
}

/// Merges two ascending lists without a third, from their ends. Equal keys are not in both.
pub(super) fn merge<T: Copy, K: Ord>(list: &mut Vec<T>, rest: &[T], key: impl Fn(&T) -> K) {
    let mut left = list.len();
    list.extend_from_slice(rest);
    for (waiting, last) in rest.iter().enumerate().rev() {
        while left > 0 && key(&list[left - 1]) > key(last) {
            left -= 1;
            list[left + waiting + 1] = list[left];
        }
        list[left + waiting] = *last;
    }
}

#[cfg(test)]
mod tests {
    use super::merge;

    #[test]
    fn merging_sorts() {
        for mask in 0..1 << 10_u32 {
            let (mut list, rest): (Vec<u32>, Vec<u32>) = (0..10).partition(|i| mask >> i & 1 == 0);
            merge(&mut list, &rest, |x| *x);
            assert!(list.into_iter().eq(0..10));
        }
    }
}
