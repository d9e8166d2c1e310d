//! Rows as text and as comma-separated values.

use super::{HOPELESS, Outcome, Row, Summary};
use crate::tally::Tally;
use std::fmt;
use std::io::Write;

/// Letters of what moves.
const CLASS: usize = 42;

/// The line above rows that have the same fixed plans as this one.
pub struct Heading<'r>(pub &'r Row);

impl fmt::Display for Heading<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<9} {:<CLASS$} {:>9} ", "case", "what moves", "triangles")?;
        write!(f, "{:>6} {:>6} {:<5}", "bodies", "frames", "verb")?;
        self.0.fixed.iter().try_for_each(|(name, _)| write!(f, " {name:>11}"))?;
        write!(f, " {:>11} {:>8} {:>7} {:>7}  mostly", "chooser", "regret", "to seq.", "A/A")
    }
}

/// One line of a table.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let class: String = self.class.chars().take(CLASS).collect();
        write!(f, "{:<9} {class:<CLASS$} {:>9} ", self.name, self.triangles)?;
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
    let facts = ["case", "what_moves", "triangles", "bodies", "frames", "verb", "rounds"];
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
            row.class.clone(),
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
