//! Frames of a workload file, of a built-in scene, which needs no file, or of meshes that are set in motion.

use crate::workload::{Frame, Header, Workload};
use anyhow::{Context, Result, ensure};
use pfront::Pose;
use pfront_files::{FORMATS, TriangleMesh, read_f32};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::{Kind, Scene};
use std::ffi::OsStr;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Frames to come.
pub struct Recording(Source);

enum Source {
    File(Workload<BufReader<File>>),
    Made { motion: Motion, frames: u32, next: u32, poses: Vec<Pose>, positions: Vec<[f32; 3]> },
}

enum Motion {
    Scene(Box<Scene>),
    /// Two of a mesh, the second so far along x and swaying by a tenth of that.
    Sway(f32),
    /// The vertices of several files in turn.
    Turns(Vec<Vec<[f32; 3]>>),
}

/// Frames of meshes that are set in motion, unless others are asked for.
const FRAMES: u32 = 64;

impl Recording {
    /// Opens what `name` means: the built-in scene, in about `size` triangles; a mesh file, for two of the mesh, the second
    /// swaying; several of the same triangles, separated by commas, for one mesh whose vertices change in turn; or else the
    /// workload; no more than `frames` of it. Returns what frames have in common as well.
    ///
    /// # Errors
    /// If there is no such scene or file, or the file is neither a mesh nor a workload.
    pub fn open(name: &str, size: Option<usize>, frames: Option<u32>) -> Result<(Header, Self)> {
        let scenes = || format!("built-in scenes: {}", Scene::NAMES.join(", "));
        if Scene::NAMES.contains(&name) {
            let scene = Box::new(Scene::by_name(name, size)?);
            let frames = frames.map_or_else(|| u32::try_from(scene.frames()), Ok)?;
            let objects = scene.objects.iter().map(|&mesh| mesh as u32).collect();
            let (kind, meshes) = (scene.kind(), scene.meshes.clone());
            let header = Header { kind, meshes, objects, frames };
            return Ok((header, Self::made(Motion::Scene(scene), frames)));
        }
        ensure!(size.is_none(), "--size is for {}", scenes());
        let is_mesh = |file: &str| {
            let extension = Path::new(file).extension().and_then(OsStr::to_str).unwrap_or("");
            FORMATS.contains(&extension.to_lowercase().as_str())
        };
        if name.split(',').all(is_mesh) {
            return Self::of_meshes(name, frames.unwrap_or(FRAMES));
        }
        let file =
            File::open(name).with_context(|| format!("cannot read {name} ({})", scenes()))?;
        let read = Workload::open(BufReader::new(file)).with_context(|| name.to_owned());
        let (mut header, mut workload) = read?;
        workload.frames = workload.frames.min(frames.unwrap_or(u32::MAX));
        header.frames = workload.frames;
        Ok((header, Self(Source::File(workload))))
    }

    fn of_meshes(names: &str, frames: u32) -> Result<(Header, Self)> {
        let read = |file| {
            let TriangleMesh { positions, triangles } = read_f32(Path::new(file))?;
            anyhow::Ok(MeshData { positions, triangles })
        };
        let meshes = names.split(',').map(read).collect::<Result<Vec<_>>>()?;
        let is_alike = |two: &[MeshData]| {
            two[0].triangles == two[1].triangles && two[0].positions.len() == two[1].positions.len()
        };
        ensure!(meshes.windows(2).all(is_alike), "{names}: not one mesh, its triangles differ");
        let xs = || meshes[0].positions.iter().map(|p| p[0]);
        let extent = xs().fold(f32::MIN, f32::max) - xs().fold(f32::MAX, f32::min);
        let (kind, objects, motion) = match &meshes[..] {
            [_] => (Kind::Pair, vec![0, 0], Motion::Sway(0.1 * extent)),
            all => {
                let positions = all.iter().map(|mesh| mesh.positions.clone()).collect();
                (Kind::SelfMesh, vec![0], Motion::Turns(positions))
            }
        };
        let meshes = meshes.into_iter().take(1).collect();
        Ok((Header { kind, meshes, objects, frames }, Self::made(motion, frames)))
    }

    fn made(motion: Motion, frames: u32) -> Self {
        let (poses, positions) = Default::default();
        Self(Source::Made { motion, frames, next: 0, poses, positions })
    }

    /// The next frame, `None` after the last.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn next_frame(&mut self) -> Result<Option<Frame<'_>>> {
        let (motion, frames, next, poses, positions) = match &mut self.0 {
            Source::File(workload) => return workload.next_frame(),
            Source::Made { motion, frames, next, poses, positions } => {
                (motion, frames, next, poses, positions)
            }
        };
        if next == frames {
            return Ok(None);
        }
        let frame = *next as usize;
        *next += 1;
        match motion {
            Motion::Scene(scene) if scene.kind() == Kind::SelfMesh => {
                scene.positions(frame, positions);
                return Ok(Some(Frame::Positions(positions)));
            }
            Motion::Scene(scene) => {
                let mut rows = Vec::new();
                scene.poses(frame, &mut rows);
                poses.clear();
                poses.extend(rows.into_iter().map(Pose::new));
            }
            Motion::Sway(x) => {
                let x = *x * (1.0 + 0.1 * (0.1 * frame as f32).sin());
                *poses = vec![Pose::IDENTITY, Pose::from_translation([x, 0.0, 0.0])];
            }
            Motion::Turns(all) => return Ok(Some(Frame::Positions(&all[frame % all.len()]))),
        }
        Ok(Some(Frame::Poses(poses)))
    }
}
