//! The schedules by the clock, frame by frame, on the threads of the calling pool.

use super::StabilityError;
use super::scene::{Scene, Shown, Watch};
use pfront::core::bvtt::{Query, TrianglePair};
use pfront::threads::{Schedule, Settings, Traversal};
use std::iter::once;
use std::time::Instant;

/// The shortest of so many runs counts.
const RUNS: usize = 3;

/// What is timed on all threads.
const SCHEDULES: [(&str, Schedule); 3] = [
    ("static partition", Schedule::Static),
    ("work stealing", Schedule::Stealing),
    ("partition, then stealing", Schedule::Hybrid),
];

/// How long the frames of a scene took with one schedule.
#[derive(Clone, Debug)]
pub struct Times {
    /// The schedule.
    pub name: &'static str,
    /// Each frame in milliseconds: the front, the walk, and sorting what was found.
    pub milliseconds: Vec<f64>,
}

/// Times every frame of a scene under each schedule, in turn.
///
/// # Errors
/// As [`Scene::play`].
pub fn time(scene: &mut Scene) -> Result<Vec<Times>, StabilityError> {
    let threads = rayon::current_num_threads();
    let all =
        || once(("one thread", Schedule::Static, 1)).chain(SCHEDULES.map(|(n, s)| (n, s, threads)));
    let times = all().map(|(name, ..)| Times { name, milliseconds: Vec::new() }).collect();
    let mut clock = Clock { traversals: Vec::new(), times };
    for _ in 0..RUNS {
        let traversal = |(_, schedule, workers)| {
            Traversal::new(workers).with_settings(Settings { schedule, ..Settings::default() })
        };
        clock.traversals = all().map(traversal).collect();
        scene.play(&mut clock)?;
    }
    Ok(clock.times)
}

struct Clock {
    traversals: Vec<Traversal>,
    times: Vec<Times>,
}

impl Watch for Clock {
    fn frame<Q: Query + Sync>(&mut self, &Shown { index, .. }: &Shown<'_>, query: &Q) {
        let mut pairs = Vec::<TrianglePair>::new();
        for (traversal, Times { milliseconds, .. }) in
            self.traversals.iter_mut().zip(&mut self.times)
        {
            let clock = Instant::now();
            traversal.all(std::slice::from_ref(query), &mut pairs);
            let taken = 1e3 * clock.elapsed().as_secs_f64();
            match milliseconds.get_mut(index) {
                Some(least) => *least = least.min(taken),
                None => milliseconds.push(taken),
            }
        }
    }
}
