//! Traversals on the calling thread that a flag ends early.

use crate::Error;
use crate::memory::push;
use pfront_core::bvtt::Query;
use pfront_core::bvtt::TrianglePair;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Tests between two looks at the flag: about 0.1 ms.
const SLICE: u64 = 4096;

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
        if flag.load(Relaxed) {
            return Err(Error::Cancelled);
        }
        if query.step(&mut cursor, SLICE, &mut visit).is_break() {
            break;
        }
    }
    Ok(())
}

/// Adds what `item` makes of each intersecting pair to a list.
///
/// # Errors
/// As [`visit`]; [`Error::Memory`] if the list cannot grow, which then is empty and holds no memory.
pub(crate) fn list<T>(
    query: &impl Query,
    flag: Option<&AtomicBool>,
    items: &mut Vec<T>,
    item: impl Fn(TrianglePair) -> T,
) -> Result<(), Error> {
    let mut pushed = Ok(());
    visit(query, flag, |pair| {
        pushed = push(items, item(pair));
        if pushed.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    })?;
    if pushed.is_err() {
        *items = Vec::new();
    }
    pushed
}
