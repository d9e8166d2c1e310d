//! A case, played by everyone in turn.
//!
//! In a first round, which is not counted, all answers are compared, and who is hopelessly slow drops out. In
//! those that follow, everyone plays the whole case with a new query, in another order each time: what else the
//! machine does, and what one play leaves behind for the next, hits all alike. A plan's time is the median over
//! rounds of its total, which is what a user sees, and not the minimum, which is what threads take when nobody
//! else wants the cores. Two plans are compared by the median over rounds of one's time over the other's in the same
//! round: cores of virtual machines are 1.4 times slower for some milliseconds or some seconds when others use
//! their twins, and medians of totals tell of that, more than of plans. The best of the first round plays twice in each:
//! how far it is from itself is how far figures can be trusted.

use super::case::Case;
use super::recipe::samples;
#[cfg(feature = "gpu")]
use super::row::GPU;
use super::row::{HOPELESS, Lane, Row};
use super::scale::Scale;
use crate::median;
use crate::player::Player;
use crate::tally::Tally;
use anyhow::{Result, ensure};
use pfront::Executor;
#[cfg(feature = "gpu")]
use pfront::gpu::Gpu;
use pfront::threads::Pool;
use pfront_testkit::rng::{seeded, seq::SliceRandom};
use rayon::ThreadPoolBuilder;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// All who play a case.
pub struct Field {
    /// Plans that never change, each with its name; the first is one thread.
    pub fixed: Vec<(String, Executor)>,
    /// The one that chooses.
    pub chooser: Executor,
    /// The most threads of any.
    pub threads: usize,
}

impl Field {
    /// One thread; 2, 4, 8 … of them, and all `threads`, of which the last also chooses.
    ///
    /// # Errors
    /// If there is no pool of as many threads.
    pub fn new(threads: usize) -> Result<Self> {
        let mut chooser = Executor::sequential();
        let mut fixed = vec![("sequential".to_owned(), chooser.clone())];
        let powers = (1..).map(|i| 1 << i).take_while(|&p| p < threads);
        for p in powers.chain((threads > 1).then_some(threads)) {
            let pool = Arc::new(ThreadPoolBuilder::new().num_threads(p).build()?);
            chooser = Executor::from(Pool::from(pool));
            fixed.push((format!("{p} threads"), chooser.clone()));
        }
        Ok(Self { fixed, chooser, threads })
    }

    /// Adds a GPU to the fixed plans, and to the choice.
    ///
    /// # Errors
    /// If the GPU fails while it is measured.
    #[cfg(feature = "gpu")]
    pub fn with_gpu(mut self, gpu: &Gpu) -> Result<Self> {
        self.fixed.push((GPU.to_owned(), Executor::gpu(gpu, gpu.settings())));
        self.chooser = self.chooser.and_gpu(gpu, gpu.settings())?;
        Ok(self)
    }

    /// Lets everyone play something of each kind, so that threads are up and shaders compiled before anything is
    /// timed.
    ///
    /// # Errors
    /// As [`race`].
    pub fn warm_up(&self) -> Result<()> {
        for recipe in samples() {
            let case = recipe.build(&Scale::QUICK)?;
            for executor in self.fixed.iter().map(|lane| &lane.1).chain([&self.chooser]) {
                match play(&case, executor) {
                    Err(error) if lacks_memory(&error) => continue,
                    played => played?,
                };
            }
        }
        Ok(())
    }
}

/// Whether a GPU lacks the memory for a question, which is no fault of it.
fn lacks_memory(error: &anyhow::Error) -> bool {
    #[cfg(feature = "gpu")]
    if let Some(pfront::Error::Gpu(error)) = error.downcast_ref() {
        use pfront::gpu::GpuError::{OutOfMemory, TooLarge};
        return matches!(error, TooLarge { .. } | OutOfMemory { .. });
    }
    let _ = error;
    false
}

/// How long to play.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// At least so many rounds, and ...
    pub rounds: usize,
    /// ... as many as go into this, up to forty times as many.
    pub time: Duration,
}

/// Times the rounds asked for.
const MOST: usize = 40;

/// Plays a case.
///
/// # Errors
/// If two do not agree, or a query fails, except that a fixed plan may lack memory.
pub fn race(case: &Case, field: &Field, effort: &Effort) -> Result<Row> {
    ensure!(!field.fixed.is_empty(), "there is no fixed plan to compare with: give one thread");
    let mut rehearsal = Rehearsal { case, digests: Vec::new() };
    // Seconds of the first round of each plan that was played to the end.
    let (mut first, mut best) = (Vec::new(), f64::INFINITY);
    for (name, executor) in &field.fixed {
        // The first is never given up: all others are compared with it.
        let seconds = rehearsal.play(name, executor, HOPELESS * best)?;
        best = best.min(seconds.unwrap_or(f64::INFINITY));
        first.push(seconds);
    }
    rehearsal.play("chooser", &field.chooser, f64::INFINITY)?;
    let mut turns: Vec<usize> = (0..first.len()).filter(|&lane| first[lane].is_some()).collect();
    let twin = turns.iter().copied().find(|&lane| first[lane] == Some(best)).unwrap_or(0);
    let (chooser, again) = (first.len(), first.len() + 1);
    turns.extend([chooser, again]);

    let mut random = seeded(0);
    let mut times = vec![Vec::new(); first.len() + 2];
    let clock = Instant::now();
    let mut rounds = 0;
    while rounds < effort.rounds || rounds < MOST * effort.rounds && clock.elapsed() < effort.time {
        turns.shuffle(&mut random);
        for &turn in &turns {
            let executor = match turn {
                turn if turn == chooser => &field.chooser,
                turn if turn == again => &field.fixed[twin].1,
                lane => &field.fixed[lane].1,
            };
            times[turn].push(play(case, executor)?);
        }
        rounds += 1;
    }
    let noise = over(&times[again], &times[twin]) - 1.0;
    let lanes = field.fixed.iter().enumerate().map(|(lane, (name, _))| Lane {
        name: name.clone(),
        seconds: first[lane].map(|_| median(&mut times[lane].clone())),
        chooser: over(&times[chooser], &times[lane]),
    });
    Ok(Row {
        name: case.name.clone(),
        class: case.class.clone(),
        triangles: case.objects.triangles(),
        bodies: case.objects.models.len(),
        frames: case.frames.len(),
        verb: case.verb,
        rounds,
        threads: field.threads,
        fixed: lanes.collect(),
        chooser: median(&mut times[chooser].clone()),
        noise,
        tally: watch(case, &field.chooser)?,
    })
}

/// The time of one over that of another in the same round, as a median; 0 where the other did not play.
fn over(own: &[f64], other: &[f64]) -> f64 {
    let mut ratios: Vec<_> = own.iter().zip(other).map(|(own, other)| own / other).collect();
    let upper = median(&mut ratios);
    // The upper one of an even number would be unfair.
    let lower = ratios.get(ratios.len().saturating_sub(1) / 2).copied().unwrap_or(0.0);
    0.5 * (lower + upper)
}

/// Seconds that a whole case takes: making the query, which uploads what a GPU needs, and all frames. Models are
/// there.
fn play(case: &Case, executor: &Executor) -> Result<f64> {
    let objects = case.fresh();
    let clock = Instant::now();
    let mut player = Player::new(objects, &executor.into())?;
    for frame in &case.frames {
        frame.apply(&mut player)?;
        case.verb.ask(&mut player)?;
    }
    Ok(clock.elapsed().as_secs_f64())
}

/// Counts the plans of the executor that chooses, in a run after everything else.
fn watch(case: &Case, chooser: &Executor) -> Result<Tally> {
    let mut player = Player::new(case.fresh(), &chooser.into())?;
    let mut tally = Tally::default();
    for frame in &case.frames {
        frame.apply(&mut player)?;
        case.verb.ask(&mut player)?;
        if let Some(plan) = player.plan() {
            tally.add(plan);
        }
    }
    Ok(tally)
}

/// The first round.
struct Rehearsal<'c> {
    case: &'c Case,
    /// The digests of the first player's answers, one for each frame.
    digests: Vec<u64>,
}

impl Rehearsal<'_> {
    /// Plays until more than `most` seconds are over; returns the time if that was to the end.
    fn play(&mut self, name: &str, executor: &Executor, most: f64) -> Result<Option<f64>> {
        let case = self.case;
        let objects = case.fresh();
        let clock = Instant::now();
        let mut player = Player::new(objects, &executor.into())?;
        let mut seconds = clock.elapsed().as_secs_f64();
        for (number, frame) in case.frames.iter().enumerate() {
            let clock = Instant::now();
            frame.apply(&mut player)?;
            let digest = match case.verb.digest(&mut player) {
                Err(error) if lacks_memory(&error) => return Ok(None),
                digest => digest?,
            };
            seconds += clock.elapsed().as_secs_f64();
            if number == self.digests.len() {
                self.digests.push(digest);
            }
            ensure!(
                self.digests[number] == digest,
                "frame {number} of {}: {name} answers otherwise than one thread: please report this",
                case.name
            );
            if seconds > most {
                return Ok(None);
            }
        }
        Ok(Some(seconds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regret::{recipes, summary, write_csv};

    const ONCE: Effort = Effort { rounds: 1, time: Duration::ZERO };

    #[test]
    fn everyone_answers_alike_and_is_timed() {
        let field = Field::new(2).unwrap();
        field.warm_up().unwrap();
        let drawn = recipes(3, 24).into_iter().map(|recipe| recipe.build(&Scale::QUICK).unwrap());
        // The train of gears turns to and fro.
        let cases = drawn.chain([Case::of_workload("epicyclic", 3).unwrap()]);
        let rows: Vec<_> = cases.map(|case| race(&case, &field, &ONCE).unwrap()).collect();
        for row in &rows {
            assert!(row.chooser > 0.0 && row.fixed[0].seconds.is_some(), "{row:?}");
            assert_eq!(row.tally.frames.iter().sum::<usize>(), row.frames, "{row:?}");
            assert!(row.regret() > -1.0, "{row:?}");
        }
        assert!(rows[0].heading().contains("2 threads"));
        assert!(rows[0].to_string().starts_with("pair 1 "), "{}", rows[0]);
        let summary = summary(&rows);
        assert!(summary.contains("25 cases") && summary.contains("regret"), "{summary}");
        let mut lines = Vec::new();
        write_csv(&mut lines, &rows).unwrap();
        let lines = String::from_utf8(lines).unwrap();
        assert!(lines.starts_with("case,what_moves,") && lines.lines().count() == 26, "{lines}");
    }

    #[test]
    fn whoever_is_hopeless_is_not_played_again_and_whoever_differs_is_told() {
        let case = recipes(3, 1)[0].build(&Scale::QUICK).unwrap();
        let mut rehearsal = Rehearsal { case: &case, digests: Vec::new() };
        rehearsal.play("first", &Executor::sequential(), f64::INFINITY).unwrap();
        let threads = Executor::from(Pool::new(2));
        assert_eq!(rehearsal.play("second", &threads, 0.0).unwrap(), None);
        rehearsal.digests[0] ^= 1;
        let error = rehearsal.play("second", &threads, f64::INFINITY).unwrap_err();
        assert!(
            error.to_string().contains("frame 0 of pair 1: second answers otherwise"),
            "{error}"
        );
    }

    #[test]
    fn plans_are_compared_within_a_round() {
        // The machine was slow in the second round, and in the third for one of them.
        let (own, other) = ([1.1, 3.0, 1.2], [1.0, 2.0, 3.0]);
        assert_eq!([over(&own, &other), over(&other, &own)], [1.1, 1.0 / 1.1]);
        assert_eq!([over(&own[1..], &other[1..]), over(&own, &[])], [0.95, 0.0]);
    }

    #[test]
    fn without_a_fixed_plan_there_is_no_regret() {
        let case = recipes(3, 1)[0].build(&Scale::QUICK).unwrap();
        let field = Field { fixed: Vec::new(), chooser: Executor::sequential(), threads: 1 };
        assert!(race(&case, &field, &ONCE).unwrap_err().to_string().contains("one thread"));
    }
}
