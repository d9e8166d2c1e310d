//! The first bytes of a file, which tell its format, and how long it says it is. A file that is not what its name says is
//! refused by these, before the rest is read.

use crate::error::{Fault, Remedy};
use crate::format::BAKED;
use crate::stl;
use pfront_core::blob::{BlobError, MAGIC};

/// As many bytes of a file are looked at before the rest is read.
pub(crate) const HEAD: u64 = 1 << 16;

/// The format that a file without a name of its own begins like.
pub(crate) fn beginning(head: &[u8]) -> Option<&'static str> {
    let begins = |word: &str| head.starts_with(word.as_bytes());
    match head.trim_ascii_start() {
        _ if head.starts_with(&MAGIC) => Some(BAKED),
        _ if begins("ply") => Some("ply"),
        _ if begins("solid") => Some("stl"),
        _ if begins("glTF") => Some("glb"),
        [b'{', ..] => Some("gltf"),
        _ if head.windows(3).take(4).any(|word| word == b"OFF") => Some("off"),
        _ if begins("v ") || begins("#") || begins("o ") || begins("mtllib ") => Some("obj"),
        _ => None,
    }
}

/// The bytes that a file of a format says it has, if it does; `found` is its length where that is known.
///
/// # Errors
/// If it does not begin as the format does, or has another length than it says.
pub(crate) fn length(format: &str, head: &[u8], found: Option<u64>) -> Result<Option<u64>, Fault> {
    let number = |at: usize| head.get(at..at + 4)?.first_chunk().copied();
    let number = |at: usize| number(at).map(|bytes| u64::from(u32::from_le_bytes(bytes)));
    let (due, is_text) = match format {
        BAKED if !head.starts_with(&MAGIC) => {
            return Err(BlobError::Magic.into());
        }
        BAKED => (number(16).zip(number(20)).map(|(low, high)| low | high << 32), false),
        "gltf" | "glb" if head.starts_with(b"glTF") => (number(8), false),
        "gltf" | "glb" if head.trim_ascii_start().first().is_some_and(|&byte| byte != b'{') => {
            return Err(Fault::broken("neither glTF nor a JSON object").or(Remedy::Format));
        }
        "ply" if !head.starts_with(b"ply") => {
            return Err(Fault::line(1, "a PLY file begins with ply").or(Remedy::Format));
        }
        "ply" => (None, !head.windows(10).any(|word| word == b"end_header")),
        "stl" => {
            let count = number(stl::HEADER - 4);
            let due = count.map(|n| stl::HEADER as u64 + stl::TRIANGLE as u64 * n);
            // Text is never as long as its bytes 80 to 83 say: as a count they are 150 million at least.
            (due.filter(|_| due == found || !stl::is_text(head)), false)
        }
        // A binary one is refused by that name.
        "off" => (None, !head.windows(6).any(|word| word == b"BINARY")),
        _ => (None, true),
    };
    if is_text && head.contains(&0) {
        return Err(Fault::broken("it is not text").or(Remedy::Format));
    }
    match due.zip(found) {
        Some((due, found)) if due != found => Err(other_length(format, due, found)),
        _ => Ok(due),
    }
}

/// The fault of a file that has another length than it says.
pub(crate) fn other_length(format: &str, due: u64, found: u64) -> Fault {
    match format {
        BAKED => BlobError::Length { needed: due, found: found as usize }.into(),
        "stl" => {
            let triangles = (due - stl::HEADER as u64) / stl::TRIANGLE as u64;
            let what =
                format!("a binary STL of {triangles} triangles has {due} bytes, not {found}");
            Fault::broken(what).or(Remedy::Format)
        }
        _ => Fault::broken(format!("has {due} bytes by its header, but is {found} long")),
    }
}
