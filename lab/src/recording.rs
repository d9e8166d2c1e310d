//! Where frames come from: a workload file, or a built-in scene, which needs none.

use anyhow::{Context, Result, ensure};
use pfront::Pose;
use pfront_cli::mesh::MeshData;
use pfront_lab::workload::{Frame, Header, Workload};
use pfront_testkit::scenes::{Kind, Scene, TriMesh};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

pub(crate) enum Recording {
    File(Workload<BufReader<File>>),
    Scene(Box<SceneFrames>),
}

pub(crate) struct SceneFrames {
    scene: Scene,
    frames: u32,
    next: u32,
    rows: Vec<pfront_testkit::scenes::Pose>,
    poses: Vec<Pose>,
    positions: Vec<[f32; 3]>,
}

impl Recording {
    /// What `name` means: the built-in scene, in about `size` triangles, or else the file; no more than
    /// `frames` of it.
    pub(crate) fn open(name: &str, size: Option<usize>, frames: Option<u32>) -> Result<Self> {
        if Scene::NAMES.contains(&name) {
            let scene = Scene::by_name(name, size)?;
            let frames = frames.map_or_else(|| u32::try_from(scene.frames()), Ok)?;
            let (rows, poses, positions) = Default::default();
            let frames = SceneFrames { scene, frames, next: 0, rows, poses, positions };
            return Ok(Self::Scene(Box::new(frames)));
        }
        let hint = || match Path::new(name).extension() {
            Some(_) => format!("reading {name}"),
            None => format!("reading {name} (built-in scenes: {})", Scene::NAMES.join(", ")),
        };
        ensure!(size.is_none(), "--size is for built-in scenes: {}", Scene::NAMES.join(", "));
        let file = File::open(name).with_context(hint)?;
        let mut workload = Workload::open(BufReader::new(file)).with_context(hint)?;
        workload.shorten(frames.unwrap_or(u32::MAX));
        Ok(Self::File(workload))
    }

    /// Hands over what frames have in common.
    pub(crate) fn take_header(&mut self) -> Result<Header> {
        let SceneFrames { scene, frames, .. } = match self {
            Self::File(workload) => return Ok(workload.take_header()),
            Self::Scene(scene) => &**scene,
        };
        let mesh = |mesh: &TriMesh| MeshData {
            positions: mesh.positions.clone(),
            triangles: mesh.triangles.clone(),
        };
        let objects = scene.objects.iter().map(|&mesh| u32::try_from(mesh));
        Ok(Header {
            kind: scene.kind(),
            meshes: scene.meshes.iter().map(mesh).collect(),
            objects: objects.collect::<Result<_, _>>()?,
            frames: *frames,
        })
    }

    /// The next frame, `None` after the last.
    pub(crate) fn next_frame(&mut self) -> Result<Option<Frame<'_>>> {
        match self {
            Self::File(workload) => Ok(workload.next_frame()?),
            Self::Scene(scene) => Ok(scene.next_frame()),
        }
    }
}

impl SceneFrames {
    fn next_frame(&mut self) -> Option<Frame<'_>> {
        if self.next == self.frames {
            return None;
        }
        let frame = self.next as usize;
        self.next += 1;
        if self.scene.kind() == Kind::SelfMesh {
            self.scene.positions(frame, &mut self.positions);
            return Some(Frame::Positions(&self.positions));
        }
        self.scene.poses(frame, &mut self.rows);
        self.poses.clear();
        self.poses.extend(self.rows.iter().map(|&rows| Pose::new(rows)));
        Some(Frame::Poses(&self.poses))
    }
}
