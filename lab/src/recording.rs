//! Frames of a workload file, or of a built-in scene, which needs no file.

use crate::workload::{Frame, Header, Workload};
use anyhow::{Context, Result, ensure};
use pfront::Pose;
use pfront_cli::mesh::MeshData;
use pfront_testkit::scenes::{Kind, Scene, TriMesh};
use std::fs::File;
use std::io::BufReader;

/// Frames to come.
pub struct Recording(Source);

enum Source {
    File(Workload<BufReader<File>>),
    Scene { scene: Box<Scene>, frames: u32, next: u32, poses: Vec<Pose>, positions: Vec<[f32; 3]> },
}

impl Recording {
    /// Opens what `name` means: the built-in scene, in about `size` triangles, or else the file; no more than `frames`
    /// of it. Returns what frames have in common as well.
    ///
    /// # Errors
    /// If there is no such scene or file, or the file is not a workload.
    pub fn open(name: &str, size: Option<usize>, frames: Option<u32>) -> Result<(Header, Self)> {
        let scenes = || format!("built-in scenes: {}", Scene::NAMES.join(", "));
        if Scene::NAMES.contains(&name) {
            let scene = Box::new(Scene::by_name(name, size)?);
            let frames = frames.map_or_else(|| u32::try_from(scene.frames()), Ok)?;
            let header = header(&scene, frames);
            let (poses, positions) = Default::default();
            return Ok((header, Self(Source::Scene { scene, frames, next: 0, poses, positions })));
        }
        ensure!(size.is_none(), "--size is for {}", scenes());
        let file =
            File::open(name).with_context(|| format!("cannot read {name} ({})", scenes()))?;
        let mut workload = Workload::open(BufReader::new(file)).with_context(|| name.to_owned())?;
        workload.shorten(frames.unwrap_or(u32::MAX));
        Ok((workload.take_header(), Self(Source::File(workload))))
    }

    /// The next frame, `None` after the last.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn next_frame(&mut self) -> Result<Option<Frame<'_>>> {
        let (scene, frames, next, poses, positions) = match &mut self.0 {
            Source::File(workload) => return Ok(workload.next_frame()?),
            Source::Scene { scene, frames, next, poses, positions } => {
                (scene, frames, next, poses, positions)
            }
        };
        if next == frames {
            return Ok(None);
        }
        let frame = *next as usize;
        *next += 1;
        if scene.kind() == Kind::SelfMesh {
            scene.positions(frame, positions);
            return Ok(Some(Frame::Positions(positions)));
        }
        let mut rows = Vec::new();
        scene.poses(frame, &mut rows);
        poses.clear();
        poses.extend(rows.into_iter().map(Pose::new));
        Ok(Some(Frame::Poses(poses)))
    }
}

/// What all frames of a built-in scene have in common.
pub(crate) fn header(scene: &Scene, frames: u32) -> Header {
    let mesh = |mesh: &TriMesh| MeshData {
        positions: mesh.positions.clone(),
        triangles: mesh.triangles.clone(),
    };
    Header {
        kind: scene.kind(),
        meshes: scene.meshes.iter().map(mesh).collect(),
        objects: scene.objects.iter().map(|&mesh| mesh as u32).collect(),
        frames,
    }
}
