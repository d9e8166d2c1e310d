//! What a case came to, and what all cases did.

use super::case::Verb;
use super::race::HOPELESS;
use crate::tally::Tally;
use std::fmt;
use std::io::Write;

/// How a fixed plan did: medians over rounds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lane {
    /// The plan.
    pub name: String,
    /// The time of all frames, if the plan was played to the end.
    pub seconds: Option<f64>,
    /// The time of the chooser over that of this plan in the same round, or 0.
    pub chooser: f64,
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
    pub fixed: Vec<Lane>,
    /// The time of the chooser.
    pub chooser: f64,
    /// What was chosen, once everything was warm.
    pub tally: Tally,
    /// By how much the fixed plan that played twice in each round took longer than itself, as a share; less than
    /// nothing if it took less.
    pub noise: f64,
}

impl Row {
    /// The name of the fixed plan over which the chooser took longest.
    #[must_use]
    pub fn best(&self) -> &str {
        let best = self.fixed.iter().max_by(|x, y| x.chooser.total_cmp(&y.chooser));
        best.map_or("none", |lane| &lane.name)
    }

    /// By how much the chooser took longer than the best fixed plan, as a share of that.
    #[must_use]
    pub fn regret(&self) -> f64 {
        self.fixed.iter().map(|lane| lane.chooser).fold(0.0, f64::max) - 1.0
    }

    /// The chooser's time over that of one thread.
    #[must_use]
    pub fn to_sequential(&self) -> f64 {
        self.fixed.first().map_or(0.0, |lane| lane.chooser)
    }

    /// The line above rows that have the same fixed plans as this one.
    #[must_use]
    pub fn heading(&self) -> String {
        let plans: String = self.fixed.iter().map(|lane| format!(" {:>11}", lane.name)).collect();
        format!(
            "{:<26} {:>9} {:>6} {:>6} {:<5}{plans} {:>11} {:>8} {:>7} {:>7}  mostly",
            "case", "triangles", "bodies", "frames", "verb", "chooser", "regret", "to seq.", "A/A"
        )
    }
}

/// One line of a table.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<26} {:>9} ", self.name, self.triangles)?;
        write!(f, "{:>6} {:>6} {:<5}", self.bodies, self.frames, self.verb.name())?;
        let best = self.best();
        for Lane { name, seconds, .. } in &self.fixed {
            let mark = if name == best { "*" } else { "" };
            let cell = seconds.map_or("-".to_owned(), |seconds| format!("{mark}{}", time(seconds)));
            write!(f, " {cell:>11}")?;
        }
        write!(f, " {:>11} {:>7.1}%", time(self.chooser), 100.0 * self.regret())?;
        write!(f, " {:>7.2} {:>6.1}%", self.to_sequential(), 100.0 * self.noise)?;
        write!(f, "  {}", self.tally.mostly())
    }
}

/// Figures of all cases. A chooser that beats all fixed plans, as one that keeps answers does, has a regret below 0; the
/// second mean counts that as 0.
#[must_use]
pub fn summary(rows: &[Row]) -> String {
    let all = |value: fn(&Row) -> f64| -> Vec<f64> {
        let mut values: Vec<f64> = rows.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let mean = |values: &[f64]| 100.0 * values.iter().sum::<f64>() / values.len().max(1) as f64;
    let p95 = |values: &[f64]| 100.0 * quantile(values, 0.95);
    let (regrets, noises) = (all(Row::regret), all(|row| row.noise.abs()));
    format!(
        "Times of all frames: the median over rounds. Ratios: the median of those within rounds. * the best fixed plan,\n\
         - not played to the end, {HOPELESS} times slower or for want of memory.\n\
         {} cases\n\
         regret      mean {:.1} %, 95th percentile {:.1} %\n            \
         mean {:.1} % where beating all of them counts as 0\n\
         sequential  at worst {:.2} times as long\n\
         A/A         mean {:.1} %, 95th percentile {:.1} %",
        rows.len(),
        mean(&regrets),
        p95(&regrets),
        mean(&all(|row| row.regret().max(0.0))),
        all(Row::to_sequential).last().copied().unwrap_or(0.0),
        mean(&noises),
        p95(&noises)
    )
}

/// The least of ascending values that a share `q` of them does not exceed.
fn quantile(ascending: &[f64], q: f64) -> f64 {
    let rank = (q * ascending.len() as f64).ceil() as usize;
    ascending.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

/// A time in the unit that suits it.
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
    let mut head =
        ["case", "triangles", "bodies", "frames", "verb", "rounds"].map(str::to_owned).to_vec();
    head.extend(first.fixed.iter().map(|lane| format!("{}_ms", column(&lane.name))));
    head.extend(
        ["chooser_ms", "best", "regret", "to_sequential", "a_a", "changes"].map(str::to_owned),
    );
    head.extend(Tally::NAMES.map(|name| format!("frames_{}", column(name))));
    table.write_record(head)?;
    for row in rows {
        let facts = [row.triangles, row.bodies, row.frames].map(|fact| fact.to_string());
        let milliseconds = |seconds: f64| format!("{:.6}", 1e3 * seconds);
        let mut line = vec![row.name.clone()];
        line.extend(facts);
        line.extend([row.verb.name().to_owned(), row.rounds.to_string()]);
        line.extend(row.fixed.iter().map(|lane| lane.seconds.map_or(String::new(), milliseconds)));
        line.extend([milliseconds(row.chooser), row.best().to_owned()]);
        line.extend([row.regret(), row.to_sequential(), row.noise].map(|x| format!("{x:.4}")));
        line.push(row.tally.changes.to_string());
        line.extend(row.tally.frames.map(|count| count.to_string()));
        table.write_record(line)?;
    }
    Ok(table.flush()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(fixed: [(&str, f64); 2], noise: f64) -> Row {
        let lane = |(name, chooser): (&str, f64)| Lane {
            name: name.to_owned(),
            seconds: (chooser > 0.0).then_some(3.0 / chooser),
            chooser,
        };
        Row {
            name: String::new(),
            triangles: 1,
            bodies: 2,
            frames: 1,
            verb: Verb::All,
            rounds: 1,
            fixed: fixed.map(lane).into(),
            chooser: 3.0,
            tally: Tally::default(),
            noise,
        }
    }

    #[test]
    fn regret_is_against_the_best_that_was_played_to_the_end() {
        let alone = row([("sequential", 1.5), ("2 threads", 0.0)], 0.25);
        assert_eq!((alone.best(), alone.regret(), alone.to_sequential()), ("sequential", 0.5, 1.5));
        let both = row([("sequential", 0.5), ("2 threads", 1.125)], -0.5);
        assert_eq!((both.best(), both.regret(), both.to_sequential()), ("2 threads", 0.125, 0.5));
        let text = summary(&[alone, both]);
        for part in ["mean 31.2 %, 95th percentile 50.0 %", "worst 1.50 times", "mean 37.5 %"] {
            assert!(text.contains(part), "no '{part}' in:\n{text}");
        }
    }

    #[test]
    fn quantiles_are_values_that_enough_do_not_exceed() {
        let values: Vec<f64> = (1..=40).map(f64::from).collect();
        assert_eq!([0.0, 0.5, 0.95, 1.0].map(|q| quantile(&values, q)), [1.0, 20.0, 38.0, 40.0]);
        assert_eq!(quantile(&[], 0.5), 0.0);
    }
}
