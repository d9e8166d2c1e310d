//! Who changes an answer when, and whether the truth did.

use super::slide::{NAMES, Slide, SlideError};
use crate::textbook::parry;
use pfront::Accuracy;
use pfront::core::Triangle;
use pfront::core::triangle::intersects;
use pfront_testkit::oracle::intersect;
use rayon::prelude::*;

/// A test of two triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// [`Accuracy::Exact`].
    Exact,
    /// [`Accuracy::Fast`].
    Fast,
    /// parry3d's own, which is GJK, as for all its convex shapes.
    Parry,
}

impl Method {
    /// Every method of this build.
    pub const ALL: &[Self] = &[Self::Exact, Self::Fast, Self::Parry];

    /// The name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "Exact",
            Self::Fast => "Fast",
            Self::Parry => "parry3d",
        }
    }

    /// Whether two triangles meet, it says.
    #[must_use]
    pub fn meet(self, a: &Triangle, b: &Triangle) -> bool {
        match self {
            Self::Exact => intersects(a, b, Accuracy::Exact),
            Self::Fast => intersects(a, b, Accuracy::Fast),
            Self::Parry => parry::meet(a, b),
        }
    }
}

/// What one method did on one slide in steps of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// One of [`NAMES`].
    pub slide: &'static str,
    /// By how much the scene moves from frame to frame; its lengths are about 1.
    pub step: f64,
    /// Who answered.
    pub method: Method,
    /// How many answers: pairs times frames.
    pub answers: u64,
    /// How often the truth changed.
    pub truth: u64,
    /// How often the answer changed where the truth did not.
    pub flips: u64,
    /// How often the truth changed where the answer did not.
    pub missed: u64,
    /// How many answers are wrong.
    pub wrong: u64,
}

/// The sizes of steps, of which the first is one unit in the last place of a number just below 1.
pub const STEPS: [f64; 5] = [1.0 / (1 << 24) as f64, 1e-6, 1e-5, 1e-4, 1e-3];

/// Moves every slide of [`NAMES`] through its contact in `frames` steps of each size: rows by slide, then by
/// step, then by method.
///
/// # Errors
/// [`SlideError`] if a scene has changed so that nothing happens in it any more.
///
/// # Complexity
/// Some 30 µs a pair and frame, which the truth takes; up to 130 pairs a slide. On all threads of the rayon pool.
pub fn run(frames: u32) -> Result<Vec<Row>, SlideError> {
    let slides: Vec<_> = NAMES.iter().map(|name| Slide::by_name(name)).collect::<Result<_, _>>()?;
    let courses: Vec<_> = slides.iter().flat_map(|slide| STEPS.map(|step| (slide, step))).collect();
    Ok(courses.into_par_iter().flat_map_iter(|(slide, step)| course(slide, step, frames)).collect())
}

/// What each method says of one pair, and what is true.
#[derive(Clone, Default, PartialEq)]
struct Said {
    truth: bool,
    answers: Vec<bool>,
}

/// One slide in steps of one size, half of them before the event.
fn course(slide: &Slide, step: f64, frames: u32) -> Vec<Row> {
    let blank = |&method: &Method| Row {
        slide: slide.name,
        step,
        method,
        answers: 0,
        truth: 0,
        flips: 0,
        missed: 0,
        wrong: 0,
    };
    let mut rows: Vec<Row> = Method::ALL.iter().map(blank).collect();
    let mut last: Vec<Said> = Vec::new();
    for frame in 0..frames {
        let length = step * (f64::from(frame) - f64::from(frames) / 2.0);
        let now: Vec<_> = slide.pairs(length).iter().map(|[a, b]| said(a, b)).collect();
        for (k, row) in rows.iter_mut().enumerate() {
            row.answers += now.len() as u64;
            row.wrong += count(now.iter().map(|said| said.answers[k] != said.truth));
            // None, in the first frame.
            for (was, is) in last.iter().zip(&now) {
                let (turned, changed) = (was.truth != is.truth, was.answers[k] != is.answers[k]);
                row.truth += u64::from(turned);
                row.flips += u64::from(changed && !turned);
                row.missed += u64::from(turned && !changed);
            }
        }
        last = now;
    }
    rows
}

fn said(a: &Triangle, b: &Triangle) -> Said {
    let answers = Method::ALL.iter().map(|method| method.meet(a, b)).collect();
    Said { truth: intersect(a, b), answers }
}

fn count(mut which: impl Iterator<Item = bool>) -> u64 {
    which.by_ref().filter(|&it| it).count() as u64
}
