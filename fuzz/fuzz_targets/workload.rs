//! Workload and pair files of arbitrary bytes: refused with an error or read to the end, and what is
//! read is written again to the same bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;
use pfront_lab::pairs::{self, PairWriter};
use pfront_lab::workload::{Workload, WorkloadWriter};
use std::io::Cursor;

fuzz_target!(|bytes: &[u8]| {
    // The magics would take long to guess.
    let with = |magic: &[u8]| [magic, bytes].concat();
    workload(&with(b"TRICOLW1"));
    pair_file(&with(b"TRICOLP1"));
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

fn pair_file(bytes: &[u8]) {
    let Ok(frames) = pairs::read(Cursor::new(bytes)) else { return };
    let mut again = Vec::new();
    let mut to = PairWriter::new(&mut again, frames.len() as u32).unwrap();
    frames.iter().for_each(|pairs| to.frame(pairs).unwrap());
    assert_eq!(again, bytes);
}
