//! Every public question gives the answer of the default floating-point environment, whatever that of the caller or of the
//! thread that made a pool is, and leaves the caller's as it was.

#![expect(unsafe_code, reason = "only machine code can leave the default environment")]

mod models;
mod questions;
mod surface;

use pfront::threads::{Pool, Schedule, Settings, rayon};
use pfront::{Executor, Model};
use std::arch::asm;
use std::sync::Arc;

const DEFAULT: u32 = 0x1f80;
/// Flags of past exceptions.
const FLAGS: u32 = 0x3f;
/// Flushed results, flushed operands, both; rounded down, up and towards zero; every exception traps.
const SETTINGS: [u32; 7] = [0x9f80, 0x1fc0, 0x9fc0, 0x3f80, 0x5f80, 0x7f80, 0x0000];

fn read() -> u32 {
    let mut register = 0_u32;
    // SAFETY: writes the four bytes of `register`.
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut register) };
    register
}

fn write(register: u32) {
    // SAFETY: reads the four bytes of `register`, none of whose reserved bits is set.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const register) };
}

/// The result of `body` while the control register is `setting`, to which it has to come back. There is no arithmetic in floats
/// here, nor in the bodies: with every exception trapping, that would end the process.
#[inline(never)]
fn under<T>(setting: u32, body: impl FnOnce() -> T) -> T {
    write(setting);
    let result = body();
    let after = read();
    write(DEFAULT);
    assert_eq!(after & !FLAGS, setting & !FLAGS, "of the caller");
    result
}

/// Triangles whose coordinates are small multiples of the least number, so that whoever flushes or rounds is wrong about them.
struct Soup {
    positions: Vec<[f32; 3]>,
    /// The same in f64, and as small there.
    positions_f64: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Soup {
    fn new(mut seed: u64, triangles: u32) -> Self {
        let mut random = |most: u64| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 32) % most
        };
        let mut units = Vec::new();
        for _ in 0..triangles {
            let origin = [0; 3].map(|_| random(400));
            units.extend([0; 3].map(|_| origin.map(|x| x + random(400))));
        }
        Self {
            positions: units.iter().map(|p| p.map(|x| f32::from_bits(x as u32))).collect(),
            positions_f64: units.iter().map(|p| p.map(f64::from_bits)).collect(),
            triangles: (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        }
    }

    fn model(&self) -> Model {
        Model::new(self.positions.clone(), self.triangles.clone()).unwrap()
    }

    fn model_f64(&self) -> Model {
        Model::from_f64(self.positions_f64.clone(), self.triangles.clone()).unwrap()
    }
}

/// Several threads in a pool of their own, which have the environment of the thread that calls.
fn threads(schedule: Schedule) -> Executor {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let settings = Settings { schedule, ..Settings::default() };
    Pool::from(Arc::new(pool)).with_settings(settings).into()
}

/// The thread that calls, and threads in its environment.
fn executors(schedule: Schedule) -> [Executor; 2] {
    [Executor::sequential(), threads(schedule)]
}

/// Threads have the environment in which their pool was made, which is another one than that of the question.
#[test]
fn questions_that_are_asked_in_any_environment_are_answered_as_in_the_default_one() {
    let expected = questions::all(&questions::Subjects::new(), &Executor::sequential());
    assert!(expected.len() > 20);
    let schedules = [Schedule::Hybrid, Schedule::Static].into_iter().cycle();
    let settings = SETTINGS.into_iter().zip(SETTINGS.into_iter().cycle().skip(1));
    for ((setting, of_pool), schedule) in settings.zip(schedules) {
        let executors = under(of_pool, || executors(schedule));
        for (number, executor) in executors.iter().enumerate() {
            let subjects = questions::Subjects::new();
            let found = under(setting, || questions::all(&subjects, executor));
            questions::compare(&found, &expected, &format!("{setting:x}, executor {number}"));
        }
    }
}

/// A device has the environment of its driver, and a scene, a batch or a history beside it that of the caller.
#[cfg(feature = "gpu")]
#[test]
fn a_gpu_that_is_asked_in_any_environment_answers_as_in_the_default_one() {
    let expected = questions::all(&questions::Subjects::new(), &Executor::sequential());
    let gpu = pfront::gpu::Gpu::new().unwrap();
    let executor = Executor::gpu(&gpu, gpu.settings());
    for setting in [0x9fc0, 0x5f80, 0x0000] {
        let subjects = questions::Subjects::new();
        let found = under(setting, || questions::all(&subjects, &executor));
        questions::compare(&found, &expected, &format!("{setting:x}"));
    }
}

#[test]
fn models_that_are_made_or_moved_in_any_environment_are_those_of_the_default_one() {
    let inputs = models::Inputs::new();
    let expected = models::all(&inputs);
    for setting in SETTINGS {
        let made = under(setting, || models::all(&inputs));
        assert_eq!(made.len(), expected.len());
        for ((name, made), (_, expected)) in made.iter().zip(&expected) {
            models::compare(made, expected, &format!("{name}, {setting:x}"));
        }
    }
}

#[test]
fn visitors_run_in_the_environment_of_the_caller() {
    let subjects = questions::Subjects::new();
    for setting in SETTINGS {
        let (seen, calls) = under(setting, || questions::seen_by_visitors(&subjects));
        assert!(calls.iter().all(|&calls| calls > 0), "{calls:?}");
        assert_eq!(seen.map(|seen| seen & !FLAGS), [setting; 4], "{setting:x}");
    }
}

#[test]
fn a_panic_in_a_visitor_leaves_the_environment_of_the_caller() {
    let subjects = questions::Subjects::new();
    for setting in [0x9fc0, 0x5f80] {
        let panicked = under(setting, || questions::panics_in_a_visitor(&subjects));
        assert!(panicked);
    }
}
