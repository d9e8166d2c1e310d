//! How much stack a call takes: it is painted before, and what paint is gone is read afterwards, through Linux's
//! `/proc/self/mem`, since Rust has no safe way to look below its own frame.

use std::fs::File;
use std::hint::black_box;
use std::os::unix::fs::FileExt;
use std::thread;

/// How much is painted. No call may take more.
const PAINTED: usize = 1 << 20;
const PAINT: u8 = 0xa5;

/// Bytes of stack that a call took, in a thread of its own.
pub(crate) fn stack_of(call: impl FnOnce() + Send) -> usize {
    thread::scope(|scope| {
        let builder = thread::Builder::new().stack_size(2 * PAINTED);
        builder.spawn_scoped(scope, || measure(call)).unwrap().join().unwrap()
    })
}

fn measure(call: impl FnOnce()) -> usize {
    let memory = File::open("/proc/self/mem").unwrap();
    let mut below = vec![0; PAINTED];
    let mark = 0_u8;
    let top = black_box(&raw const mark).addr();
    paint();
    below_here(call);
    memory.read_exact_at(&mut below, (top - PAINTED) as u64).unwrap();
    let deepest = below.iter().position(|&byte| byte != PAINT).unwrap();
    assert!(deepest > PAINTED / 8, "nearly all paint is gone: paint more");
    PAINTED - deepest
}

#[inline(never)]
fn paint() {
    black_box(&mut [PAINT; PAINTED]);
}

/// Keeps what a call takes out of the frame that measures.
#[inline(never)]
fn below_here(call: impl FnOnce()) {
    call();
}
