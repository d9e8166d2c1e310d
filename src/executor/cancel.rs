//! Traversals and sorting on the calling thread that a flag ends early.

use crate::Error;
use crate::memory::reserve;
use pfront_core::bvtt::Query;
use pfront_core::bvtt::TrianglePair;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Tests between two looks at whether a question is cancelled: about 0.1 ms.
pub(crate) const SLICE: u64 = 4096;

/// Items between two looks at the flag where they are copied, counted or sorted: at most some 5 ms.
pub(crate) const BLOCK: usize = 1 << 16;

/// Does nothing unless the flag is set.
///
/// # Errors
/// [`Error::Cancelled`] if it is.
pub(crate) fn check(flag: Option<&AtomicBool>) -> Result<(), Error> {
    match flag {
        Some(flag) if flag.load(Relaxed) => Err(Error::Cancelled),
        _ => Ok(()),
    }
}

/// [`Query::visit`] from the start.
///
/// # Errors
/// [`Error::Cancelled`] once the flag is set, if the traversal was not over.
pub(crate) fn visit(
    query: &impl Query,
    flag: Option<&AtomicBool>,
    mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
) -> Result<(), Error> {
    let mut cursor = query.start();
    let Some(flag) = flag else {
        let _ = query.visit(&mut cursor, visit);
        return Ok(());
    };
    while !cursor.is_done() {
        check(Some(flag))?;
        if query.step(&mut cursor, SLICE, &mut visit).is_break() {
            break;
        }
    }
    Ok(())
}

/// Sorts a list. Long ones are sorted in blocks, which are then merged, two at a time.
///
/// # Errors
/// [`Error::Cancelled`] once the flag is set, [`Error::Memory`] if there is none for a copy of a long list; the items are then in
/// any order.
pub(crate) fn sort<T: Copy + Ord>(list: &mut [T], flag: Option<&AtomicBool>) -> Result<(), Error> {
    if flag.is_none() || list.len() <= BLOCK {
        list.sort_unstable();
        return Ok(());
    }
    for block in list.chunks_mut(BLOCK) {
        check(flag)?;
        block.sort_unstable();
    }
    let mut merged = Vec::new();
    reserve(&mut merged, list.len())?;
    let mut width = BLOCK;
    while width < list.len() {
        merged.clear();
        for two in list.chunks(2 * width) {
            let (mut left, mut right) = two.split_at(width.min(two.len()));
            while let (Some(first), Some(second)) = (left.first(), right.first()) {
                if merged.len() % BLOCK == 0 {
                    check(flag)?;
                }
                let from = if first <= second { &mut left } else { &mut right };
                merged.push(from[0]);
                *from = &from[1..];
            }
            merged.extend_from_slice(left);
            merged.extend_from_slice(right);
        }
        check(flag)?;
        list.copy_from_slice(&merged);
        width *= 2;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::rng::{RngExt, seeded};

    #[test]
    fn blocks_are_sorted_and_merged() {
        let mut rng = seeded(1);
        let flag = AtomicBool::new(false);
        for len in [0, 1, BLOCK, BLOCK + 1, 2 * BLOCK, 3 * BLOCK - 7, 5 * BLOCK + 3] {
            let mut list: Vec<u32> = (0..len).map(|_| rng.random_range(0..1 << 16)).collect();
            let mut expected = list.clone();
            expected.sort_unstable();
            assert_eq!(sort(&mut list, Some(&flag)), Ok(()));
            assert!(list == expected, "{len}");
        }
        flag.store(true, Relaxed);
        assert_eq!(sort(&mut vec![0; 2 * BLOCK], Some(&flag)), Err(Error::Cancelled));
    }
}
