//! A run as one SVG: above the flips of each slide, below its wrong answers, a marked line a method.

use super::flips::{Method, Row, STEPS};
use super::slide::NAMES;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

type Panel<'p> = DrawingArea<SVGBackend<'p>, Shift>;

type Count = fn(&Row) -> u64;

/// What is counted, as the axis has it.
const COUNTED: [(&str, Count); 2] = [
    ("flips: changes that the truth has not", |row| row.flips),
    ("wrong answers", |row| row.wrong),
];

/// Charts [`Row::flips`] and [`Row::wrong`] over the size of steps, all logarithmic; none at all has a line of
/// its own below. On white, in colours that all can tell apart, and each method with a marker of its own. A
/// method that always says the same never flips, which is why wrong answers stand beneath.
///
/// # Errors
/// What plotters could not draw.
pub fn draw(rows: &[Row]) -> Result<String, String> {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (1440, 720)).into_drawing_area();
    root.fill(&WHITE).map_err(|e| e.to_string())?;
    for (line, (counted, count)) in root.split_evenly((2, 1)).iter().zip(COUNTED) {
        let most = rows.iter().map(|row| count(row).max(row.truth)).max().unwrap_or(0);
        for (panel, name) in line.split_evenly((1, NAMES.len())).iter().zip(NAMES) {
            let rows: Vec<_> = rows.iter().filter(|row| row.slide == name).collect();
            let chart = Chart { name, counted, count, rows: &rows, top: height(most) + 1.9 };
            chart.draw(panel).map_err(|e| e.to_string())?;
        }
    }
    root.present().map_err(|e| e.to_string())?;
    drop(root);
    Ok(svg)
}

/// One panel.
struct Chart<'r> {
    name: &'r str,
    counted: &'r str,
    count: Count,
    rows: &'r [&'r Row],
    /// In powers of ten.
    top: f64,
}

/// Where nothing at all is drawn, in powers of ten.
const NONE: f64 = -0.6;

fn height(count: u64) -> f64 {
    if count == 0 { NONE } else { (count as f64).log10() }
}

impl Chart<'_> {
    fn draw<'p>(&self, panel: &Panel<'p>) -> Result<(), Box<dyn std::error::Error + 'p>> {
        let right = STEPS.len() as f64 - 0.5;
        let answers = self.rows.first().map_or(0, |row| row.answers);
        let mut chart = ChartBuilder::on(panel)
            .caption(format!("{}, of {answers} answers", self.name), ("sans-serif", 16))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(-0.5..right, NONE - 0.3..self.top)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(BLACK.mix(0.15))
            .x_labels(STEPS.len())
            .x_label_formatter(&|x| step_label(*x))
            .y_labels(self.top as usize + 2)
            .y_label_formatter(&|y| power_label(*y))
            .x_desc("step of the motion")
            .y_desc(self.counted)
            .draw()?;
        chart.draw_series(LineSeries::new([(-0.5, NONE), (right, NONE)], BLACK.mix(0.4)))?;
        let small = ("sans-serif", 13).into_font().into_text_style(panel);
        let small = small.pos(Pos::new(HPos::Left, VPos::Bottom));
        chart.draw_series([Text::new("none", (-0.47, NONE), small)])?;

        let grey = BLACK.mix(0.4);
        let truth = self.points(Method::Exact, |row| row.truth);
        chart
            .draw_series(DashedLineSeries::new(truth, 3, 3, grey.stroke_width(1)))?
            .label("the truth changes")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], grey));
        for (k, &method) in Method::ALL.iter().enumerate() {
            let points = self.points(method, self.count);
            let (colour, size) = (COLOURS[k % COLOURS.len()], 5);
            let (thick, full) = (colour.stroke_width(2), colour.filled());
            chart.draw_series(LineSeries::new(points.iter().copied(), thick))?;
            match k {
                0 => chart
                    .draw_series(points.iter().map(|&at| Circle::new(at, size, full)))?
                    .label(method.name())
                    .legend(move |(x, y)| Circle::new((x + 8, y), size, full)),
                1 => chart
                    .draw_series(points.iter().map(|&at| Cross::new(at, size, thick)))?
                    .label(method.name())
                    .legend(move |(x, y)| Cross::new((x + 8, y), size, thick)),
                _ => chart
                    .draw_series(points.iter().map(|&at| TriangleMarker::new(at, size, full)))?
                    .label(method.name())
                    .legend(move |(x, y)| TriangleMarker::new((x + 8, y), size, full)),
            };
        }
        // Above all that is drawn.
        let labels = &mut chart.configure_series_labels();
        let labels = labels.position(SeriesLabelPosition::UpperRight);
        labels.background_style(WHITE).border_style(BLACK.mix(0.2)).draw()?;
        Ok(())
    }

    /// A point for each step.
    fn points(&self, method: Method, count: impl Fn(&Row) -> u64) -> Vec<(f64, f64)> {
        let rows = self.rows.iter().filter(|row| row.method == method);
        rows.enumerate().map(|(i, row)| (i as f64, height(count(row)))).collect()
    }
}

/// Okabe and Ito's blue, vermilion and green.
const COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// Steps stand side by side, each at a whole number.
fn step_label(x: f64) -> String {
    match STEPS.get(x.round() as usize) {
        Some(step) if (x - x.round()).abs() < 0.1 && x > -0.1 => {
            if *step == STEPS[0] {
                "1 ulp".to_owned()
            } else {
                format!("{step:e}")
            }
        }
        _ => String::new(),
    }
}

fn power_label(y: f64) -> String {
    if y < -0.1 { String::new() } else { format!("{:.0}", 10_f64.powf(y)) }
}
