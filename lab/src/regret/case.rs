//! A case: what moves, how, and what is asked of each frame.

use crate::player::{Objects, Player};
use anyhow::Result;
use pfront::{Model, Pose};
use pfront_testkit::scenes::Kind;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

/// What is asked of each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verb {
    /// All pairs, sorted.
    All,
    /// Whether anything meets.
    Any,
    /// How many pairs meet.
    Count,
}

/// What moves in a frame; all else stays where it is.
#[derive(Clone, Debug, PartialEq)]
pub enum Frame {
    /// Objects, and where each is now.
    Poses(Vec<(usize, Pose)>),
    /// The vertices of the one mesh.
    Positions(Vec<[f32; 3]>),
}

/// Objects over some frames.
#[derive(Debug)]
pub struct Case {
    /// Its number and kind.
    pub name: String,
    /// How its objects move.
    pub class: String,
    /// What is asked about.
    pub objects: Objects,
    /// What moves.
    pub frames: Vec<Frame>,
    /// What is asked.
    pub verb: Verb,
}

impl Case {
    /// Its objects for one play, with a model of its own where that deforms: whoever refits a shared one
    /// copies it first.
    #[must_use]
    pub fn fresh(&self) -> Objects {
        let mut objects = self.objects.clone();
        if let (Kind::SelfMesh, [model]) = (objects.kind, &mut objects.models[..]) {
            *model = Arc::new(Model::clone(model));
        }
        objects
    }
}

impl Frame {
    /// Moves what moves.
    ///
    /// # Errors
    /// Those of the player.
    pub fn apply(&self, player: &mut Player) -> Result<()> {
        match self {
            Self::Poses(moves) => {
                moves.iter().try_for_each(|&(object, pose)| player.place(object, pose))
            }
            Self::Positions(positions) => player.deform(positions),
        }
    }
}

impl Verb {
    /// What tables call it.
    #[must_use]
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
    /// Those of the player.
    pub fn ask(self, player: &mut Player) -> Result<u64> {
        match self {
            Self::All => Ok(player.find()? as u64),
            Self::Any => Ok(u64::from(player.any()?)),
            Self::Count => player.count(),
        }
    }

    /// Asks for what every executor must answer alike: all pairs, as a hash, or a number. Which pair `any`
    /// finds is anyone's choice.
    ///
    /// # Errors
    /// Those of the player.
    pub fn digest(self, player: &mut Player) -> Result<u64> {
        if self != Self::All {
            return self.ask(player);
        }
        let mut hasher = DefaultHasher::new();
        player.all()?.hash(&mut hasher);
        Ok(hasher.finish())
    }
}
