//! Where a GPU spends its time, after the paper's Fig. 5, as one SVG.

use crate::command::passes::{Measured, Took};
use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

type Panel<'p> = DrawingArea<SVGBackend<'p>, Shift>;

/// A bar of parts on top of each other.
struct Bar {
    name: String,
    parts: Vec<(String, f64)>,
}

/// Device time by pass, and how much sooner a frame is done than on one thread; a bar for each workload.
///
/// # Errors
/// If plotters cannot draw them.
pub(crate) fn draw(adapter: &str, threads: usize, all: &[Measured]) -> Result<String> {
    let passes: Vec<Bar> = all.iter().map(passes).collect();
    let speeds: Vec<Bar> = all.iter().flat_map(|measured| speeds(measured, threads)).collect();
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (1100, 900)).into_drawing_area();
    root.fill(&WHITE).map_err(|e| anyhow!("{e}"))?;
    let (above, below) = root.split_vertically((60).percent_height());
    let title = format!("Device time of each pass on {adapter}, median");
    stack(&above, &title, "µs", &passes).map_err(|e| anyhow!("{e}"))?;
    let title = "A frame, pairs on the host, against one CPU thread";
    stack(&below, title, "times as fast", &speeds).map_err(|e| anyhow!("{e}"))?;
    root.present().map_err(|e| anyhow!("{e}"))?;
    drop((root, above, below));
    Ok(svg)
}

fn passes(measured: &Measured) -> Bar {
    let parts = measured.passes.iter().map(|pass| (pass.name.clone(), pass.time.median));
    Bar { name: short(&measured.name), parts: parts.collect() }
}

/// The name of a scene, or that of a file without where it lies and what it is.
fn short(name: &str) -> String {
    Path::new(name).file_stem().map_or(name.into(), |stem| stem.to_string_lossy()).into_owned()
}

fn speeds(measured: &Measured, threads: usize) -> [Bar; 2] {
    let Measured { name, gpu, one_thread, all_threads, .. } = measured;
    let bar = |by: String, took: &Took| {
        let times = one_thread.frame.median / took.frame.median.max(1e-9);
        Bar { name: short(name), parts: vec![(by, times)] }
    };
    [bar(format!("{threads} threads"), all_threads), bar("GPU".to_owned(), gpu)]
}

/// Draws bars side by side; parts of one name have one colour.
fn stack<'p>(
    panel: &Panel<'p>,
    title: &str,
    y: &str,
    bars: &[Bar],
) -> Result<(), Box<dyn Error + 'p>> {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in bars.iter().flat_map(|bar| &bar.parts) {
        if !names.contains(&&name[..]) {
            names.push(name);
        }
    }
    let sum = |bar: &Bar| bar.parts.iter().map(|(_, part)| part).sum();
    let top = bars.iter().map(sum).fold(1e-9, f64::max);
    let mut chart = ChartBuilder::on(panel)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(38)
        .y_label_area_size(64)
        .build_cartesian_2d((0..bars.len()).into_segmented(), 0.0..1.1 * top)?;
    let label = |at: &SegmentValue<usize>| match at {
        SegmentValue::CenterOf(bar) => bars.get(*bar).map_or("", |bar| &bar.name).to_owned(),
        _ => String::new(),
    };
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .disable_x_mesh()
        .x_labels(bars.len())
        .x_label_formatter(&label)
        .y_desc(y)
        .draw()?;
    for (number, name) in names.iter().enumerate() {
        let colour = Palette99::pick(number).to_rgba();
        let boxes = bars.iter().enumerate().flat_map(|(bar, Bar { parts, .. })| {
            let mut under = 0.0;
            let own = move |(part, height): &(String, f64)| {
                let from = under;
                under += height;
                let corners =
                    [(SegmentValue::Exact(bar), from), (SegmentValue::Exact(bar + 1), under)];
                let mut drawn = Rectangle::new(corners, colour.filled());
                drawn.set_margin(0, 0, 18, 18);
                (part == name).then_some(drawn)
            };
            parts.iter().filter_map(own)
        });
        let key = move |(x, y)| Rectangle::new([(x, y - 5), (x + 10, y + 5)], colour.filled());
        chart.draw_series(boxes)?.label(*name).legend(key);
    }
    let labels = &mut chart.configure_series_labels();
    labels.background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.2)).draw()?;
    Ok(())
}
