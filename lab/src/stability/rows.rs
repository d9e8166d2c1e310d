//! The matrix: each row with its scenes, what is measured of them, and what is found.

use super::catalogue::{self, PERIOD, SETTLING};
use super::play::{Frame, Method, Series, play};
use super::scene::Scene;
use anyhow::Result;

/// A case of the matrix.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its name, without spaces.
    pub name: &'static str,
    scenes: fn() -> Result<Vec<Scene>>,
    /// Frames after which its scenes come back to where they were; the size of the front is measured then as well.
    period: Option<usize>,
}

const fn row(name: &'static str, period: Option<usize>, scenes: fn() -> Result<Vec<Scene>>) -> Row {
    Row { name, scenes, period }
}

/// The matrix.
pub const ROWS: [Row; 12] = [
    row("coherent", None, catalogue::coherent),
    row("flat", None, catalogue::flat),
    row("teleport", None, catalogue::teleport),
    row("onset-and-loss", None, catalogue::onset_and_loss),
    row("skewed", None, catalogue::skewed),
    row("one-against-many", None, catalogue::one_against_many),
    row("few-nodes", None, catalogue::few_nodes),
    row("identical", None, catalogue::identical),
    row("contained", None, catalogue::contained),
    row("still", Some(1), catalogue::still),
    row("swaying", Some(PERIOD), catalogue::swaying),
    row("twin", None, catalogue::twin),
];

/// A figure and its limit, for one method and number of workers.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The name of the figure.
    pub measure: &'static str,
    /// The method that was measured.
    pub method: Method,
    /// p.
    pub workers: usize,
    /// The worst figure: that nearest to its limit, or farthest beyond.
    pub figure: f64,
    /// The limit of the figure.
    pub limit: f64,
    /// Where it was found.
    pub place: String,
    /// Whether the limit is wider than usual, as workers had hardly anything to do.
    pub widened: bool,
    /// Whether all answers were right and all figures numbers.
    pub sound: bool,
}

impl Finding {
    pub(super) fn new(
        measure: &'static str,
        method: Method,
        workers: usize,
        figure: f64,
        limit: f64,
        place: String,
    ) -> Self {
        Self { measure, method, workers, figure, limit, place, widened: false, sound: true }
    }

    /// Whether it passes.
    pub fn holds(&self) -> bool {
        self.sound && self.figure <= self.limit
    }

    /// The one that fails, or comes closest to it.
    fn worse(self, other: Self) -> Self {
        let excess = |f: &Self| if f.limit > 0.0 { f.figure / f.limit } else { f.figure };
        let key = |f: &Self| (!f.sound, !f.holds(), excess(f));
        if key(&other) > key(&self) { other } else { self }
    }

    pub(super) fn worst(all: impl IntoIterator<Item = Self>) -> Option<Self> {
        all.into_iter().reduce(Self::worse)
    }

    fn of_frame(series: &Series, number: usize, frame: &Frame) -> Self {
        let Series { scene, method, workers, .. } = *series;
        let place = format!("{scene}, frame {number}: {}", frame.what);
        let found = Self::new("imbalance", method, workers, frame.imbalance, frame.limit, place);
        Self { widened: frame.widened, sound: frame.right && frame.finite, ..found }
    }
}

/// The results of a row.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The frames of its scenes.
    pub series: Vec<Series>,
    /// The figures, each beside its limit.
    pub findings: Vec<Finding>,
    /// How many frames were compared with the oracle.
    pub by_oracle: usize,
}

impl Outcome {
    /// Whether a method passes in all of it.
    pub fn holds(&self, method: Method) -> bool {
        self.findings.iter().filter(|found| found.method == method).all(Finding::holds)
    }
}

impl Row {
    /// Its scenes.
    ///
    /// # Errors
    /// If a mesh is refused, which those of the matrix are not.
    pub fn scenes(&self) -> Result<Vec<Scene>> {
        (self.scenes)()
    }

    /// Plays its scenes with each of `workers` and judges them; calls `tick` after each frame.
    ///
    /// # Errors
    /// If a pose is refused, which those of the matrix are not.
    pub fn run(
        &self,
        scenes: &mut [Scene],
        workers: &[usize],
        tick: &mut dyn FnMut(),
    ) -> Result<Outcome> {
        let mut outcome = Outcome::default();
        for scene in scenes {
            let (series, by_oracle) = play(scene, workers, tick)?;
            outcome.by_oracle += by_oracle;
            outcome.add(series.iter().flat_map(|s| self.judge_series(s)).collect());
            outcome.series.extend(series);
        }
        Ok(outcome)
    }

    fn judge_series(&self, series: &Series) -> Vec<Finding> {
        let frames = series.frames.iter().enumerate();
        let frames = frames.map(|(i, frame)| Finding::of_frame(series, i, frame));
        let mut found: Vec<Finding> = Finding::worst(frames).into_iter().collect();
        if let Some(period) = self.period {
            found.extend(settling(series, period));
        }
        found
    }
}

impl Outcome {
    /// Keeps the worst of each measure, method and p.
    fn add(&mut self, findings: Vec<Finding>) {
        for found in findings {
            let key = |f: &Finding| (f.measure, f.method, f.workers);
            match self.findings.iter_mut().find(|f| key(f) == key(&found)) {
                Some(worst) => *worst = worst.clone().worse(found),
                None => self.findings.push(found),
            }
        }
    }
}

/// How the size of a front behaves in a scene that comes back after `period` frames: whether it is what it was
/// (drift), whether it goes up and down from frame to frame (what a period of 2 adds, relative), and, where
/// nothing moves, whether it comes to rest.
fn settling(series: &Series, period: usize) -> Vec<Finding> {
    let nodes = |frame: &Frame| frame.nodes as f64;
    let settled: Vec<f64> = series.frames.iter().skip(SETTLING - 1).map(nodes).collect();
    let drift = (period..settled.len())
        .map(|i| (settled[i] / settled[i % period] - 1.0).abs())
        .fold(0.0, f64::max);
    let even = &settled[..settled.len() / 2 * 2];
    let [ups, downs] = [0, 1].map(|odd| even.iter().skip(odd).step_by(2).sum::<f64>());
    let alternation = 2.0 * (ups - downs).abs() / (ups + downs);
    let found = |measure, figure, limit| {
        let place = series.scene.to_owned();
        Finding::new(measure, series.method, series.workers, figure, limit, place)
    };
    let mut all =
        vec![found("front drift", drift, 0.05), found("period-2 swing", alternation, 0.005)];
    if period == 1 {
        let last = &settled[settled.len().saturating_sub(8)..];
        let [most, least] = [f64::max, f64::min].map(|of| last.iter().copied().fold(last[0], of));
        all.push(found("last 8 frames", (most - least) / settled[0], 0.0));
    }
    all
}
