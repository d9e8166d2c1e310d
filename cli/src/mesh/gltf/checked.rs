//! What `gltf` takes for granted, checked before it does: else it panics, reads what is no position, or
//! reads without end.

use crate::mesh::error::Fault;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Buffer, Data, Source};
use gltf::{Document, Gltf};
use std::path::Path;

/// A document and the buffer within its file.
pub(super) fn document(bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), Fault> {
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
    Ok((Document::from_json(root).map_err(broken)?, blob))
}

/// Reads a buffer: in the file, in its text, or in a file beside.
pub(super) fn load(
    buffer: &Buffer<'_>,
    folder: &Path,
    blob: &mut Option<Vec<u8>>,
) -> Result<Data, Fault> {
    let fault = |what: String| Fault::broken(format!("buffer {}: {what}", buffer.index()));
    match buffer.source() {
        Source::Uri(uri) if !uri.contains(':') => {
            let name = unescaped(uri).unwrap_or_else(|| uri.into());
            let file = folder.join(name);
            // A device may never end.
            if !file.is_file() {
                return Err(fault(format!("there is no file {}", file.display())));
            }
            std::fs::read(&file).map(Data).map_err(|e| fault(format!("{}: {e}", file.display())))
        }
        source => Data::from_source_and_blob(source, None, blob).map_err(|e| fault(e.to_string())),
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

pub(super) fn positions(accessor: &Accessor<'_>, buffers: &[Data]) -> Result<(), Fault> {
    is(accessor, Dimensions::Vec3, &[DataType::F32])?;
    inside(accessor, buffers)
}

pub(super) fn indices(accessor: &Accessor<'_>, buffers: &[Data]) -> Result<(), Fault> {
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
fn inside(accessor: &Accessor<'_>, buffers: &[Data]) -> Result<(), Fault> {
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
        let buffer = buffers.get(view.buffer().index()).map_or(0, |data| data.len());
        if stride < size || end.is_none_or(|end| end > view.length()) || view_end > buffer {
            return Err(fault());
        }
    }
    // Without a view all is zero, and takes no bytes however much there is of it.
    if accessor.view().is_none() && count > buffers.iter().map(|data| data.len()).sum() {
        return Err(fault());
    }
    Ok(())
}
