//! Answers that outlive their frame: two bodies that have not changed are not asked again.

use super::bodies::Bodies;
use super::hit::SceneHit;
use super::id::BodyId;
use crate::executor::{BLOCK, check};
use crate::memory::{extend, reserve};
use crate::{Contact, Error};
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, OnceLock, PoisonError};

/// An answer about two bodies.
pub(super) trait WithBodies: Copy {
    fn bodies(&self) -> [BodyId; 2];
}

impl WithBodies for SceneHit {
    fn bodies(&self) -> [BodyId; 2] {
        self.bodies
    }
}

impl WithBodies for (SceneHit, Contact) {
    fn bodies(&self) -> [BodyId; 2] {
        self.0.bodies
    }
}

/// A list in order of bodies, and when it was complete.
#[derive(Debug)]
pub(super) struct Cache<T> {
    list: Vec<T>,
    at: u64,
    /// Memory for the next list, or for `alive`: empty, with room for `list`.
    next: Mutex<Vec<T>>,
    /// The rest of `list` where bodies or their meshes have gone since; made when somebody looks.
    alive: OnceLock<Vec<T>>,
}

impl<T> Default for Cache<T> {
    fn default() -> Self {
        Self { list: Vec::new(), at: 0, next: Mutex::default(), alive: OnceLock::new() }
    }
}

impl<T: Clone> Clone for Cache<T> {
    fn clone(&self) -> Self {
        let next = Mutex::new(Vec::with_capacity(self.list.len()));
        Self { list: self.list.clone(), at: self.at, next, alive: self.alive.clone() }
    }
}

impl<T: WithBodies> Cache<T> {
    /// The time at which the list was complete; 0 if it never was.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// The list, without what tells of bodies or meshes that have gone.
    pub(super) fn list(&self, bodies: &Bodies) -> &[T] {
        if bodies.lost() <= self.at {
            return &self.list;
        }
        self.alive.get_or_init(|| {
            let mut alive =
                std::mem::take(&mut *self.next.lock().unwrap_or_else(PoisonError::into_inner));
            for piece in self.list.chunk_by(|x, y| x.bodies() == y.bodies()) {
                if bodies.have_stayed(piece[0].bodies(), self.at) {
                    alive.extend_from_slice(piece);
                }
            }
            alive
        })
    }

    /// To be called before a body or its mesh goes: then [`Cache::list`] has the memory that it needs.
    pub(super) fn before_loss(&mut self) -> Result<(), Error> {
        self.drop_lost();
        let len = self.list.len();
        reserve(self.next(), len)
    }

    /// Answers about bodies that are there and have not changed since, a piece for each two.
    pub(super) fn still_true(&self, bodies: &Bodies) -> impl Iterator<Item = &[T]> {
        let pieces = self.list.chunk_by(|x, y| x.bodies() == y.bodies());
        pieces.filter(|piece| bodies.changed(piece[0].bodies()) <= self.at)
    }

    /// Adds what is said of all others, likewise in order, as of now. Whole pieces are copied into another
    /// list, which takes half the time of closing gaps and opening others in place. Where every body has changed, `new` is the
    /// list, and is replaced by memory for another. On error nothing changes.
    pub(super) fn complete(
        &mut self,
        new: &mut Vec<T>,
        bodies: &Bodies,
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Error> {
        self.drop_lost();
        if bodies.all_changed_since(self.at) {
            reserve(self.next(), new.len())?;
            std::mem::swap(&mut self.list, new);
            new.clear();
            // Memory that is missing later is told of then.
            let _ = reserve(new, self.list.len());
            self.at = bodies.time();
            return Ok(());
        }
        let mut next = std::mem::take(self.next());
        let merged = self.merged(new, bodies, cancel, &mut next);
        if merged.is_ok() {
            std::mem::swap(&mut self.list, &mut next);
            self.at = bodies.time();
        }
        next.clear();
        // The next list is the other one, whose turn comes later.
        let _ = reserve(&mut next, self.list.len());
        *self.next() = next;
        merged
    }

    /// Fills `next` with what is still true and what is new.
    fn merged(
        &self,
        new: &[T],
        bodies: &Bodies,
        cancel: Option<&AtomicBool>,
        next: &mut Vec<T>,
    ) -> Result<(), Error> {
        let mut rest = new;
        let mut copy = |piece: &[T]| -> Result<(), Error> {
            reserve(next, piece.len())?;
            for block in piece.chunks(BLOCK) {
                check(cancel)?;
                next.extend_from_slice(block);
            }
            Ok(())
        };
        for piece in self.still_true(bodies) {
            let before = |said: &&T| said.bodies() < piece[0].bodies();
            let (first, others) = rest.split_at(rest.iter().take_while(before).count());
            copy(first)?;
            copy(piece)?;
            rest = others;
        }
        copy(rest)
    }

    /// Makes the list that of what has stayed, if it is known.
    fn drop_lost(&mut self) {
        if let Some(alive) = self.alive.take() {
            let mut all = std::mem::replace(&mut self.list, alive);
            all.clear();
            *self.next() = all;
        }
    }

    fn next(&mut self) -> &mut Vec<T> {
        self.next.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Merges two ascending lists without a third, from their ends. Equal keys are not in both.
pub(super) fn merge<T: Copy + Ord>(list: &mut Vec<T>, rest: &[T]) -> Result<(), Error> {
    let mut left = list.len();
    extend(list, rest.iter().copied())?;
    for (waiting, last) in rest.iter().enumerate().rev() {
        while left > 0 && list[left - 1] > *last {
            left -= 1;
            list[left + waiting + 1] = list[left];
        }
        list[left + waiting] = *last;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::merge;

    #[test]
    fn merging_sorts() {
        for mask in 0..1 << 10_u32 {
            let (mut list, rest): (Vec<u32>, Vec<u32>) = (0..10).partition(|i| mask >> i & 1 == 0);
            merge(&mut list, &rest).unwrap();
            assert!(list.into_iter().eq(0..10));
        }
    }
}
