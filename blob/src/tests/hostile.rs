//! Bytes that are no blob, by accident or by intent.

use super::*;

/// Puts the right checksum into bytes that have been tampered with.
fn seal(bytes: &mut [u8]) {
    let checksum = checksum(bytes).to_le_bytes();
    bytes[12..16].copy_from_slice(&checksum);
}

/// The fault found in a blob after a change under a right checksum.
pub(super) fn after(bytes: &[u8], change: impl FnOnce(&mut [u8])) -> Option<BlobError> {
    let mut bytes = bytes.to_vec();
    change(&mut bytes);
    seal(&mut bytes);
    let blob = match Blob::new(&bytes) {
        Ok(blob) => blob,
        Err(error) => return Some(error),
    };
    let mut room = Owned::room(blob.counts());
    #[cfg(feature = "f64")]
    let mut exact = vec![[0.0; 3]; blob.counts().positions_f64];
    #[cfg(feature = "f64")]
    let copied = blob.read_into_f64(room.storage(), &mut exact, &mut [0; 4]).err();
    #[cfg(not(feature = "f64"))]
    let copied = blob.read_into(room.storage(), &mut [0; 4]).err();
    let place = aligned(&bytes);
    let borrowed = Blob::new(&place.0[..bytes.len()]).unwrap().bvh(&mut [0; 4]).err();
    if blob.is_f64() {
        assert_eq!(borrowed, Some(BlobError::InF64));
        return copied;
    }
    // A big-endian machine names what is wrong between sections, and borrows none.
    let is_foreign = cfg!(target_endian = "big") && borrowed == Some(BlobError::BigEndian);
    assert!(is_foreign || borrowed == copied, "{borrowed:?} {copied:?}");
    copied
}

fn put(bytes: &mut [u8], at: usize, word: u32) {
    bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
}

#[test]
fn every_flipped_bit_is_found() {
    let golden = GOLDEN.concat();
    for bit in (0..8 * golden.len()).step_by(if cfg!(miri) { 61 } else { 1 }) {
        let mut bytes = golden.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let read = Blob::new(&bytes).and_then(|blob| {
            blob.read_into(Owned::room(blob.counts()).storage(), &mut [0]).map(|_| ())
        });
        assert!(read.is_err(), "bit {bit}");
    }
}

#[test]
fn every_truncation_and_extension_is_found() {
    let mut bytes = GOLDEN.concat();
    for len in 0..bytes.len() {
        let needed = if len < 64 { 64 } else { 164 };
        let expected = BlobError::Length { needed, found: len };
        assert_eq!(Blob::new(&bytes[..len]).err(), Some(expected));
    }
    bytes.push(0);
    assert!(Blob::new(&bytes).is_err());
}

#[test]
fn foreign_headers_are_named() {
    let golden = GOLDEN.concat();
    let byte = |byte| BlobError::Byte { byte };
    let cases: [(usize, &[u8], BlobError); 10] = [
        (0, b"P", BlobError::Magic),
        (4, b"\n\n", BlobError::Magic),
        (8, &[2], BlobError::Version { found: 2, known: 1 }),
        (11, &[1], BlobError::Version { found: 0x0100_0001, known: 1 }),
        (24, &[2], byte(24)),
        (27, &[1], byte(27)),
        (28, &[0], byte(28)),
        (30, &[9], byte(30)),
        (16, &[165], BlobError::Length { needed: 165, found: 164 }),
        (63, &[1], byte(63)),
    ];
    for (at, new, expected) in cases {
        let found = after(&golden, |bytes| bytes[at..at + new.len()].copy_from_slice(new));
        assert_eq!(found, Some(expected));
    }
    for gap in [132, 143, 156, 159] {
        let found = after(&golden, |bytes| bytes[gap] = 1);
        assert_eq!(found, Some(byte(gap)));
    }
}

/// Among them counts whose bytes are more than a 32-bit machine can number, and exactly 2³² more than there are.
#[test]
fn counts_that_lie_are_refused() {
    let golden = GOLDEN.concat();
    for (at, count) in [
        (32, 0),
        (32, 2),
        (32, u32::MAX),
        (32, (1 << 27) + 1),
        (36, 0),
        (36, 5),
        (36, u32::MAX),
        (36, (1 << 30) + 3),
        (40, 0),
        (40, 2),
        (40, u32::MAX),
        (40, (1 << 28) + 1),
    ] {
        let found = after(&golden, |bytes| put(bytes, at, count));
        assert!(matches!(found, Some(BlobError::Length { .. })), "{at} {count} {found:?}");
    }
    let longest = |bytes: &mut [u8]| bytes[16..24].fill(0xff);
    let found = after(&golden, longest);
    assert_eq!(found, Some(BlobError::Length { needed: u64::MAX, found: 164 }));
    // Four vertices end where three and a gap do: another blob, and a good one.
    assert_eq!(after(&golden, |bytes| put(bytes, 36, 4)), None);
}

/// Whether a fault is the one that is expected.
type Is<'i> = &'i dyn Fn(BlobError) -> bool;

#[test]
fn contents_that_lie_are_refused() {
    // 64 the root, 128 its children, of which the first is a leaf; then positions, triangles and order.
    let own = Owned::new(strip(9), 8, false);
    let bytes = own.baked();
    let [_, positions, triangles, order, _] = Counts::of(&own.bvh()).sections().map(|s| s.start);
    assert_eq!(own.nodes.len(), 4);
    let is_box = |error| matches!(error, BlobError::Bvh(BvhError::Box { .. }));
    let is_leaf = |error| matches!(error, BlobError::Bvh(BvhError::Leaf { .. }));
    let is_child = |error| matches!(error, BlobError::Bvh(BvhError::Child { node: 0 }));
    let is_order = |error| matches!(error, BlobError::Bvh(BvhError::Order { .. }));
    let is_mesh = |error| matches!(error, BlobError::Mesh(MeshError::IndexOutOfRange { .. }));
    let is_finite = |error| matches!(error, BlobError::Mesh(MeshError::NonFinite { vertex: 1 }));
    let [nan, infinite, inside] = [f32::NAN, f32::INFINITY, 0.5].map(f32::to_bits);
    let cases: [(&str, usize, u32, Is<'_>); 14] = [
        ("NaN", positions + 12, nan, &is_finite),
        ("infinity", positions + 20, infinite, &is_finite),
        ("index out of range", triangles + 4, 11, &is_mesh),
        ("index far out of range", triangles + 8, u32::MAX, &is_mesh),
        ("a triangle twice", order, own.order[1], &is_order),
        ("order out of range", order + 32, 9, &is_order),
        ("a child that is its parent", 64 + 12, 0, &is_child),
        ("odd children", 64 + 12, 3, &is_child),
        ("children out of range", 64 + 12, u32::MAX, &is_child),
        ("leaf runs that overlap", 160 + 12, own.nodes[3].first - 1, &is_leaf),
        ("a leaf that is too large", 128 + 28, 9, &is_leaf),
        ("a box that is too small", 64 + 16, inside, &is_box),
        ("a box that is none", 128, nan, &is_box),
        ("a leaf's box that is too small", 128 + 16, inside, &is_box),
    ];
    for (what, at, word, expected) in cases {
        let found = after(&bytes, |bytes| put(bytes, at, word));
        assert!(found.is_some_and(expected), "{what}: {found:?}");
    }
}

/// No word anywhere makes a check panic, whatever it says, and what passes is well formed.
#[test]
fn no_word_is_trusted() {
    let bytes = Owned::new(strip(9), 2, true).baked();
    let words = [0, 1, 2, 9, 1 << 31, u32::MAX, f32::NAN.to_bits(), f32::MAX.to_bits()];
    for at in (0..bytes.len()).step_by(if cfg!(miri) { 124 } else { 4 }) {
        for word in words {
            let mut changed = bytes.clone();
            put(&mut changed, at, word);
            seal(&mut changed);
            let Ok(blob) = Blob::new(&changed) else { continue };
            let mut own = Owned::room(blob.counts());
            if let Ok(bvh) = blob.read_into(own.storage(), &mut [0]) {
                bvh.assert_well_formed();
            }
        }
    }
}

#[test]
fn faults_are_told_in_words() {
    for (error, word) in [
        (Blob::new(b"no blob").unwrap_err(), "pfront bake"),
        (BlobError::Misaligned { needed: 4 }, "multiple of 4"),
        (BlobError::BigEndian, "read_into"),
        (BlobError::Version { found: 7, known: 1 }, "version 7"),
    ] {
        assert!(format!("{error}").contains(word), "{error}");
    }
}
