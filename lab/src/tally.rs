//! The backends that answered many frames, counted.

use pfront::executor::{Backend, Plan};
use std::fmt;

/// How often which backend answered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Frames of each kind of [`Backend`], in the order of [`Tally::NAMES`].
    pub frames: [usize; 4],
    /// How often one frame was answered by another backend than the last.
    pub changes: usize,
    last: Option<usize>,
}

impl Tally {
    /// The kinds of backend.
    pub const NAMES: [&str; 4] = ["kept", "one thread", "threads", "GPU"];

    /// Adds a frame.
    pub fn add(&mut self, plan: &Plan) {
        let kind = match plan.backend {
            Backend::Cached => 0,
            Backend::Threads => 2,
            Backend::Gpu => 3,
            _ => 1,
        };
        self.frames[kind] += 1;
        self.changes += usize::from(self.last.replace(kind).is_some_and(|last| last != kind));
    }

    /// The backend that answered most often.
    pub fn mostly(&self) -> &'static str {
        let most = (0..self.frames.len()).rev().max_by_key(|&kind| self.frames[kind]);
        most.map_or("", |kind| Self::NAMES[kind])
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} frames", self.frames.iter().sum::<usize>())?;
        let mut before = ": ";
        for (name, count) in Self::NAMES.iter().zip(self.frames).filter(|(_, count)| *count > 0) {
            write!(f, "{before}{count} {name}")?;
            before = ", ";
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront::{Model, PairQuery, Pose};

    #[test]
    fn frames_are_told_apart_by_who_answered() {
        let model = Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        let (mut query, mut tally) = (PairQuery::new(), Tally::default());
        for x in [0.0, 1.0, 1.0, 1.0, 0.0] {
            query.all(&model, &model, Pose::from_translation([x, 0.0, 0.0])).unwrap();
            tally.add(query.plan().unwrap());
        }
        assert_eq!((tally.changes, tally.mostly()), (2, "one thread"));
        assert_eq!(tally.to_string(), "5 frames: 2 kept, 3 one thread");
    }
}
