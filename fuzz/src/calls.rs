//! Sequences of calls, and the world in which they are made.

use crate::input::{Ask, Build, Palette, Placing, Shape, Step};
use crate::world::World;
use arbitrary::Arbitrary;

/// Two bodies, at most 16 steps, and how everything is asked at the end.
#[derive(Arbitrary, Debug)]
pub struct Calls {
    palette: Palette,
    first: [(Shape, Placing, Build); 2],
    last: Ask,
    steps: Vec<Step>,
}

impl Calls {
    /// Makes them in an empty world.
    ///
    /// # Panics
    /// If an answer is wrong, or two of them differ.
    pub fn run(&self) {
        let mut world = World::new(self.palette);
        for (shape, placing, build) in &self.first {
            world.add(shape, *placing, *build);
        }
        self.steps.iter().take(16).for_each(|step| world.step(step));
        world.ask_everything(self.last);
    }
}
