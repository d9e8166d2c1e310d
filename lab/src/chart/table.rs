//! All points as comma-separated values.

use super::{ChartError, Point, front};
use crate::judge::Tally;
use std::io::Write;

const COLUMNS: [&str; 13] = [
    "chart",
    "set",
    "real_contact",
    "configuration",
    "time",
    "unit",
    "pairs",
    "hits",
    "missed",
    "false_hits",
    "missed_per_million",
    "false_per_million",
    "on_front",
];

/// Writes charts: for each its name, the unit of its times, and for each set its points. A point is on the
/// front of its set if no other is as fast and as right, misses and false hits counted together.
///
/// # Errors
/// If it cannot be written.
pub fn write_csv(to: impl Write, charts: &[(&str, &str, &[Vec<Point>])]) -> Result<(), ChartError> {
    let mut table = csv::Writer::from_writer(to);
    table.write_record(COLUMNS)?;
    for (chart, unit, sets) in charts {
        for points in *sets {
            for (point, is_on_front) in points.iter().zip(front(points, Tally::wrong)) {
                let tally = &point.tally;
                table.write_record([
                    (*chart).to_owned(),
                    point.set.clone(),
                    u8::from(point.is_real).to_string(),
                    point.configuration.clone(),
                    format!("{:.4}", point.time),
                    (*unit).to_owned(),
                    tally.pairs.to_string(),
                    tally.hits.to_string(),
                    tally.missed.to_string(),
                    tally.false_hits.to_string(),
                    format!("{:.3}", tally.per_million(tally.missed)),
                    format!("{:.3}", tally.per_million(tally.false_hits)),
                    u8::from(is_on_front).to_string(),
                ])?;
            }
        }
    }
    Ok(table.flush()?)
}
