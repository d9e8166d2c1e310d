//! Any sequence of calls on any meshes, on every backend at once: bodies come, go, move, deform, break and
//! are rebuilt, threads are divided anew, and every question is held against brute force.

#![no_main]

use libfuzzer_sys::fuzz_target;
use pfront_fuzz::Calls;

fuzz_target!(|calls: Calls| calls.run());
