//! `cargo run --release -p pfront-study --features parry --example motion [SVG] [FRAMES]`: who flickers in slow
//! motion, as a table and a chart.

use pfront_study::motion::{Row, draw, run};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let svg = arguments.next();
    let frames = arguments.next().map_or(Ok(256), |text| text.parse())?;
    let rows = run(frames)?;
    println!("slide             step    method   answers  truth  flips missed  wrong");
    for Row { slide, step, method, answers, truth, flips, missed, wrong } in &rows {
        let name = method.name();
        println!(
            "{slide:<17} {step:<7.0e} {name:<8}{answers:>8}{truth:>7}{flips:>7}{missed:>7}{wrong:>7}"
        );
    }
    if let Some(path) = svg {
        std::fs::write(path, draw(&rows)?)?;
    }
    Ok(())
}
