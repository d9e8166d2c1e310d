//! How errors of `pfront_core` become codes.

use super::pfront_error_t;
use super::pfront_status_t::{self, *};
use core::ffi::CStr;
use core::ptr::null;
use pfront_blob::BlobError;
use pfront_core::pose::PoseError;
use pfront_core::{BvhError, CapacityError, MeshError};

/// An error on its way to the caller.
pub(crate) type Fault = pfront_error_t;

impl Fault {
    pub(crate) fn new(status: pfront_status_t) -> Self {
        Self { status, what: null(), index: 0, needed: 0, given: 0 }
    }

    pub(crate) fn of(status: pfront_status_t, what: &'static CStr) -> Self {
        Self { what: what.as_ptr(), ..Self::new(status) }
    }

    /// The same about a model that C calls `what`, if it is one that is no solid.
    #[cfg(feature = "std")]
    pub(crate) fn named(self, what: &'static CStr) -> Self {
        if self.what.is_null() { Self { what: what.as_ptr(), ..self } } else { self }
    }

    pub(crate) fn at(self, index: usize) -> Self {
        Self { index, ..self }
    }

    pub(crate) fn numbers(self, needed: usize, given: usize) -> Self {
        Self { needed, given, ..self }
    }

    /// `Ok` if `given` is below `limit`.
    pub(crate) fn below(what: &'static CStr, given: usize, limit: usize) -> Result<(), Self> {
        if given < limit {
            return Ok(());
        }
        Err(Self::of(PFRONT_OUT_OF_RANGE, what).numbers(limit, given))
    }

    /// `Ok` if `given` elements are enough.
    pub(crate) fn room(what: &'static CStr, given: usize, needed: usize) -> Result<(), Self> {
        if given >= needed {
            return Ok(());
        }
        Err(Self::of(PFRONT_TOO_SMALL, what).numbers(needed, given))
    }

    /// An error in the pose that C calls `what`.
    pub(crate) fn pose(what: &'static CStr) -> impl Fn(PoseError) -> Self {
        move |error| match error {
            PoseError::NonFinite { row, column } => {
                Self::of(PFRONT_POSE_NOT_FINITE, what).at(4 * row + column)
            }
            PoseError::Range { row } => Self::of(PFRONT_POSE_RANGE, what).at(row),
            _ => Self::new(PFRONT_DAMAGED),
        }
    }

    /// An error in the mesh whose arrays C calls so.
    pub(crate) fn mesh(
        positions: &'static CStr,
        triangles: &'static CStr,
    ) -> impl Fn(MeshError) -> Self {
        move |error| match error {
            MeshError::NonFinite { vertex } => Self::of(PFRONT_NOT_FINITE, positions).at(vertex),
            MeshError::IndexOutOfRange { triangle, index, vertices } => {
                let fault = Self::of(PFRONT_NO_SUCH_VERTEX, triangles).at(triangle);
                fault.numbers(vertices, index as usize)
            }
            MeshError::TooManyTriangles { triangles: given } => {
                let fault = Self::of(PFRONT_TOO_MANY_TRIANGLES, triangles);
                fault.numbers(pfront_core::MAX_TRIANGLES, given)
            }
            MeshError::VertexCount { expected, found } => {
                Self::of(PFRONT_VERTEX_COUNT, positions).numbers(expected, found)
            }
            MeshError::Range { vertex } => Self::of(PFRONT_POSITION_RANGE, positions).at(vertex),
            MeshError::OtherPrecision => Self::of(PFRONT_OTHER_PRECISION, positions),
            MeshError::Shadow { vertex } => Self::of(PFRONT_SHADOW, positions).at(vertex),
            MeshError::FloatEnvironment => Self::new(PFRONT_FLOAT_ENVIRONMENT),
            _ => Self::new(PFRONT_DAMAGED),
        }
    }
}

impl From<CapacityError> for Fault {
    fn from(CapacityError { buffer, needed, capacity, .. }: CapacityError) -> Self {
        let what = match buffer {
            "nodes" | "front" => c"nodes",
            "history" => c"history",
            "out" => c"blob",
            _ => return Self::new(PFRONT_DAMAGED),
        };
        Self::of(PFRONT_TOO_SMALL, what).numbers(needed, capacity)
    }
}

impl From<MeshError> for Fault {
    fn from(error: MeshError) -> Self {
        Self::mesh(c"positions", c"triangles")(error)
    }
}

impl From<BvhError> for Fault {
    fn from(error: BvhError) -> Self {
        let (order, node) =
            (Self::of(PFRONT_BVH_ORDER, c"order"), Self::of(PFRONT_BVH_NODE, c"nodes"));
        match error {
            BvhError::Length { array, expected, found } => {
                let fault = if array == "order" { order } else { node };
                fault.numbers(expected, found)
            }
            BvhError::Order { entry } => order.at(entry),
            BvhError::Child { node: at } | BvhError::Leaf { node: at } => node.at(at),
            BvhError::Box { node: at } => Self::of(PFRONT_BVH_BOX, c"nodes").at(at),
            BvhError::TooMany { array: "positions", most, found } => {
                Self::of(PFRONT_TOO_LONG, c"positions").numbers(most, found)
            }
            BvhError::Capacity(error) => error.into(),
            _ => Self::new(PFRONT_DAMAGED),
        }
    }
}

impl From<BlobError> for Fault {
    fn from(error: BlobError) -> Self {
        let of = |status| Self::of(status, c"blob");
        match error {
            BlobError::Magic => of(PFRONT_BLOB_MAGIC),
            BlobError::Version { found, known } => {
                of(PFRONT_BLOB_VERSION).numbers(known as usize, found as usize)
            }
            BlobError::Length { needed, found } => {
                let needed = usize::try_from(needed).unwrap_or(usize::MAX);
                of(PFRONT_BLOB_LENGTH).numbers(needed, found)
            }
            BlobError::Byte { byte } => of(PFRONT_BLOB_BYTE).at(byte),
            BlobError::Checksum { stored, computed } => {
                of(PFRONT_BLOB_CHECKSUM).numbers(stored as usize, computed as usize)
            }
            BlobError::Misaligned { needed } => of(PFRONT_MISALIGNED).numbers(needed, 0),
            BlobError::BigEndian => of(PFRONT_BIG_ENDIAN),
            BlobError::InF64 => of(PFRONT_OTHER_PRECISION),
            BlobError::Mesh(error) => error.into(),
            BlobError::Bvh(error) => error.into(),
            BlobError::Capacity(error) => error.into(),
            _ => Self::new(PFRONT_DAMAGED),
        }
    }
}

#[cfg(feature = "std")]
impl From<pfront::NotSolid> for Fault {
    fn from(error: pfront::NotSolid) -> Self {
        use pfront::NotSolid;
        match error {
            NotSolid::OpenEdge { triangle, edge } => {
                Self::new(PFRONT_OPEN_EDGE).at(triangle as usize).numbers(0, edge as usize)
            }
            NotSolid::MeetsItself { pair } => {
                Self::new(PFRONT_MEETS_ITSELF).at(pair.a as usize).numbers(0, pair.b as usize)
            }
            NotSolid::NoVolume => Self::new(PFRONT_NO_VOLUME),
            NotSolid::Capacity(error) => error.into(),
            _ => Self::new(PFRONT_DAMAGED),
        }
    }
}

#[cfg(feature = "std")]
impl From<pfront::Error> for Fault {
    fn from(error: pfront::Error) -> Self {
        use pfront::{Error, MotionError};
        match error {
            Error::Mesh(error) => error.into(),
            Error::Blob(error) => error.into(),
            Error::Capacity(error) => error.into(),
            Error::Pose(error) => Self::pose(c"world_from_body")(error),
            Error::Memory { needed } => {
                Self::of(PFRONT_OUT_OF_MEMORY, c"malloc").numbers(needed, 0)
            }
            Error::Solid(error) => error.into(),
            Error::Distance(_) => Self::of(PFRONT_DISTANCE, c"distance"),
            Error::Motion(MotionError::Triangle { triangle }) => {
                Self::of(PFRONT_MOTION, c"end").at(triangle)
            }
            Error::TwoEnds { id } => Self::of(PFRONT_MOTION, c"ends").at(id.to_bits() as usize),
            Error::NotAPair { question } => Self::of(PFRONT_NULL, c"b").at(question),
            Error::StaleBody { id } => {
                Self::of(PFRONT_STALE_BODY, c"body").at(id.to_bits() as usize)
            }
            #[cfg(feature = "gpu")]
            Error::Gpu(_) => Self::new(PFRONT_DEVICE),
            _ => Self::new(PFRONT_DAMAGED),
        }
    }
}
