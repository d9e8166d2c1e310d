//! What a case came to, and what all cases did.

use super::case::Verb;
use super::race::HOPELESS;
use crate::tally::Tally;
use std::fmt;
use std::io::Write;

/// How a fixed plan did.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Medians over rounds.
    Took {
        /// All frames.
        seconds: f64,
        /// What the chooser took over what this took in the same round.
        chooser: f64,
    },
    /// In the first round, by when it was more than twenty times as slow as the best.
    Hopeless {
        /// Until then.
        seconds: f64,
        /// Until then.
        frames: usize,
    },
    /// There was not enough memory, or it cannot do such a case.
    Refused {
        /// The error.
        why: String,
    },
}

static NONE: Outcome = Outcome::Refused { why: String::new() };

impl Outcome {
    pub(super) fn is_timed(&self) -> bool {
        matches!(self, Self::Took { .. })
    }

    /// Of all frames; infinite where they were not all played.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        match self {
            Self::Took { seconds, .. } => *seconds,
            Self::Hopeless { .. } | Self::Refused { .. } => f64::INFINITY,
        }
    }

    /// What the chooser took over what this took; nothing where they were not all played.
    #[must_use]
    pub fn chooser(&self) -> f64 {
        match self {
            Self::Took { chooser, .. } => *chooser,
            Self::Hopeless { .. } | Self::Refused { .. } => 0.0,
        }
    }
}

/// A case with the times of all who played it, in seconds for all frames.
#[derive(Clone, Debug)]
pub struct Row {
    /// The case.
    pub name: String,
    /// Of all bodies together.
    pub triangles: usize,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of frames.
    pub frames: usize,
    /// What was asked.
    pub verb: Verb,
    /// How many rounds were counted.
    pub rounds: usize,
    /// Each fixed plan; the first is one thread.
    pub fixed: Vec<(String, Outcome)>,
    /// Who chooses.
    pub chooser: f64,
    /// What was chosen, once everything was warm.
    pub tally: Tally,
    /// By how much the fixed plan that played twice in each round took longer than itself, as a share; less than
    /// nothing if it took less.
    pub noise: f64,
}

impl Row {
    /// The fixed plan over which the chooser took longest.
    #[must_use]
    pub fn best(&self) -> (&str, &Outcome) {
        let all = self.fixed.iter().map(|(name, outcome)| (&**name, outcome));
        all.max_by(|x, y| x.1.chooser().total_cmp(&y.1.chooser())).unwrap_or(("none", &NONE))
    }

    /// By how much the chooser took longer than the best fixed plan, as a share of that.
    #[must_use]
    pub fn regret(&self) -> f64 {
        self.best().1.chooser() - 1.0
    }

    /// The chooser's time over that of one thread.
    #[must_use]
    pub fn to_sequential(&self) -> f64 {
        self.fixed.first().map_or(0.0, |(_, outcome)| outcome.chooser())
    }
}

/// Figures of all cases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// How many.
    pub cases: usize,
    /// The mean regret.
    pub mean: f64,
    /// The same where a chooser that beats all fixed plans, as one that keeps answers does, counts as 0.
    pub mean_loss: f64,
    /// What 95 of a hundred regrets do not exceed.
    pub p95: f64,
    /// The worst time over that of one thread.
    pub to_sequential: f64,
    /// The mean distance of a plan from itself.
    pub noise: f64,
    /// What 95 of a hundred such distances do not exceed.
    pub noise_p95: f64,
}

impl Summary {
    /// Of some cases.
    #[must_use]
    pub fn of(rows: &[Row]) -> Self {
        let all = |value: fn(&Row) -> f64| -> Vec<f64> {
            let mut values: Vec<f64> = rows.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let (regrets, noises) = (all(Row::regret), all(|row| row.noise.abs()));
        Self {
            cases: rows.len(),
            mean: mean(&regrets),
            mean_loss: mean(&all(|row| row.regret().max(0.0))),
            p95: quantile(&regrets, 0.95),
            to_sequential: all(Row::to_sequential).last().copied().unwrap_or(0.0),
            noise: mean(&noises),
            noise_p95: quantile(&noises, 0.95),
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The least of ascending values that a share `q` of them does not exceed.
fn quantile(ascending: &[f64], q: f64) -> f64 {
    let rank = (q * ascending.len() as f64).ceil() as usize;
    ascending.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

/// The line above rows that have the same fixed plans as this one.
pub struct Heading<'r>(pub &'r Row);

impl fmt::Display for Heading<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<26} {:>9} ", "case", "triangles")?;
        write!(f, "{:>6} {:>6} {:<5}", "bodies", "frames", "verb")?;
        self.0.fixed.iter().try_for_each(|(name, _)| write!(f, " {name:>11}"))?;
        write!(f, " {:>11} {:>8} {:>7} {:>7}  mostly", "chooser", "regret", "to seq.", "A/A")
    }
}

/// One line of a table.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<26} {:>9} ", self.name, self.triangles)?;
        write!(f, "{:>6} {:>6} {:<5}", self.bodies, self.frames, self.verb.name())?;
        let best = self.best().0;
        for (name, outcome) in &self.fixed {
            let cell = match outcome {
                Outcome::Took { seconds, .. } if name == best => format!("*{}", time(*seconds)),
                Outcome::Took { seconds, .. } => time(*seconds),
                Outcome::Hopeless { seconds, .. } => format!(">{}", time(*seconds)),
                Outcome::Refused { .. } => "-".to_owned(),
            };
            write!(f, " {cell:>11}")?;
        }
        write!(f, " {:>11} {:>7.1}%", time(self.chooser), 100.0 * self.regret())?;
        write!(f, " {:>7.2} {:>6.1}%", self.to_sequential(), 100.0 * self.noise)?;
        write!(f, "  {}", self.tally.mostly())
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let Self { cases, mean, mean_loss, p95, to_sequential, noise, noise_p95 } = *self;
        writeln!(
            f,
            "Times of all frames: the median over rounds. Ratios: the median of those within rounds. * the best fixed plan,"
        )?;
        writeln!(
            f,
            "> given up by then, as {HOPELESS} times slower; - it cannot do that, or for want of memory."
        )?;
        writeln!(f, "{cases} cases")?;
        writeln!(f, "regret      mean {}, 95th percentile {}", percent(mean), percent(p95))?;
        writeln!(
            f,
            "            mean {} where beating all of them counts as 0",
            percent(mean_loss)
        )?;
        writeln!(f, "sequential  at worst {to_sequential:.2} times as long")?;
        write!(f, "A/A         mean {}, 95th percentile {}", percent(noise), percent(noise_p95))
    }
}

/// In the unit that suits it.
fn time(seconds: f64) -> String {
    match seconds {
        ..1e-3 => format!("{:.1} µs", 1e6 * seconds),
        ..1.0 => format!("{:.2} ms", 1e3 * seconds),
        _ => format!("{seconds:.2} s"),
    }
}

/// Writes a line for each row, with times in milliseconds. What was not played to the end has none.
///
/// # Errors
/// If it cannot be written.
pub fn write_csv(to: impl Write, rows: &[Row]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(to);
    let Some(first) = rows.first() else { return Ok(table.flush()?) };
    let column = |name: &str| name.replace(' ', "_");
    let facts = ["case", "triangles", "bodies", "frames", "verb", "rounds"];
    let judged = ["chooser_ms", "best", "regret", "to_sequential", "a_a", "changes"];
    let mut head = facts.map(str::to_owned).to_vec();
    head.extend(first.fixed.iter().map(|(name, _)| format!("{}_ms", column(name))));
    head.extend(judged.map(str::to_owned));
    head.extend(first.fixed.iter().map(|(name, _)| format!("chooser_to_{}", column(name))));
    head.extend(Tally::NAMES.map(|name| format!("frames_{}", column(name))));
    table.write_record(head)?;
    for row in rows {
        let mut line = vec![
            row.name.clone(),
            row.triangles.to_string(),
            row.bodies.to_string(),
            row.frames.to_string(),
            row.verb.name().to_owned(),
            row.rounds.to_string(),
        ];
        line.extend(row.fixed.iter().map(|(_, outcome)| match outcome {
            Outcome::Took { seconds, .. } => format!("{:.6}", 1e3 * seconds),
            Outcome::Hopeless { .. } | Outcome::Refused { .. } => String::new(),
        }));
        line.extend([
            format!("{:.6}", 1e3 * row.chooser),
            row.best().0.to_owned(),
            format!("{:.4}", row.regret()),
            format!("{:.4}", row.to_sequential()),
            format!("{:.4}", row.noise),
            row.tally.changes.to_string(),
        ]);
        line.extend(row.fixed.iter().map(|(_, outcome)| match outcome {
            Outcome::Took { chooser, .. } => format!("{chooser:.4}"),
            Outcome::Hopeless { .. } | Outcome::Refused { .. } => String::new(),
        }));
        line.extend(row.tally.frames.map(|count| count.to_string()));
        table.write_record(line)?;
    }
    Ok(table.flush()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(sequential: Outcome, threads: Outcome, noise: f64) -> Row {
        let fixed = [("sequential", sequential), ("2 threads", threads)];
        Row {
            name: String::new(),
            triangles: 1,
            bodies: 2,
            frames: 1,
            verb: Verb::All,
            rounds: 1,
            fixed: fixed.map(|(name, outcome)| (name.to_owned(), outcome)).into(),
            chooser: 3.0,
            tally: Tally::default(),
            noise,
        }
    }

    #[test]
    fn regret_is_against_the_best_that_was_played_to_the_end() {
        let took = |chooser: f64| Outcome::Took { seconds: 3.0 / chooser, chooser };
        let hopeless = Outcome::Hopeless { seconds: 0.5, frames: 1 };
        let alone = row(took(1.5), hopeless, 0.25);
        assert_eq!(
            (alone.best().0, alone.regret(), alone.to_sequential()),
            ("sequential", 0.5, 1.5)
        );
        let both = row(took(0.5), took(1.125), -0.5);
        assert_eq!((both.best().0, both.regret(), both.to_sequential()), ("2 threads", 0.125, 0.5));
        let summary = Summary::of(&[alone, both]);
        assert_eq!((summary.mean, summary.p95), (0.3125, 0.5));
        assert_eq!((summary.to_sequential, summary.noise), (1.5, 0.375));
        let nobody = Row { fixed: Vec::new(), ..row(took(1.0), took(1.0), 0.0) };
        assert_eq!((nobody.best().0, nobody.to_sequential()), ("none", 0.0));
    }

    #[test]
    fn quantiles_are_values_that_enough_do_not_exceed() {
        let values: Vec<f64> = (1..=40).map(f64::from).collect();
        assert_eq!([0.0, 0.5, 0.95, 1.0].map(|q| quantile(&values, q)), [1.0, 20.0, 38.0, 40.0]);
        assert_eq!(quantile(&[], 0.5), 0.0);
    }
}
