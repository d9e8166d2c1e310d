//! The first bytes of a file, which tell its format, and how long it says it is. A file that is not what its name says is
//! refused by these, before the rest is read.

use crate::error::{Fault, Remedy};
use crate::format::{BAKED, FIRST_VERSION};
use crate::stl;
use crate::text::without_padding;
use pfront_blob::{BlobError, MAGIC};

/// As many bytes of a file are looked at before the rest is read.
pub(crate) const HEAD: u64 = 1 << 16;

/// The bytes of the header of a GLB.
const SHORTEST: u64 = 12;

/// The format that a file without a name of its own begins like.
pub(crate) fn beginning(head: &[u8]) -> Option<&'static str> {
    let begins = |word: &str| head.starts_with(word.as_bytes());
    let is_off = |word: &[u8]| word.eq_ignore_ascii_case(b"OFF");
    match head.trim_ascii_start() {
        _ if head.starts_with(&MAGIC) => Some(BAKED),
        _ if begins("ply") => Some("ply"),
        _ if begins("solid") => Some("stl"),
        _ if begins("glTF") => Some("glb"),
        _ if begins("PK\x03\x04") => Some("3mf"),
        [b'{', ..] => Some("gltf"),
        _ if head.windows(3).take(4).any(is_off) => Some("off"),
        _ if begins("v ") || begins("#") || begins("o ") || begins("mtllib ") => Some("obj"),
        _ => None,
    }
}

/// Checks the first bytes of a file, and returns how many it says it has, if it does; `found` is its length where that is
/// known.
///
/// # Errors
/// If it does not begin as the format does, or has fewer bytes than it says.
pub(crate) fn length(format: &str, head: &[u8], found: Option<u64>) -> Result<Option<u64>, Fault> {
    let number = |at: usize| head.get(at..at + 4)?.first_chunk().copied();
    let number = |at: usize| number(at).map(|bytes| u64::from(u32::from_le_bytes(bytes)));
    let (due, is_text) = match format {
        BAKED if !head.starts_with(&MAGIC) => return Err(BlobError::Magic.into()),
        BAKED => (number(16).zip(number(20)).map(|(low, high)| low | high << 32), false),
        "gltf" | "glb" if head.starts_with(b"glTF\x01") => {
            return Err(Fault::broken(FIRST_VERSION));
        }
        "gltf" | "glb" if head.starts_with(b"glTF") => (number(8), false),
        "gltf" | "glb" if head.trim_ascii_start().first().is_some_and(|&byte| byte != b'{') => {
            return Err(Fault::broken("neither glTF nor a JSON object").or(Remedy::Format));
        }
        "3mf" if !head.starts_with(b"PK\x03\x04") => {
            return Err(Fault::broken("a 3MF file begins as ZIP archives do").or(Remedy::Format));
        }
        "3mf" => (None, false),
        "ply" if !head.starts_with(b"ply") => {
            return Err(Fault::line(1, "a PLY file begins with ply").or(Remedy::Format));
        }
        "ply" => (None, !head.windows(10).any(|word| word == b"end_header")),
        "stl" => (None, stl::check(head, found)?),
        // A binary one is refused by that name.
        "off" => (None, !head.windows(6).any(|word| word == b"BINARY")),
        _ => (None, true),
    };
    let read = head.len() as u64;
    let is_all = found.map_or(read < HEAD, |found| found == read);
    let text = if is_all { without_padding(head) } else { head };
    if is_text && text.contains(&0) {
        return Err(Fault::broken("it is not text").or(Remedy::Format));
    }
    match due.zip(found) {
        Some((due, found)) if due > found || due < SHORTEST || format == BAKED && due < found => {
            Err(other_length(format, due, found))
        }
        _ => Ok(due),
    }
}

/// The fault of a file that has another length than it says.
pub(crate) fn other_length(format: &str, due: u64, found: u64) -> Fault {
    match format {
        BAKED => BlobError::Length { needed: due, found: found as usize }.into(),
        _ => Fault::broken(format!("has {due} bytes by its header, but is {found} long")),
    }
}
