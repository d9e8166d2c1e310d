//! What `gltf` takes for granted, checked before it does: else it panics, reads what is no position, or
//! reads without end.

use crate::mesh::error::Fault;
use crate::mesh::{Import, budget};
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Buffer, Data, Source};
use gltf::{Document, Gltf};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Bytes that the least object of a document takes, rounded up.
const OBJECT: usize = 512;

/// A document and the buffer within its file.
pub(super) fn document(bytes: &[u8], memory: usize) -> Result<Gltf, Fault> {
    // A binary file has text from its byte 20 on, of the length that bytes 12 to 15 tell.
    let text = match *bytes {
        [b'g', b'l', b'T', b'F', _, _, _, _, _, _, _, _, a, b, c, d, _, _, _, _, ref rest @ ..] => {
            let length = u32::from_le_bytes([a, b, c, d]) as usize;
            &rest[..length.min(rest.len())]
        }
        _ => bytes,
    };
    if OBJECT * text.iter().filter(|&&b| b == b'{').count() > memory {
        return Err(Fault::memory(memory));
    }
    if bytes.is_empty() {
        return Err(Fault::broken("is empty"));
    }
    if let [b'g', b'l', b'T', b'F', _, _, _, _, a, b, c, d, ..] = *bytes {
        let (due, found) = (u32::from_le_bytes([a, b, c, d]), bytes.len());
        if due as usize != found {
            return Err(Fault::broken(format!(
                "has {due} bytes by its header, but is {found} long"
            )));
        }
    }
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
pub(super) struct Buffers {
    /// For each buffer of the document the number of its data.
    numbers: Vec<usize>,
    data: Vec<Data>,
}

impl Buffers {
    /// Reads buffers: in the file, in its text, or in files beside, whose bytes count as the file's.
    pub(super) fn load(document: &Gltf, folder: &Path, import: &mut Import) -> Result<Self, Fault> {
        let mut blob = document.blob.clone();
        let mut files: HashMap<PathBuf, usize> = HashMap::new();
        let mut all = Self { numbers: Vec::new(), data: Vec::new() };
        for buffer in document.buffers() {
            let fault = |what: String| Fault::broken(format!("buffer {}: {what}", buffer.index()));
            let beside = beside(&buffer, folder);
            let number = beside.as_ref().and_then(|file| files.get(file).copied());
            all.numbers.push(number.unwrap_or(all.data.len()));
            if number.is_some() {
                continue;
            }
            let Some(file) = beside else {
                let data = Data::from_source_and_blob(buffer.source(), None, &mut blob);
                all.data.push(data.map_err(|e| fault(e.to_string()))?);
                continue;
            };
            // A device may never end.
            if !file.is_file() {
                return Err(fault(format!("there is no file {}", file.display())));
            }
            let data =
                std::fs::read(&file).map_err(|e| fault(format!("{}: {e}", file.display())))?;
            import.memory = import.memory.saturating_add(budget(data.len()) - budget(0));
            all.data.push(Data(data));
            files.insert(file, all.numbers[all.numbers.len() - 1]);
        }
        Ok(all)
    }

    pub(super) fn get(&self, buffer: usize) -> Option<&[u8]> {
        Some(&self.data[*self.numbers.get(buffer)?])
    }

    fn bytes(&self) -> usize {
        self.data.iter().map(|data| data.len()).sum()
    }
}

/// The file that a buffer is in, unless that is the file of the document.
fn beside(buffer: &Buffer<'_>, folder: &Path) -> Option<PathBuf> {
    match buffer.source() {
        Source::Uri(uri) if !uri.contains(':') => {
            Some(folder.join(unescaped(uri).unwrap_or_else(|| uri.into())))
        }
        _ => None,
    }
}

/// With the bytes that `%20` and the like stand for; nothing if they are no text.
fn unescaped(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes: Vec<u8> = parts.next()?.into();
    for part in parts {
        let (escaped, plain) = part.split_at_checked(2)?;
        bytes.push(u8::from_str_radix(escaped, 16).ok()?);
        bytes.extend(plain.bytes());
    }
    String::from_utf8(bytes).ok()
}

pub(super) fn positions(accessor: &Accessor<'_>, buffers: &Buffers) -> Result<(), Fault> {
    is(accessor, Dimensions::Vec3, &[DataType::F32])?;
    inside(accessor, buffers)
}

pub(super) fn indices(accessor: &Accessor<'_>, buffers: &Buffers) -> Result<(), Fault> {
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
