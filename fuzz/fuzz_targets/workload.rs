//! Workload files of arbitrary bytes: refused with an error or read to the end, and what is
//! read is written again to the same bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;
use pfront_lab::workload::{Workload, WorkloadWriter};
use std::io::Cursor;

fuzz_target!(|bytes: &[u8]| {
    // The magic would take long to guess.
    workload(&[b"TRICOLW1", bytes].concat());
});

fn workload(bytes: &[u8]) {
    let Ok((header, mut workload)) = Workload::open(Cursor::new(bytes)) else { return };
    let mut again = Vec::new();
    let mut to = WorkloadWriter::new(&mut again, &header).unwrap();
    loop {
        match workload.next_frame() {
            // The first object of a pair may have been moved.
            Err(_) => return,
            Ok(None) => break,
            Ok(Some(frame)) => to.frame(frame).unwrap(),
        }
    }
    assert_eq!(again, bytes);
}
