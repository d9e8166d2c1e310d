//! A case: what moves, how, and what is asked of each frame.

use crate::player::{Objects, Player};
use crate::recording::Recording;
use crate::workload::Frame;
use anyhow::Result;
use pfront::{Model, Pose};
use pfront_testkit::scenes::Kind;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::Arc;

/// The question of each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verb {
    /// All pairs, sorted.
    All,
    /// Whether anything meets.
    Any,
    /// How many pairs meet.
    Count,
}

/// The objects or vertices that move in a frame; all others stay where they are.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Moved {
    /// Objects, and where each is now.
    Poses(Vec<(usize, Pose)>),
    /// The vertices of the one mesh.
    Positions(Vec<[f32; 3]>),
}

/// Objects over some frames.
#[derive(Debug)]
pub struct Case {
    /// Its number and kind, or the name of a workload.
    pub name: String,
    /// How its objects move.
    pub class: String,
    /// The objects.
    pub objects: Objects,
    /// The question.
    pub verb: Verb,
    pub(super) frames: Vec<Moved>,
}

/// A case without a name and a question, as the makers of cases return it.
pub(super) struct Built {
    pub(super) class: String,
    pub(super) objects: Objects,
    pub(super) frames: Vec<Moved>,
}

impl Case {
    /// The first `frames` frames of a workload, each asked for all pairs; a file is played to and fro where it is shorter.
    ///
    /// # Errors
    /// As [`Recording::open`]; if a mesh is refused.
    pub fn of_workload(name: &str, frames: u32) -> Result<Self> {
        let (header, mut recording) = Recording::open(name, None, Some(frames))?;
        let objects = Objects::new(header)?;
        let mut there = Vec::new();
        while let Some(frame) = recording.next_frame()? {
            there.push(match frame {
                Frame::Poses(poses) => Moved::Poses(poses.iter().copied().enumerate().collect()),
                Frame::Positions(positions) => Moved::Positions(positions.to_vec()),
            });
        }
        let back = there.iter().rev().skip(1).chain(there.iter().skip(1));
        let rest = back.cloned().cycle().take(frames as usize - there.len());
        let frames = there.iter().cloned().chain(rest).collect();
        let class = "workload".to_owned();
        let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy();
        Ok(Self { name: stem.into_owned(), class, objects, verb: Verb::All, frames })
    }

    /// Its objects for one play, with a model of its own where that deforms: whoever refits a shared one
    /// copies it first.
    pub fn fresh(&self) -> Objects {
        let mut objects = self.objects.clone();
        if let (Kind::SelfMesh, [model]) = (objects.kind, &mut objects.models[..]) {
            *model = Arc::new(Model::clone(model));
        }
        objects
    }
}

impl Moved {
    /// Moves what moves.
    ///
    /// # Errors
    /// Fails as the player does.
    pub(super) fn apply(&self, player: &mut Player) -> Result<()> {
        match self {
            Self::Poses(moves) => {
                moves.iter().try_for_each(|&(object, pose)| player.place(object, pose))
            }
            Self::Positions(positions) => player.update(Frame::Positions(positions)),
        }
    }
}

impl Verb {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Any => "any",
            Self::Count => "count",
        }
    }

    /// Asks, and drops the answer but for its size.
    ///
    /// # Errors
    /// Fails as the player does.
    pub fn ask(self, player: &mut Player) -> Result<u64> {
        match self {
            Self::All => Ok(player.find()? as u64),
            Self::Any => Ok(u64::from(player.any()?)),
            Self::Count => player.count(),
        }
    }

    /// Asks for what every executor must answer alike: all pairs, as a hash, or a number. Executors may differ
    /// in the pair that `any` finds.
    ///
    /// # Errors
    /// Fails as the player does.
    pub fn digest(self, player: &mut Player) -> Result<u64> {
        if self != Self::All {
            return self.ask(player);
        }
        let mut hasher = DefaultHasher::new();
        player.all()?.hash(&mut hasher);
        Ok(hasher.finish())
    }
}
