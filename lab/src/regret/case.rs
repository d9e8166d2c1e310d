//! A case: what moves, how, and what is asked of each frame.

use crate::engine::{Engine, EngineError, Objects};
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
        match (self.objects.kind(), self.objects.models()) {
            (Kind::SelfMesh, [model]) => Objects::within(Arc::new(Model::clone(model))),
            _ => self.objects.clone(),
        }
    }
}

impl Frame {
    /// Moves what moves.
    ///
    /// # Errors
    /// Those of the engine.
    pub fn apply(&self, engine: &mut dyn Engine) -> Result<(), EngineError> {
        match self {
            Self::Poses(moves) => {
                moves.iter().try_for_each(|&(object, pose)| engine.place(object, pose))
            }
            Self::Positions(positions) => engine.deform(positions),
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
    /// Those of the engine.
    pub fn ask(self, engine: &mut dyn Engine) -> Result<u64, EngineError> {
        match self {
            Self::All => Ok(engine.find()? as u64),
            Self::Any => Ok(u64::from(engine.any()?.is_some())),
            Self::Count => engine.count(),
        }
    }

    /// Asks for what every engine must answer alike: all pairs, as a hash, or a number. Which pair `any`
    /// finds is anyone's choice.
    ///
    /// # Errors
    /// Those of the engine.
    pub fn digest(self, engine: &mut dyn Engine) -> Result<u64, EngineError> {
        if self != Self::All {
            return self.ask(engine);
        }
        let mut hasher = DefaultHasher::new();
        engine.all()?.hash(&mut hasher);
        Ok(hasher.finish())
    }
}
