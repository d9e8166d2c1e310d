//! The numbers of accessors: dense and sparse, quantized and normalized.

use super::checked::{Buffers, inside};
use crate::budget::Budget;
use crate::error::Fault;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::View;

const POSITIONS: [DataType; 5] =
    [DataType::F32, DataType::I8, DataType::U8, DataType::I16, DataType::U16];

/// Positions of vertices or how far they are moved.
pub(super) fn positions(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    budget: &Budget,
) -> Result<Vec<[f64; 3]>, Fault> {
    numbers(accessor, Dimensions::Vec3, &POSITIONS, buffers, budget)
}

pub(super) fn indices(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    budget: &Budget,
) -> Result<Vec<[f64; 1]>, Fault> {
    let types = [DataType::U8, DataType::U16, DataType::U32];
    numbers(accessor, Dimensions::Scalar, &types, buffers, budget)
}

/// The joints of vertices, which are whole numbers from 0.
pub(super) fn joints(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    budget: &Budget,
) -> Result<Vec<[f64; 4]>, Fault> {
    if accessor.normalized() {
        return Err(Fault::broken(format!("accessor {} is normalized", accessor.index())));
    }
    numbers(accessor, Dimensions::Vec4, &[DataType::U8, DataType::U16], buffers, budget)
}

/// The weights of vertices, and rotations.
pub(super) fn fours(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    budget: &Budget,
) -> Result<Vec<[f64; 4]>, Fault> {
    numbers(accessor, Dimensions::Vec4, &POSITIONS, buffers, budget)
}

pub(super) fn matrices(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    budget: &Budget,
) -> Result<Vec<[f64; 16]>, Fault> {
    numbers(accessor, Dimensions::Mat4, &[DataType::F32], buffers, budget)
}

fn numbers<const N: usize>(
    accessor: &Accessor<'_>,
    shape: Dimensions,
    types: &[DataType],
    buffers: &Buffers,
    budget: &Budget,
) -> Result<Vec<[f64; N]>, Fault> {
    let (found, of) = (accessor.dimensions(), accessor.data_type());
    if found != shape || !types.contains(&of) {
        let what = format!("accessor {}: {found:?} of {of:?}, not {shape:?} of", accessor.index());
        return Err(Fault::broken(format!("{what} {types:?}")));
    }
    inside(accessor, buffers)?;
    budget.check(accessor.count().saturating_mul(2 * size_of::<[f64; N]>()))?;
    let component = accessor.size() / N;
    let number = |bytes: &[u8]| number(bytes, of, accessor.normalized());
    let element = |bytes: &[u8]| {
        let mut element = [0.0; N];
        for (number_of, bytes) in element.iter_mut().zip(bytes.chunks_exact(component)) {
            *number_of = number(bytes);
        }
        element
    };
    let mut all: Vec<[f64; N]> = match accessor.view() {
        Some(view) => {
            let chunks = elements(&view, accessor.offset(), accessor.size(), buffers);
            chunks.take(accessor.count()).map(element).collect()
        }
        None => vec![[0.0; N]; accessor.count()],
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, values) = (sparse.indices(), sparse.values());
        let of = match indices.index_type() {
            IndexType::U8 => DataType::U8,
            IndexType::U16 => DataType::U16,
            IndexType::U32 => DataType::U32,
        };
        let indices = elements(&indices.view(), indices.offset(), of.size(), buffers);
        let values = elements(&values.view(), values.offset(), accessor.size(), buffers);
        for (index, value) in indices.zip(values).take(sparse.count()) {
            let index = self::number(index, of, false) as usize;
            let place = all.get_mut(index).ok_or_else(|| {
                let at = accessor.index();
                Fault::broken(format!("accessor {at}: a sparse value of element {index}"))
            })?;
            *place = element(value);
        }
    }
    Ok(all)
}

/// The bytes of elements, which the caller has checked to be there.
fn elements<'b>(
    view: &View<'_>,
    offset: usize,
    size: usize,
    buffers: &'b Buffers,
) -> impl Iterator<Item = &'b [u8]> + use<'b> {
    let bytes = buffers.get(view.buffer().index()).unwrap_or_default();
    let (stride, from) = (view.stride().unwrap_or(size), view.offset() + offset);
    let end = view.offset() + view.length();
    (0..).map_while(move |i: usize| {
        let at = from + i * stride;
        bytes.get(at..at + size).filter(|_| at + size <= end)
    })
}

/// A component as the extension `KHR_mesh_quantization` has it.
fn number(bytes: &[u8], of: DataType, is_normalized: bool) -> f64 {
    let word = [0, 1, 2, 3].map(|i| bytes.get(i).copied().unwrap_or(0));
    let [low, high, ..] = word;
    let (number, most): (f64, f64) = match of {
        DataType::I8 => (f64::from(low as i8), 127.0),
        DataType::U8 => (f64::from(low), 255.0),
        DataType::I16 => (f64::from(i16::from_le_bytes([low, high])), 32767.0),
        DataType::U16 => (f64::from(u16::from_le_bytes([low, high])), 65535.0),
        DataType::U32 => return f64::from(u32::from_le_bytes(word)),
        DataType::F32 => return f64::from(f32::from_le_bytes(word)),
    };
    if is_normalized { (number / most).max(-1.0) } else { number }
}
