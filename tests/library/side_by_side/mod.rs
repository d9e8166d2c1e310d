//! Queries of every kind, side by side on the same executors, answer as fresh ones do: a random player asks, edits, deforms and
//! cancels.
//!
//! Pair and self queries are compared with fresh sequential ones about models that were just built; scenes with the union of
//! those about all pairs of bodies, posed into the world here; tickets with what was true when they were submitted.
//!
//! `PFRONT_FRAMES` says how many questions there are, 100000 for a long run, `PFRONT_SEED` where they begin. The game is the
//! same for the same seed; when threads see a flag is not.

mod asked;
mod batches;
mod executors;
mod models;
mod scenes;
mod truth;

use asked::{Asked, Between, Within};
use batches::BatchPlayer;
use executors::{Executors, QueryExecutor};
use models::{Shape, set_positions, shapes, somewhere};
use pfront::executor::{Backend, Plan};
use pfront::{Adjacency, AnyPose, PairQuery, SelfQuery};
use pfront_testkit::rng::{Rng, RngExt, seeded};
use scenes::ScenePlayer;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use truth::{Answers, Truth};

/// Queries of one kind that begin on each executor.
const PAIRS: usize = 3;
const SELVES: usize = 3;
const SCENES: usize = 2;

#[derive(Clone)]
struct Pair {
    query: PairQuery,
    seat: QueryExecutor,
    models: [usize; 2],
    pose: AnyPose,
}

#[derive(Clone)]
struct SelfPlayer {
    query: SelfQuery,
    adjacency: Adjacency,
    seat: QueryExecutor,
    model: usize,
}

/// All that is played with.
struct Game {
    executors: Executors,
    shapes: Vec<Shape>,
    answers: Answers,
    pairs: Vec<Pair>,
    selves: Vec<SelfPlayer>,
    stages: Vec<ScenePlayer>,
    posts: Vec<BatchPlayer>,
    /// Questions with a hit, and questions that several threads have answered, on each executor.
    figures: Vec<[u64; 2]>,
}

impl Game {
    fn new(rng: &mut impl Rng) -> Self {
        let (executors, shapes) = (Executors::new(), shapes());
        let mut some = || rng.random_range(0..shapes.len());
        let seats =
            |each| (0..executors.all.len() * each).map(move |i| QueryExecutor::at(i / each));
        let pairs = seats(PAIRS).map(|seat| {
            let query = PairQuery::new().on(executors.executor(seat));
            Pair { query, seat, models: [some(), some()], pose: pfront::Pose::IDENTITY.into() }
        });
        let pairs = pairs.collect();
        let selves = seats(SELVES).zip(0..).map(|(seat, i)| {
            let adjacency = match i % SELVES {
                0 => Adjacency::SkipNeighbours,
                _ => Adjacency::default(),
            };
            let query = SelfQuery::new().with_adjacency(adjacency).on(executors.executor(seat));
            SelfPlayer { query, adjacency, seat, model: some() }
        });
        let selves = selves.collect();
        let stages = seats(SCENES).map(|seat| ScenePlayer::new(seat, &executors)).collect();
        let posts = seats(1).map(BatchPlayer::new).collect();
        let (answers, figures) = (Answers::default(), vec![[0; 2]; executors.all.len()]);
        Self { executors, shapes, answers, pairs, selves, stages, posts, figures }
    }

    /// A frame: some changes and a question.
    fn play(&mut self, rng: &mut impl Rng) {
        while rng.random_range(0..3) == 0 {
            let at = rng.random_range(0..self.shapes.len());
            let by_query = rng.random_range(0..self.selves.len());
            let (shape, way) = (&mut self.shapes[at], rng.random_range(0..6));
            if way == 5 {
                let query = &mut self.selves[by_query].query;
                shape.deform(rng, |model, points| query.set_positions(model, points).unwrap());
            } else {
                shape.deform(rng, set_positions(way));
            }
        }
        match rng.random_range(0..20) {
            0..8 => self.ask_pair(rng),
            8..12 => self.ask_self(rng),
            12..17 => self.ask_scene(rng),
            _ => {
                let at = rng.random_range(0..self.posts.len());
                self.posts[at].play(&self.executors, &self.shapes, &mut self.answers, rng);
            }
        }
    }

    fn ask_pair(&mut self, rng: &mut impl Rng) {
        let Self { executors, shapes, answers, pairs, .. } = self;
        let at = rng.random_range(0..pairs.len());
        match rng.random_range(0..64) {
            0 => pairs[at].query.forget(),
            1 => pairs[at] = pairs[rng.random_range(0..pairs.len())].clone(),
            2 | 3 => {
                pairs[at].seat = executors.elsewhere(rng);
                let query = std::mem::take(&mut pairs[at].query);
                pairs[at].query = query.on(executors.executor(pairs[at].seat));
            }
            4..7 => pairs[at].models[rng.random_range(0..2)] = rng.random_range(0..shapes.len()),
            7 | 8 => pairs[at].models.swap(0, 1),
            9..40 => pairs[at].pose = somewhere(rng),
            _ => {}
        }
        let Pair { query, seat, models, pose } = &mut pairs[at];
        let [a, b] = models.map(|model| &shapes[model]);
        let answer = answers.pair([&a.fresh, &b.fresh], pose);
        let mut asked = Between(query, [&a.model, &b.model], *pose);
        executors.ask(rng, *seat, |verb, most| {
            let mut truth = Truth::default();
            truth.add(&answer, verb, |pair| pair);
            asked.compare(&truth, verb, most)
        });
        let (executor, has_hit) = (seat.executor, !answer.pairs.is_empty());
        let is_divided = is_divided(query.plan());
        self.note(executor, has_hit, is_divided);
    }

    fn ask_self(&mut self, rng: &mut impl Rng) {
        let Self { executors, shapes, answers, selves, .. } = self;
        let at = rng.random_range(0..selves.len());
        match rng.random_range(0..48) {
            0 => selves[at].query.forget(),
            1 => selves[at] = selves[rng.random_range(0..selves.len())].clone(),
            2 | 3 => {
                selves[at].seat = executors.elsewhere(rng);
                let query = std::mem::take(&mut selves[at].query);
                selves[at].query = query.on(executors.executor(selves[at].seat));
            }
            4..14 => selves[at].model = rng.random_range(0..shapes.len()),
            _ => {}
        }
        let SelfPlayer { query, adjacency, seat, model } = &mut selves[at];
        let shape = &shapes[*model];
        let answer = answers.within(&shape.fresh, *adjacency);
        let mut asked = Within(query, &shape.model);
        executors.ask(rng, *seat, |verb, most| {
            let mut truth = Truth::default();
            truth.add(&answer, verb, |pair| pair);
            asked.compare(&truth, verb, most)
        });
        let (executor, is_divided) = (seat.executor, is_divided(query.plan()));
        self.note(executor, !answer.pairs.is_empty(), is_divided);
    }

    fn ask_scene(&mut self, rng: &mut impl Rng) {
        let Self { executors, shapes, answers, stages, .. } = self;
        let at = rng.random_range(0..stages.len());
        match rng.random_range(0..100) {
            0 => stages[at] = stages[rng.random_range(0..stages.len())].clone(),
            1 | 2 => {
                stages[at].seat = executors.elsewhere(rng);
                let scene = std::mem::take(&mut stages[at].scene);
                stages[at].scene = scene.on(executors.executor(stages[at].seat));
            }
            _ => {}
        }
        for _ in 0..rng.random_range(0..4) {
            stages[at].edit(shapes, rng);
        }
        let stage = &mut stages[at];
        let (seat, mut has_hit) = (stage.seat, false);
        executors.ask(rng, seat, |verb, most| {
            let truth = stage.truth(answers, verb);
            has_hit = !truth.hits.is_empty();
            stage.scene.compare(&truth, verb, most)
        });
        let is_divided = is_divided(stage.scene.plan());
        self.note(seat.executor, has_hit, is_divided);
    }

    fn note(&mut self, executor: usize, has_hit: bool, is_divided: bool) {
        let [hits, divided] = &mut self.figures[executor];
        *hits += u64::from(has_hit);
        *divided += u64::from(is_divided);
    }
}

/// Whether several threads have answered.
fn is_divided(plan: Option<&Plan>) -> bool {
    plan.is_some_and(|plan| plan.backend == Backend::Threads)
}

fn from_environment(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap())
}

#[test]
fn queries_side_by_side_answer_as_fresh_ones() {
    let frames = from_environment("PFRONT_FRAMES").unwrap_or(2_000);
    let seed = from_environment("PFRONT_SEED").unwrap_or(1);
    let mut rng = seeded(seed);
    let mut game = Game::new(&mut rng);
    for frame in 0..frames {
        let played = catch_unwind(AssertUnwindSafe(|| game.play(&mut rng)));
        played.unwrap_or_else(|panic| {
            eprintln!("PFRONT_SEED={seed}, frame {frame}");
            resume_unwind(panic)
        });
    }
    println!("{frames} frames, {} questions cancelled", game.executors.cancelled);
    for (executor, [hits, divided]) in game.executors.all.iter().zip(&game.figures) {
        println!("{}: {hits} questions with hits, {divided} divided", executor.name);
        assert!(frames < 1_000 || hits * 20 > frames / game.figures.len() as u64);
        // The others go by what they measure.
        assert!(frames < 1_000 || executor.name != "static" || divided * 200 > frames);
    }
    assert!(frames < 1_000 || game.executors.cancelled * 200 > frames);
}
