//! Recorded workloads: meshes and how they move, frame by frame (`.tcw`).
//!
//! Little-endian: magic `TRICOLW1`; u32 kind (0 pair, 1 self, 2 many), n_meshes, n_objects, n_frames; per
//! mesh u32 nv, nt, f32 positions\[3nv\], u32 triangles\[3nt\]; u32 object_mesh\[n_objects\]; for kinds 0
//! and 2 f32 poses\[n_frames\]\[n_objects\]\[12\], row-major 3×4 object-to-world, object 0 of kind 0 at
//! the identity; for kind 1 f32 positions\[n_frames\]\[3nv\].
//!
//! Meshes are read at once, frames as they are asked for, so that a long recording needs no more memory
//! than a short one.

use crate::format::{Reader, write_words};
use anyhow::Result;
use pfront::Pose;
use pfront_testkit::MeshData;
use pfront_testkit::scenes::Kind;
use std::io::{self, Read, Seek, Write};

const MAGIC: &[u8; 8] = b"TRICOLW1";
const KINDS: [Kind; 3] = [Kind::Pair, Kind::SelfMesh, Kind::Many];

/// The header of a workload: all that its frames have in common.
#[derive(Clone, Debug)]
pub struct Header {
    /// The kind of question that it asks.
    pub kind: Kind,
    /// The meshes; not checked for NaN or indices out of range, which [`pfront::Model::new`] does.
    pub meshes: Vec<MeshData>,
    /// The mesh of each object, as an index into `meshes`.
    pub objects: Vec<u32>,
    /// How many frames there are.
    pub frames: u32,
}

/// How the objects of a frame lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Frame<'a> {
    /// World from object, of each object.
    Poses(&'a [Pose]),
    /// The vertices of the one deforming mesh.
    Positions(&'a [[f32; 3]]),
}

/// A workload file being read.
#[derive(Debug)]
pub struct Workload<R> {
    kind: Kind,
    /// The frames that are read.
    pub frames: u32,
    reader: Reader<R>,
    next: u32,
    poses: Vec<Pose>,
    positions: Vec<[f32; 3]>,
}

impl<R: Read + Seek> Workload<R> {
    /// Reads what frames have in common, and checks that they are there.
    ///
    /// # Errors
    /// The offset of what is not as the format says.
    pub fn open(from: R) -> Result<(Header, Self)> {
        let mut reader = Reader::new(from, MAGIC, "a workload")?;
        let mut words = [0_u32; 4];
        reader.words("the header", &mut words)?;
        let [kind, meshes, objects, frames] = words;
        let Some(&kind) = KINDS.get(kind as usize) else {
            return Err(reader.invalid(16, format!("kind {kind} is none of 0, 1 and 2")));
        };
        let wanted = match kind {
            Kind::Pair => Some(2),
            Kind::SelfMesh => Some(1),
            Kind::Many => None,
        };
        if wanted.is_some_and(|wanted| wanted != objects) {
            return Err(reader.invalid(8, format!("a {kind:?} workload of {objects} objects")));
        }
        if kind == Kind::SelfMesh && meshes != 1 {
            return Err(reader.invalid(12, format!("a self workload of {meshes} meshes")));
        }
        reader.fits("the meshes", meshes.into(), 8)?;
        let meshes: Vec<_> = (0..meshes).map(|_| mesh(&mut reader)).collect::<Result<_, _>>()?;
        let objects: Vec<u32> = reader.array("the mesh of each object", objects.into())?;
        if let Some(i) = objects.iter().position(|&mesh| mesh as usize >= meshes.len()) {
            let back = 4 * (objects.len() - i) as u64;
            let what = format!("object {i} has mesh {} of {}", objects[i], meshes.len());
            return Err(reader.invalid(back, what));
        }
        let size = match kind {
            Kind::SelfMesh => size_of_val(&meshes[0].positions[..]),
            Kind::Pair | Kind::Many => objects.len() * size_of::<Pose>(),
        };
        // Else any number of frames would take no bytes, but time.
        if size == 0 && frames > 0 {
            return Err(reader.invalid(0, format!("{frames} frames of nothing")));
        }
        reader.fits("the frames", frames.into(), size)?;
        reader.ends_after("the frames", u64::from(frames) * size as u64)?;
        let (poses, positions) = match kind {
            _ if frames == 0 => (Vec::new(), Vec::new()),
            Kind::SelfMesh => (Vec::new(), meshes[0].positions.clone()),
            Kind::Pair | Kind::Many => (vec![Pose::IDENTITY; objects.len()], Vec::new()),
        };
        let header = Header { kind, meshes, objects, frames };
        Ok((header, Self { kind, frames, reader, next: 0, poses, positions }))
    }

    /// The next frame, `None` after the last.
    ///
    /// # Errors
    /// If it cannot be read, or moves the first object of a pair.
    pub fn next_frame(&mut self) -> Result<Option<Frame<'_>>> {
        if self.next == self.frames {
            return Ok(None);
        }
        self.next += 1;
        if self.kind == Kind::SelfMesh {
            self.reader.words("the positions of a frame", &mut self.positions)?;
            return Ok(Some(Frame::Positions(&self.positions)));
        }
        self.reader.words("the poses of a frame", &mut self.poses)?;
        if self.kind == Kind::Pair && self.poses[0] != Pose::IDENTITY {
            let back = size_of_val(&self.poses[..]) as u64;
            return Err(self.reader.invalid(back, "object 0 of a pair is not at the identity"));
        }
        Ok(Some(Frame::Poses(&self.poses)))
    }
}

fn mesh<R: Read + Seek>(reader: &mut Reader<R>) -> Result<MeshData> {
    let vertices = reader.u32("the number of vertices")?;
    let triangles = reader.u32("the number of triangles")?;
    Ok(MeshData {
        positions: reader.array("the positions of a mesh", vertices.into())?,
        triangles: reader.array("the triangles of a mesh", triangles.into())?,
    })
}

/// Writes a workload; it is whole after as many frames as its header announces.
#[derive(Debug)]
pub struct WorkloadWriter<W> {
    to: W,
}

impl<W: Write> WorkloadWriter<W> {
    /// Writes all but the frames.
    ///
    /// # Errors
    /// Fails as `to` does, or if there is more of something than u32 can count; so do the other methods.
    pub fn new(mut to: W, header: &Header) -> io::Result<Self> {
        let number = |n: usize| {
            u32::try_from(n)
                .map_err(|_| io::Error::other(format!("{n} is more than u32 can count")))
        };
        let kind = match header.kind {
            Kind::Pair => 0,
            Kind::SelfMesh => 1,
            Kind::Many => 2,
        };
        let [meshes, objects] = [number(header.meshes.len())?, number(header.objects.len())?];
        to.write_all(MAGIC)?;
        write_words(&mut to, &[kind, meshes, objects, header.frames])?;
        for mesh in &header.meshes {
            write_words(&mut to, &[number(mesh.positions.len())?, number(mesh.triangles.len())?])?;
            write_words(&mut to, &mesh.positions)?;
            write_words(&mut to, &mesh.triangles)?;
        }
        write_words(&mut to, &header.objects)?;
        Ok(Self { to })
    }

    /// Writes the next frame.
    pub fn frame(&mut self, frame: Frame<'_>) -> io::Result<()> {
        match frame {
            Frame::Poses(poses) => write_words(&mut self.to, poses),
            Frame::Positions(positions) => write_words(&mut self.to, positions),
        }
    }

    /// Gives back where it was written to, which may have a buffer.
    pub fn finish(self) -> W {
        self.to
    }
}
