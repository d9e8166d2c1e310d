//! Charts as SVG: black on white, every configuration with a shape of its own or a word beside it, so that
//! neither colour nor a screen is needed to read them.

use super::axes::{Axes, plain, tick};
use super::{ChartError, Look, Point, front};
use crate::judge::Tally;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::io;

type Backend<'s> = SVGBackend<'s>;
type Panel<'s> = DrawingArea<Backend<'s>, Shift>;
type Failure = DrawingAreaErrorKind<io::Error>;

/// Pixels.
const WIDTH: u32 = 1360;
const LEGEND: u32 = 250;
const ROW: u32 = 330;
const HEAD: u32 = 40;

/// Exact, Conservative, Fast, and others: told apart by those who do not see red or green (Okabe & Ito).
const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 90, 160), RGBColor(0, 150, 110), RGBColor(205, 90, 0), RGBColor(90, 90, 90)];

/// Outlines of marks, in pixels about their middle.
const SHAPES: [&[(i32, i32)]; 9] = [
    &[(-5, -2), (-2, -5), (2, -5), (5, -2), (5, 2), (2, 5), (-2, 5), (-5, 2)],
    &[(-5, -5), (5, -5), (5, 5), (-5, 5)],
    &[(0, -7), (6, 5), (-6, 5)],
    &[(0, -7), (6, 0), (0, 7), (-6, 0)],
    &[(0, 7), (6, -5), (-6, -5)],
    &[
        (-2, -6),
        (2, -6),
        (2, -2),
        (6, -2),
        (6, 2),
        (2, 2),
        (2, 6),
        (-2, 6),
        (-2, 2),
        (-6, 2),
        (-6, -2),
        (-2, -2),
    ],
    &[
        (-6, -3),
        (-3, -6),
        (0, -3),
        (3, -6),
        (6, -3),
        (3, 0),
        (6, 3),
        (3, 6),
        (0, 3),
        (-3, 6),
        (-6, 3),
        (-3, 0),
    ],
    &[(-6, -6), (6, -6), (0, 0), (6, 6), (-6, 6), (0, 0)],
    &[(0, -7), (2, -2), (7, -2), (3, 1), (5, 6), (0, 3), (-5, 6), (-3, 1), (-7, -2), (-2, -2)],
];

/// Rows of charts that share a legend.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Above all.
    pub title: String,
    /// Of the x axis.
    pub time: String,
    /// What is counted, in the plural.
    pub counted: String,
    /// The names of the lines on which points are that are never wrong; one is enough.
    pub lines: Vec<String>,
    /// The rows.
    pub rows: Vec<Row>,
}

/// What is missed, and beside it what is a false hit.
#[derive(Clone, Debug)]
pub struct Row {
    /// What the points are of.
    pub title: String,
    /// The points.
    pub points: Vec<Point>,
}

impl Figure {
    /// The figure as SVG.
    ///
    /// # Errors
    /// If plotters cannot draw it.
    pub fn svg(&self) -> Result<String, ChartError> {
        let height = HEAD + ROW * self.rows.len().max(1) as u32;
        let mut svg = String::new();
        let root = Backend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        let drawn = self.draw(&root).map_err(|error| ChartError::Draw(error.to_string()));
        drop(root);
        drawn.map(|()| svg)
    }

    fn draw<'s>(&self, root: &Panel<'s>) -> Result<(), Failure> {
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(HEAD);
        head.draw_text(&self.title, &font(19), (14, 12))?;
        let (charts, legend) = body.split_horizontally(WIDTH - LEGEND);
        self.draw_legend(&legend)?;
        for (row, area) in self.rows.iter().zip(charts.split_evenly((self.rows.len().max(1), 1))) {
            let (left, right) = area.split_horizontally((WIDTH - LEGEND) / 2);
            let axes = Axes::around(&row.points, &self.lines);
            self.draw_panel([root, &left], row, "missed", &axes, |tally| tally.missed)?;
            self.draw_panel([root, &right], row, "false hits", &axes, |tally| tally.false_hits)?;
        }
        root.present()
    }

    fn draw_legend<'s>(&self, area: &Panel<'s>) -> Result<(), Failure> {
        let mut looks: Vec<&Look> = Vec::new();
        for point in self.rows.iter().flat_map(|row| &row.points) {
            if !looks.iter().any(|look| look.name == point.look.name) {
                looks.push(&point.look);
            }
        }
        let mut y = 20;
        for look in &looks {
            draw_mark(area, look, (14, y), "")?;
            area.draw_text(&look.name, &font(14), (28, y - 8))?;
            y += 22;
        }
        let mut say = |text: &str| {
            y += 20;
            area.draw_text(text, &font(13), (6, y))
        };
        if looks.iter().any(|look| !look.tag.is_empty()) {
            say("Beside a mark: triangles a leaf")?;
        }
        say("Dashed: Pareto front")
    }

    fn draw_panel<'s>(
        &self,
        [root, area]: [&Panel<'s>; 2],
        row: &Row,
        what: &str,
        axes: &Axes,
        wrong: impl Fn(&Tally) -> u64,
    ) -> Result<(), Failure> {
        let rate = |point: &Point| point.tally.per_million(wrong(&point.tally));
        let mut chart = ChartBuilder::on(area)
            .caption(format!("{}: {what}", row.title), font(15))
            .margin(8)
            .x_label_area_size(38)
            .y_label_area_size(104)
            .build_cartesian_2d(axes.time.clone().log_scale(), axes.rates.clone())?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(BLACK.mix(0.15))
            .x_desc(&self.time)
            .y_desc(format!("{what} per million {}", self.counted))
            .x_label_formatter(&|x| tick(*x))
            .label_style(font(12))
            .axis_desc_style(font(13))
            .draw()?;
        let right = axes.time.end;
        if let Some(Point { tally, .. }) = row.points.first() {
            let said = format!("0 of {} (< {} per million)", tally.pairs, plain(tally.bound()));
            let style = font(12).pos(Pos::new(HPos::Right, VPos::Center));
            chart.draw_series([Text::new(said, (right, axes.rates.label()), style)])?;
        }
        let place = |p: &Point| (p.time, axes.rates.height(rate(p), p.look.line));
        let on_front = front(&row.points, &wrong);
        let mut steps: Vec<_> =
            row.points.iter().zip(on_front).filter(|(_, on)| *on).map(|(p, _)| place(p)).collect();
        steps.sort_by(|p, q| p.0.total_cmp(&q.0).then(q.1.total_cmp(&p.1)));
        let mut path = Vec::new();
        let mut height = axes.rates.range().end;
        for (x, y) in steps {
            path.extend([(x, height), (x, y)]);
            height = y;
        }
        path.push((right, height));
        chart.draw_series(DashedLineSeries::new(path, 6, 4, BLACK.stroke_width(1)))?;
        row.points
            .iter()
            .try_for_each(|p| draw_mark(root, &p.look, chart.backend_coord(&place(p)), &p.look.tag))
    }
}

/// A mark about a pixel, outlined in black, with its tag to the right.
fn draw_mark(area: &Panel<'_>, look: &Look, (x, y): (i32, i32), tag: &str) -> Result<(), Failure> {
    let outline = SHAPES[look.shape % SHAPES.len()].iter().map(|(dx, dy)| (x + dx, y + dy));
    let mut outline: Vec<_> = outline.collect();
    let colour = COLOURS[look.colour % COLOURS.len()];
    area.draw(&Polygon::new(outline.clone(), colour.filled()))?;
    outline.extend_from_within(..1);
    area.draw(&PathElement::new(outline, BLACK.stroke_width(1)))?;
    area.draw_text(tag, &font(10), (x + 8, y - 5))
}

fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK)
}
