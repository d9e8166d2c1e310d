//! Checks of all that `gltf` takes for granted: without them it panics, reads what is no position, or reads
//! without end.

use crate::budget::Budget;
use crate::error::Fault;
use crate::escape::shown_path;
use crate::folder::Folder;
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Buffer, Source};
use gltf::{Document, Gltf};
use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes that the least object of a document takes, rounded up.
const OBJECT: usize = 512;

/// A document and the buffer within its file.
pub(crate) fn document(bytes: &[u8], budget: &mut Budget) -> Result<Gltf, Fault> {
    // A binary file has text from its byte 20 on, of the length that bytes 12 to 15 tell.
    let text = match *bytes {
        [b'g', b'l', b'T', b'F', _, _, _, _, _, _, _, _, a, b, c, d, _, _, _, _, ref rest @ ..] => {
            let length = u32::from_le_bytes([a, b, c, d]) as usize;
            &rest[..length.min(rest.len())]
        }
        _ => bytes,
    };
    budget.check(OBJECT * text.iter().filter(|&&b| b == b'{').count())?;
    // Its strings and its binary chunk are copied.
    budget.take(bytes.len())?;
    let broken = |e: gltf::Error| Fault::broken(e.to_string());
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(broken)?;
    let root = document.into_json();
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut used = primitives.flat_map(|primitive| primitive.attributes.values());
    if let Some(stray) = used.find(|accessor| accessor.value() >= root.accessors.len()) {
        return Err(Fault::broken(format!("there is no accessor {}", stray.value())));
    }
    Ok(Gltf { document: Document::from_json(root).map_err(broken)?, blob })
}

/// The bytes of all buffers, those of one file once.
pub(crate) struct Buffers {
    /// For each buffer of the document the number of its data.
    numbers: Vec<usize>,
    data: Vec<Vec<u8>>,
}

impl Buffers {
    /// Reads buffers: in the file, in its text, or in files beside, whose bytes count as the file's. No more of a file is read
    /// than the longest of its buffers has.
    pub(crate) fn load(
        document: &Document,
        mut blob: Option<Vec<u8>>,
        folder: &Folder<'_>,
        budget: &mut Budget,
    ) -> Result<Self, Fault> {
        let mut paths: HashMap<&str, PathBuf> = HashMap::new();
        let mut lengths: HashMap<PathBuf, usize> = HashMap::new();
        for buffer in document.buffers() {
            let Some(uri) = uri(&buffer) else { continue };
            let path = match paths.get(uri) {
                Some(path) => path.clone(),
                None => folder.file(uri).map_err(|fault| in_buffer(&buffer, fault))?,
            };
            let longest = lengths.entry(path.clone()).or_default();
            *longest = buffer.length().max(*longest);
            paths.insert(uri, path);
        }
        let mut files: HashMap<&PathBuf, usize> = HashMap::new();
        let mut all = Self { numbers: Vec::new(), data: Vec::new() };
        for buffer in document.buffers() {
            let path = uri(&buffer).and_then(|uri| paths.get(uri));
            let known = path.and_then(|path| files.get(path).copied());
            all.numbers.push(known.unwrap_or(all.data.len()));
            if known.is_some() {
                continue;
            }
            let data = match path {
                Some(path) => {
                    files.insert(path, all.data.len());
                    read(path, lengths[path], budget)
                }
                None => inline(&buffer, &mut blob, budget),
            };
            all.data.push(data.map_err(|fault| in_buffer(&buffer, fault))?);
        }
        Ok(all)
    }

    pub(crate) fn get(&self, buffer: usize) -> Option<&[u8]> {
        Some(&self.data[*self.numbers.get(buffer)?])
    }

    fn bytes(&self) -> usize {
        self.data.iter().map(Vec::len).sum()
    }
}

/// Names the buffer that a fault is in.
fn in_buffer(buffer: &Buffer<'_>, fault: Fault) -> Fault {
    fault.within(format_args!("buffer {}", buffer.index()))
}

/// The name of the file that a buffer is in, unless that is the file of the document.
fn uri<'d>(buffer: &Buffer<'d>) -> Option<&'d str> {
    match buffer.source() {
        Source::Uri(uri) if !uri.starts_with("data:") => Some(uri),
        _ => None,
    }
}

/// A buffer in the file of the document or in its text.
fn inline(
    buffer: &Buffer<'_>,
    blob: &mut Option<Vec<u8>>,
    budget: &mut Budget,
) -> Result<Vec<u8>, Fault> {
    let Source::Uri(uri) = buffer.source() else {
        return blob.take().ok_or_else(|| Fault::broken("the file has no binary chunk"));
    };
    // Six bits a character.
    budget.take(uri.len() - uri.len() / 4)?;
    let text = uri.split_once(";base64,").map(|(_, text)| text);
    let text = text.ok_or_else(|| Fault::broken("a data URI that is not in base64"))?;
    BASE64.decode(text).map_err(|error| Fault::broken(error.to_string()))
}

/// The first `length` bytes of a file, which must have as many.
fn read(path: &Path, length: usize, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
    let fault = |what: String| Fault::broken(format!("{}: {what}", shown_path(path)));
    let io = |error: std::io::Error| fault(error.to_string());
    let file = File::open(path).map_err(io)?;
    let found = file.metadata().map_err(io)?.len();
    if found < length as u64 {
        return Err(fault(format!("has {found} bytes, and {length} by the document")));
    }
    budget.add_file(length);
    budget.take(length)?;
    let mut data = Vec::new();
    data.try_reserve_exact(length + 1).map_err(|error| fault(error.to_string()))?;
    file.take(length as u64).read_to_end(&mut data).map_err(io)?;
    Ok(data)
}

pub(crate) fn positions(accessor: &Accessor<'_>, buffers: &Buffers) -> Result<(), Fault> {
    is(accessor, Dimensions::Vec3, &[DataType::F32])?;
    inside(accessor, buffers)
}

pub(crate) fn indices(accessor: &Accessor<'_>, buffers: &Buffers) -> Result<(), Fault> {
    is(accessor, Dimensions::Scalar, &[DataType::U8, DataType::U16, DataType::U32])?;
    inside(accessor, buffers)
}

fn is(accessor: &Accessor<'_>, shape: Dimensions, types: &[DataType]) -> Result<(), Fault> {
    let (found, of) = (accessor.dimensions(), accessor.data_type());
    if found == shape && types.contains(&of) {
        return Ok(());
    }
    let what = format!("accessor {}: {found:?} of {of:?}, not {shape:?} of", accessor.index());
    Err(Fault::broken(format!("{what} {types:?}")))
}

/// Checks that an accessor has entries, and all of them in its buffer.
fn inside(accessor: &Accessor<'_>, buffers: &Buffers) -> Result<(), Fault> {
    let fault = || {
        let at = accessor.index();
        Fault::broken(format!("accessor {at} is empty, overlaps itself or leaves its buffer"))
    };
    let count = accessor.count();
    let dense = accessor.view().map(|view| (view, accessor.offset(), count, accessor.size()));
    let sparse = accessor.sparse().map(|sparse| {
        let (indices, values) = (sparse.indices(), sparse.values());
        [
            (indices.view(), indices.offset(), sparse.count(), indices.index_type().size()),
            (values.view(), values.offset(), sparse.count(), accessor.size()),
        ]
    });
    for (view, offset, count, size) in dense.into_iter().chain(sparse.into_iter().flatten()) {
        let stride = view.stride().unwrap_or(size);
        let last = count.checked_sub(1).and_then(|last| last.checked_mul(stride));
        let end = last.and_then(|last| last.checked_add(size)?.checked_add(offset));
        let view_end = view.offset().checked_add(view.length()).ok_or_else(fault)?;
        let buffer = buffers.get(view.buffer().index()).map_or(0, <[u8]>::len);
        if stride < size || end.is_none_or(|end| end > view.length()) || view_end > buffer {
            return Err(fault());
        }
    }
    // Without a view all is zero, and takes no bytes however much there is of it.
    if accessor.view().is_none() && count > buffers.bytes() {
        return Err(fault());
    }
    Ok(())
}
