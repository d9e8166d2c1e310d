//! Traversals on the calling thread that a flag ends early.

use pfront_core::bvtt::Query;
use pfront_core::bvtt::TrianglePair;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Tests between two looks at the flag: about 0.1 ms.
const SLICE: u64 = 4096;

/// [`Query::visit`] from the start, which also ends once the flag is set.
pub(crate) fn visit(
    query: &impl Query,
    flag: Option<&AtomicBool>,
    mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut cursor = query.start();
    let Some(flag) = flag else { return query.visit(&mut cursor, visit) };
    while !cursor.is_done() && !flag.load(Relaxed) {
        query.step(&mut cursor, SLICE, &mut visit)?;
    }
    ControlFlow::Continue(())
}
