//! Charts as SVG, for print: black on white, each series with a colour, a dash pattern and a marker of its own.
//!
//! Legends stand beside the panels, never on the curves. A logarithmic axis has a line of its own for 0.

use std::fmt::Write;

/// Panels in rows.
pub struct Figure {
    /// Above all panels.
    pub title: String,
    /// Panels of a row.
    pub columns: usize,
    /// The panels.
    pub panels: Vec<Panel>,
}

/// One chart.
pub struct Panel {
    /// Above the chart.
    pub title: String,
    /// Where good values are, such as "lower left".
    pub better: &'static str,
    /// The x axis.
    pub x: Axis,
    /// The y axis.
    pub y: Axis,
    /// The curves and points.
    pub series: Vec<Series>,
}

/// An axis: quantity and unit, and how it is divided.
pub struct Axis {
    /// The text beside it.
    pub label: String,
    /// How it is divided.
    pub scale: Scale,
}

/// How an axis is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// From 0 on.
    Linear,
    /// By decades, with a line for 0 below them.
    Log,
}

/// Points of one name.
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// x and y.
    pub points: Vec<(f64, f64)>,
    /// How they are drawn.
    pub style: Style,
}

/// How points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// By markers.
    Points,
    /// With a line from each to the next.
    Line,
    /// With all below the line filled. Later series cover earlier ones, so that a stack comes from the top.
    Area,
}

// Pixels.
const PANEL: [f64; 2] = [440.0, 330.0];
const LEGEND: f64 = 230.0;
const HEAD: f64 = 40.0;
/// Between a panel's edges and its chart: left, right, top, bottom.
const MARGINS: [f64; 4] = [78.0, 16.0, 46.0, 52.0];
/// The most markers of a line.
const MARKERS: usize = 8;

/// Colours that can be told apart without seeing red or green (Okabe & Ito), none of them light.
const COLOURS: [&str; 9] = [
    "#0072b2", "#d55e00", "#009e73", "#a0428a", "#000000", "#b07a00", "#3a86c8", "#777777",
    "#8b4513",
];
const DASHES: [&str; 6] = ["", "8 4", "2 3", "10 3 2 3", "14 4", "4 7"];
const MARKS: [&str; 9] = [
    "M-5,0a5,5 0 1,0 10,0a5,5 0 1,0 -10,0z",
    "M-4.5,-4.5h9v9h-9z",
    "M0,-6L5.5,4.5h-11z",
    "M0,-6L6,0L0,6L-6,0z",
    "M0,6L5.5,-4.5h-11z",
    "M-2,-6h4v4h4v4h-4v4h-4v-4h-4v-4h4z",
    "M-6,-4l2,-2l4,4l4,-4l2,2l-4,4l4,4l-2,2l-4,-4l-4,4l-2,-2l4,-4z",
    "M-5,-6h10L-5,6h10z",
    "M0,-7l2,5h5l-4,3l2,5l-5,-3l-5,3l2,-5l-4,-3h5z",
];

impl Figure {
    /// The figure as SVG.
    pub fn svg(&self) -> String {
        let names = |panel: &Panel| panel.series.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
        let is_shared = self.panels.windows(2).all(|two| names(&two[0]) == names(&two[1]));
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rows = self.panels.len().div_ceil(columns);
        let step = PANEL[0] + if is_shared { 0.0 } else { LEGEND };
        let width = step * columns as f64 + if is_shared { LEGEND } else { 0.0 };
        let height = HEAD + PANEL[1] * rows as f64;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        text(&mut svg, [14.0, 26.0], 19, "start", &self.title);
        for (number, panel) in self.panels.iter().enumerate() {
            let at =
                [step * (number % columns) as f64, HEAD + PANEL[1] * (number / columns) as f64];
            panel.draw(&mut svg, at);
            if !is_shared || number + 1 == columns {
                panel.legend(&mut svg, [at[0] + PANEL[0], at[1] + MARGINS[2]]);
            }
        }
        svg + "</svg>\n"
    }
}

/// An axis with its range, in powers of ten if it is logarithmic, and the pixels that this is drawn to.
struct Ruler {
    scale: Scale,
    range: [f64; 2],
    /// Where 0 is on a logarithmic axis that needs it.
    zero: Option<f64>,
    pixels: [f64; 2],
}

impl Ruler {
    fn new(scale: Scale, values: impl Iterator<Item = f64> + Clone, pixels: [f64; 2]) -> Self {
        let (low, high) = values
            .clone()
            .filter(|x| x.is_finite() && (*x > 0.0 || scale == Scale::Linear))
            .fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
        if scale == Scale::Linear {
            return Self { scale, range: [0.0, 1.06 * high.max(1e-9)], zero: None, pixels };
        }
        let [low, high] = if low > high { [1.0, 10.0] } else { [low, high] }.map(f64::log10);
        let pad = 0.06 * (high - low).max(1.0);
        let mut range = [low - pad, high + pad];
        let zero = values.into_iter().any(|x| x <= 0.0).then(|| {
            range[0] -= 2.0 * pad;
            range[0] + pad
        });
        Self { scale, range, zero, pixels }
    }

    fn pixel(&self, value: f64) -> f64 {
        let at = match self.scale {
            Scale::Linear => value,
            Scale::Log if value > 0.0 => value.log10(),
            Scale::Log => self.zero.unwrap_or(self.range[0]),
        };
        let [low, high] = self.range;
        let [from, to] = self.pixels;
        from + (to - from) * (at - low) / (high - low)
    }

    /// Values that are labelled: at least two, whatever the range.
    fn ticks(&self) -> Vec<f64> {
        let [low, high] = self.range;
        if self.scale == Scale::Linear {
            let decade = 10_f64.powf((high / 4.0).log10().floor());
            let step = [1.0, 2.0, 5.0, 10.0].map(|x| x * decade);
            let step = step.into_iter().find(|step| high / step <= 6.0).unwrap_or(decade);
            return (0..=(high / step) as u32).map(|i| f64::from(i) * step).collect();
        }
        // Fewer digits where there are many decades.
        let digits: &[f64] = match high - low {
            ..0.7 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
            ..2.2 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let decades =
            (low.floor() as i32..=high.ceil() as i32).step_by(((high - low) / 8.0).ceil() as usize);
        let all = decades.flat_map(|d| digits.iter().map(move |x| x * 10_f64.powi(d)));
        let lowest = self.zero.map_or(low, |zero| zero + 0.02);
        let inside = all.filter(|x| (lowest..=high).contains(&x.log10()));
        self.zero.map(|_| 0.0).into_iter().chain(inside).collect()
    }
}

impl Panel {
    fn draw(&self, svg: &mut String, [x0, y0]: [f64; 2]) {
        let [left, right, top, bottom] = MARGINS;
        let [x0, x1] = [x0 + left, x0 + PANEL[0] - right];
        let [y0, y1] = [y0 + top, y0 + PANEL[1] - bottom];
        let points = || self.series.iter().flat_map(|series| series.points.iter().copied());
        let x = Ruler::new(self.x.scale, points().map(|p| p.0), [x0, x1]);
        let y = Ruler::new(self.y.scale, points().map(|p| p.1), [y1, y0]);
        text(svg, [x0, y0 - 22.0], 15, "start", &self.title);
        text(svg, [x1, y0 - 6.0], 12, "end", &format!("better: {}", self.better));
        for tick in x.ticks() {
            let at = x.pixel(tick);
            line(svg, [at, y1], [at, y0], "#ddd");
            text(svg, [at, y1 + 16.0], 12, "middle", &short(tick));
        }
        for tick in y.ticks() {
            let at = y.pixel(tick);
            line(svg, [x0, at], [x1, at], if tick == 0.0 { "#888" } else { "#ddd" });
            text(svg, [x0 - 6.0, at + 4.0], 12, "end", &short(tick));
        }
        line(svg, [x0, y1], [x1, y1], "black");
        line(svg, [x0, y1], [x0, y0], "black");
        text(svg, [0.5 * (x0 + x1), y1 + 38.0], 13, "middle", &self.x.label);
        let middle = 0.5 * (y0 + y1);
        let _ = write!(svg, "<g transform=\"rotate(-90 {0} {middle})\">", x0 - 56.0);
        text(svg, [x0 - 56.0, middle], 13, "middle", &self.y.label);
        svg.push_str("</g>\n");
        for (number, series) in self.series.iter().enumerate() {
            let points = series.points.iter().filter(|p| p.0.is_finite() && p.1.is_finite());
            let points: Vec<_> = points.map(|p| [x.pixel(p.0), y.pixel(p.1)]).collect();
            match (series.style, &points[..]) {
                (Style::Points, _) => {}
                (Style::Area, [first, .., last]) => {
                    let corners = [[last[0], y1], [first[0], y1]];
                    area(svg, number, points.iter().chain(&corners));
                    continue;
                }
                _ => polyline(svg, number, &points),
            }
            let step = match series.style {
                Style::Points => 1,
                _ => points.len().div_ceil(MARKERS).max(1),
            };
            // Series that lie on each other have their markers in different places.
            points.iter().skip(number % step).step_by(step).for_each(|at| mark(svg, number, *at));
        }
    }

    fn legend(&self, svg: &mut String, [x, mut y]: [f64; 2]) {
        for (number, series) in self.series.iter().enumerate() {
            y += 20.0;
            let [left, right] = [x, x + 36.0];
            match series.style {
                Style::Area => {
                    let [low, high] = [y - 7.0, y + 7.0];
                    let corners = [[left, low], [right, low], [right, high], [left, high]];
                    area(svg, number, corners.iter());
                }
                Style::Line => polyline(svg, number, &[[left, y], [right, y]]),
                Style::Points => {}
            }
            if series.style != Style::Area {
                mark(svg, number, [x + 18.0, y]);
            }
            text(svg, [x + 44.0, y + 4.0], 13, "start", &series.name);
        }
    }
}

// Writing to a string does not fail.
fn text(svg: &mut String, [x, y]: [f64; 2], size: u32, anchor: &str, what: &str) {
    let what = what.replace('&', "&amp;").replace('<', "&lt;");
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\">{what}</text>"
    );
}

fn line(svg: &mut String, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2], colour: &str) {
    let _ = writeln!(
        svg,
        "<line x1=\"{x0:.1}\" y1=\"{y0:.1}\" x2=\"{x1:.1}\" y2=\"{y1:.1}\" stroke=\"{colour}\"/>"
    );
}

fn polyline(svg: &mut String, number: usize, points: &[[f64; 2]]) {
    let (colour, dash) = (COLOURS[number % COLOURS.len()], DASHES[number % DASHES.len()]);
    svg.push_str("<polyline points=\"");
    coordinates(svg, points.iter());
    let _ = writeln!(
        svg,
        "\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\" stroke-dasharray=\"{dash}\"/>"
    );
}

fn area<'a>(svg: &mut String, number: usize, corners: impl Iterator<Item = &'a [f64; 2]>) {
    svg.push_str("<polygon points=\"");
    coordinates(svg, corners);
    let _ = writeln!(svg, "\" fill=\"{}\" stroke=\"white\"/>", COLOURS[number % COLOURS.len()]);
}

fn coordinates<'a>(svg: &mut String, points: impl Iterator<Item = &'a [f64; 2]>) {
    for [x, y] in points {
        let _ = write!(svg, "{x:.1},{y:.1} ");
    }
}

fn mark(svg: &mut String, number: usize, [x, y]: [f64; 2]) {
    let (colour, path) = (COLOURS[number % COLOURS.len()], MARKS[number % MARKS.len()]);
    let _ = writeln!(
        svg,
        "<path d=\"{path}\" transform=\"translate({x:.1} {y:.1})\" fill=\"{colour}\" stroke=\"black\" stroke-width=\"0.7\"/>"
    );
}

/// A number as short as it can be said with three digits.
pub fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        1e-3..99_999.5 => {
            let digits = (2.0 - x.abs().log10().floor()).max(0.0) as usize;
            let text = format!("{x:.digits$}");
            let cut = if text.contains('.') { text.trim_end_matches('0') } else { &text };
            cut.trim_end_matches('.').to_owned()
        }
        _ => format!("{x:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_has_ticks_at_every_scale() {
        for scale in [Scale::Linear, Scale::Log] {
            for [low, high] in [[20.0, 300.0], [1.0, 1.07], [0.0, 3e6], [1e-9, 1e9], [7.0, 7.0]] {
                let ruler = Ruler::new(scale, [low, high].into_iter(), [0.0, 100.0]);
                let ticks = ruler.ticks();
                assert!((2..=14).contains(&ticks.len()), "{scale:?} {low} {high}: {ticks:?}");
                assert!(
                    ticks.iter().all(|t| (0.0..=100.0).contains(&ruler.pixel(*t))),
                    "{ticks:?}"
                );
                let mut labels: Vec<_> = ticks.iter().map(|tick| short(*tick)).collect();
                labels.dedup();
                assert_eq!(labels.len(), ticks.len(), "{labels:?}");
            }
        }
    }

    #[test]
    fn numbers_are_short() {
        let numbers = [0.0, 0.05, 1.0, 2.5, 1234.0, 1e6, 6e-8];
        assert_eq!(numbers.map(short), ["0", "0.05", "1", "2.5", "1234", "1e6", "6e-8"]);
    }

    #[test]
    fn series_differ_without_colour_and_legends_are_shared_where_they_can_be() {
        let series = |name: &str| Series {
            name: name.to_owned(),
            points: vec![(1.0, 0.0), (9.0, 2.0)],
            style: Style::Line,
        };
        let axis = || Axis { label: "n & m".to_owned(), scale: Scale::Log };
        let panel = |names: &[&str]| Panel {
            title: String::new(),
            better: "down",
            x: axis(),
            y: axis(),
            series: names.iter().map(|name| series(name)).collect(),
        };
        let figure = |panels| Figure { title: "<".to_owned(), columns: 2, panels }.svg();
        let same = figure(vec![panel(&["one", "two"]), panel(&["one", "two"])]);
        assert_eq!([same.matches(">one<").count(), same.matches("better: down").count()], [1, 2]);
        let document = roxmltree::Document::parse(&same).unwrap();
        let styles = |attribute| {
            let mut all: Vec<_> =
                document.descendants().filter_map(|n| n.attribute(attribute)).collect();
            all.sort_unstable();
            all.dedup();
            all.len()
        };
        assert_eq!([styles("stroke-dasharray"), styles("d")], [2, 2]);
        let other = figure(vec![panel(&["one"]), panel(&["two"])]);
        assert_eq!([other.matches(">one<").count(), other.matches(">two<").count()], [1, 1]);
    }
}
