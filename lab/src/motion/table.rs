//! A run as comma-separated values.

use super::Row;
use std::io::Write;

/// Writes a line for each row, below the names of the columns.
///
/// # Errors
/// If it cannot be written.
pub fn write_csv(to: impl Write, rows: &[Row]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(to);
    table.write_record([
        "slide", "step", "method", "answers", "truth", "flips", "missed", "wrong",
    ])?;
    for row in rows {
        table.write_record([
            row.slide,
            &format!("{:e}", row.step),
            row.method.name(),
            &row.answers.to_string(),
            &row.truth.to_string(),
            &row.flips.to_string(),
            &row.missed.to_string(),
            &row.wrong.to_string(),
        ])?;
    }
    Ok(table.flush()?)
}
