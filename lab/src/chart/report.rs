//! All charts of a machine: measured, drawn, written, and summed up.

use super::frames::{self, Machine};
use super::{ChartError, Figure, Point, Row, front, pairs, together, write_csv};
use crate::judge::Tally;
use crate::suite::Suite;
use std::fmt::{self, Write as _};
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

/// Sets that whole queries are measured on, where the suite has them.
const FRAMES: [&str; 6] = ["torus-knots", "worm-gear", "sheet", "bunnies", "dragons", "cloth"];

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Triangle pairs, of all sets together.
    pub pairs: u64,
    /// The most frames of a set.
    pub frames: usize,
    /// How often each configuration takes its turn.
    pub rounds: usize,
}

impl Plan {
    /// For the record.
    pub const FULL: Self = Self { pairs: 4_000_000, frames: 3, rounds: 9 };
    /// To see that it works.
    pub const QUICK: Self = Self { pairs: 80_000, frames: 1, rounds: 3 };
}

/// What was measured: for each set, a point of each configuration.
#[derive(Clone, Debug)]
pub struct Charts {
    /// Triangle pairs.
    pub pairs: Vec<Vec<Point>>,
    /// Whole queries.
    pub frames: Vec<Vec<Point>>,
}

impl Charts {
    /// Measures all of it; `tell` hears what comes next.
    ///
    /// # Errors
    /// [`ChartError`] if a query fails.
    pub fn measure(
        suite: &Suite,
        plan: &Plan,
        machine: &Machine,
        tell: impl Fn(&str),
    ) -> Result<Self, ChartError> {
        let pairs = pairs::measure(suite, plan.pairs, plan.rounds, |set| {
            tell(&format!("triangle pairs: {set} of {} sets", suite.sets().len()));
        });
        let mut frames = Vec::new();
        for contacts in suite.sets().iter().filter_map(|set| set.contacts()) {
            if FRAMES.contains(&contacts.name()) {
                tell(&format!("frames of {}", contacts.name()));
                frames.push(frames::measure(contacts, machine, plan.frames, plan.rounds)?);
            }
        }
        Ok(Self { pairs, frames })
    }

    /// Each figure, and the name of its file.
    #[must_use]
    pub fn figures(&self) -> [(&'static str, Figure); 3] {
        let of = |is_real: bool| -> Vec<&[Point]> {
            self.pairs
                .iter()
                .map(Vec::as_slice)
                .filter(|set| is_real == is_of_contact(set))
                .collect()
        };
        let row = |points: Vec<Point>| Row {
            title: points.first().map_or(String::new(), |point| point.set.clone()),
            points,
        };
        let [hard, real] = [of(false), of(true)];
        let figure = |title: &str, time: &str, counted: &str, lines: &[&str], rows| Figure {
            title: title.to_owned(),
            time: time.to_owned(),
            counted: counted.to_owned(),
            lines: lines.iter().map(|line| (*line).to_owned()).collect(),
            rows,
        };
        let time = "ns a triangle pair, one thread";
        let both = [
            together(&format!("{} sets made to be hard", hard.len()), &hard),
            together(&format!("{} sets from real contact", real.len()), &real),
        ];
        let each = real.iter().map(|set| row(set.to_vec())).collect();
        let frames = self.frames.iter().map(|set| row(set.clone())).collect();
        let tests = "Tests of two triangles: time against wrong answers";
        let queries = "Whole queries: time against wrong answers";
        let candidates = "pairs of overlapping boxes";
        let accuracies = ["Exact", "Conservative", "Fast"];
        [
            ("pairs.svg", figure(tests, time, "pairs", &["0"], both.map(row).into())),
            ("contacts.svg", figure(tests, time, "pairs", &["0"], each)),
            ("frames.svg", figure(queries, "ms a frame", candidates, &accuracies, frames)),
        ]
    }

    /// Writes all figures and `pareto.csv` into a folder, which is made.
    ///
    /// # Errors
    /// [`ChartError`] if a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), ChartError> {
        fs::create_dir_all(folder)?;
        for (name, figure) in self.figures() {
            fs::write(folder.join(name), figure.svg()?)?;
        }
        let charts = [("triangle pair", "ns", &self.pairs[..]), ("frame", "ms", &self.frames[..])];
        write_csv(BufWriter::new(File::create(folder.join("pareto.csv"))?), &charts)
    }

    /// For each set from real contact: what Exact costs, and what beats it.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = self.sum_up(&mut text);
        text
    }

    fn sum_up(&self, out: &mut String) -> fmt::Result {
        writeln!(
            out,
            "triangle pairs       Exact ns  Fast ns  ratio  wrong per million: Exact, Fast"
        )?;
        for set in self.pairs.iter().filter(|set| is_of_contact(set)) {
            let find = |name: &str| set.iter().find(|p| p.configuration == name);
            let (Some(exact), Some(fast)) = (find("pfront Exact"), find("pfront Fast")) else {
                continue;
            };
            let rate = |p: &Point| p.tally.per_million(p.tally.wrong());
            let (name, ratio) = (&exact.set, exact.time / fast.time);
            write!(out, "{name:<20} {:>8.1} {:>8.1} {ratio:>6.2}", exact.time, fast.time)?;
            write!(out, "  {:.1}, {:.1}; ", rate(exact), rate(fast))?;
            writeln!(out, "{}", standing(set, |p| p.configuration == exact.configuration))?;
        }
        writeln!(out, "whole queries        Exact ms  ratio to Fast likewise: median, most")?;
        for set in &self.frames {
            let mut ratios: Vec<f64> = set
                .iter()
                .filter_map(|exact| {
                    let twin = exact.configuration.strip_prefix("Exact")?;
                    let is_twin = |p: &&Point| p.configuration.strip_prefix("Fast") == Some(twin);
                    Some(exact.time / set.iter().find(is_twin)?.time)
                })
                .collect();
            let median = crate::median(&mut ratios);
            let most = ratios.last().copied().unwrap_or(0.0);
            let is_exact = |p: &Point| p.configuration.starts_with("Exact");
            let best = set.iter().filter(|p| is_exact(p)).map(|p| p.time).fold(f64::MAX, f64::min);
            let name = set.first().map_or("", |point| &point.set);
            write!(out, "{name:<20} {best:>8.3} {median:>6.2} {most:>6.2}; ")?;
            writeln!(out, "{}", standing(set, is_exact))?;
        }
        Ok(())
    }
}

fn is_of_contact(set: &[Point]) -> bool {
    set.first().is_some_and(|point| point.is_real)
}

/// A time that is shorter by less than this is not: that much runs of the same differ.
const NOISE: f64 = 0.05;

/// Whether one of some configurations is on the Pareto front of a set, and if not, what is faster and as right.
fn standing(set: &[Point], is_meant: impl Fn(&Point) -> bool) -> String {
    let on_front = front(set, Tally::wrong);
    if set.iter().zip(on_front).any(|(point, on)| on && is_meant(point)) {
        return "on the front".to_owned();
    }
    let Some(best) = set.iter().filter(|p| is_meant(p)).min_by(|p, q| p.time.total_cmp(&q.time))
    else {
        return String::new();
    };
    let faster = |p: &Point| 1.0 - p.time / best.time;
    let beats = |p: &&Point| faster(p) > 0.0 && p.tally.wrong() <= best.tally.wrong();
    let beaten = set.iter().filter(beats);
    let most = beaten.clone().map(faster).fold(0.0, f64::max);
    let said = beaten.map(|p| format!("{} ({:.0} % faster)", p.configuration, 100.0 * faster(p)));
    let said = said.collect::<Vec<_>>().join(", ");
    let where_ = if most < NOISE { "on the front but for noise:" } else { "beaten by" };
    format!("{where_} {said}")
}
