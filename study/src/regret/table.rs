//! Rows as text and as comma-separated values.

use super::{Outcome, Row, Summary};
use std::fmt;
use std::io::Write;

/// Rows as aligned columns, and the figures of all of them.
pub struct Table<'r>(pub &'r [Row]);

impl fmt::Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(first) = self.0.first() else { return writeln!(f, "no case") };
        write!(
            f,
            "{:<9} {:<42} {:>9} {:>6} {:>6} {:<5}",
            "case", "what moves", "triangles", "bodies", "frames", "verb"
        )?;
        for (name, _) in &first.fixed {
            write!(f, " {name:>11}")?;
        }
        writeln!(f, " {:>11} {:>8} {:>8} {:>8}", "planner", "regret", "to seq.", "A/A")?;
        for row in self.0 {
            let class: String = row.class.chars().take(42).collect();
            write!(
                f,
                "{:<9} {class:<42} {:>9} {:>6} {:>6} {:<5}",
                row.name,
                row.triangles,
                row.bodies,
                row.frames,
                row.verb.name()
            )?;
            for (_, outcome) in &row.fixed {
                write!(f, " {:>11}", cell(outcome, row))?;
            }
            write!(f, " {:>11} {:>7.1}%", time(row.planner), 100.0 * row.regret())?;
            writeln!(f, " {:>8.2} {:>7.1}%", row.to_sequential(), 100.0 * row.noise())?;
        }
        let Summary { cases, mean, p95, to_sequential, noise, noise_p95 } = Summary::of(self.0);
        writeln!(
            f,
            "\n{cases} cases; times of all frames, the median over rounds; > at least, given up; - no memory"
        )?;
        writeln!(
            f,
            "regret          mean {:.1} %, 95th percentile {:.1} %",
            100.0 * mean,
            100.0 * p95
        )?;
        writeln!(f, "to sequential   {to_sequential:.2} at worst")?;
        writeln!(
            f,
            "A/A             mean {:.1} %, 95th percentile {:.1} %",
            100.0 * noise,
            100.0 * noise_p95
        )
    }
}

fn cell(outcome: &Outcome, row: &Row) -> String {
    match outcome {
        Outcome::Took { seconds } if *seconds == row.best().1 => format!("*{}", time(*seconds)),
        Outcome::Took { seconds } => time(*seconds),
        Outcome::Hopeless { seconds, .. } => format!(">{}", time(*seconds)),
        Outcome::Refused { .. } => "-".to_owned(),
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

/// Writes a line for each row, with times in milliseconds.
///
/// # Errors
/// If it cannot be written.
pub fn write_csv(to: impl Write, rows: &[Row]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(to);
    let Some(first) = rows.first() else { return Ok(table.flush()?) };
    let facts = ["case", "what_moves", "triangles", "bodies", "frames", "verb", "rounds"];
    let plans = first.fixed.iter().map(|(name, _)| format!("{}_ms", name.replace(' ', "_")));
    let judged = ["planner_ms", "best", "regret", "to_sequential", "a_a"];
    table.write_record(
        facts.map(str::to_owned).into_iter().chain(plans).chain(judged.map(str::to_owned)),
    )?;
    for row in rows {
        let facts = [
            row.name.clone(),
            row.class.clone(),
            row.triangles.to_string(),
            row.bodies.to_string(),
            row.frames.to_string(),
            row.verb.name().to_owned(),
            row.rounds.to_string(),
        ];
        // What was not played to the end has no time.
        let plans = row.fixed.iter().map(|(_, outcome)| match outcome {
            Outcome::Took { seconds } => format!("{:.6}", 1e3 * seconds),
            Outcome::Hopeless { .. } | Outcome::Refused { .. } => String::new(),
        });
        let judged = [
            format!("{:.6}", 1e3 * row.planner),
            row.best().0.to_owned(),
            format!("{:.4}", row.regret()),
            format!("{:.4}", row.to_sequential()),
            format!("{:.4}", row.noise()),
        ];
        table.write_record(facts.into_iter().chain(plans).chain(judged))?;
    }
    Ok(table.flush()?)
}
