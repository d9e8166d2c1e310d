//! The results of a case, and of all cases together.

use super::case::Verb;
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

/// A fixed plan that takes so many times as long as the best is not played again.
pub(super) const HOPELESS: f64 = 20.0;

/// The name of the plan of a GPU.
pub(super) const GPU: &str = "GPU";

/// The naive rule: all threads where one takes at least so many seconds for a frame, ...
const WORTH_THREADS: f64 = 0.3e-3;
/// ... each of which then does so much of what it does alone; ...
const EFFICIENCY: f64 = 0.6;
/// ... a GPU where this time, ...
const LATENCY: f64 = 0.1e-3;
/// ... this share of the time of one thread, ...
const SHARE: f64 = 1.0 / 64.0;
/// ... and, once, this time for each triangle promise to be less.
const UPLOAD: f64 = 10e-9;

/// A case with the times of all who played it, in seconds for all frames.
#[derive(Clone, Debug)]
pub struct Row {
    /// The case.
    pub name: String,
    /// The motion, and the shapes that move.
    pub class: String,
    /// The triangles of all bodies together.
    pub triangles: usize,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of frames.
    pub frames: usize,
    /// The question.
    pub verb: Verb,
    /// How many rounds were counted.
    pub rounds: usize,
    /// How many threads there are.
    pub threads: usize,
    /// Each fixed plan: one thread, more of them, all, and a GPU if there is one.
    pub fixed: Vec<Lane>,
    /// The time of the chooser.
    pub chooser: f64,
    /// The backends that were chosen, once everything was warm.
    pub tally: Tally,
    /// By how much the fixed plan that played twice in each round took longer than itself, as a share; less than
    /// nothing if it took less.
    pub noise: f64,
}

impl Row {
    /// The name of the fixed plan over which the chooser took longest.
    pub fn best(&self) -> &str {
        let best = self.fixed.iter().max_by(|x, y| x.chooser.total_cmp(&y.chooser));
        best.map_or("none", |lane| &lane.name)
    }

    /// By how much the chooser took longer than the best fixed plan, as a share of that.
    pub fn regret(&self) -> f64 {
        self.fixed.iter().map(|lane| lane.chooser).fold(0.0, f64::max) - 1.0
    }

    /// The chooser's time over that of one thread.
    pub fn to_sequential(&self) -> f64 {
        self.fixed.first().map_or(0.0, |lane| lane.chooser)
    }

    /// The regret of the naive rule: five constants, and the mean time on one thread, which nobody knows beforehand. It
    /// takes one plan for all frames, whose time is the median over rounds; where the plan was not played to the end,
    /// 20 times the best.
    pub fn naive(&self) -> f64 {
        let (cpu, gpu) = match &self.fixed[..] {
            [cpu @ .., gpu] if gpu.name == GPU => (cpu, gpu.seconds),
            cpu => (cpu, None),
        };
        let frames = self.frames as f64;
        let seconds = |lane: Option<&Lane>| lane.and_then(|lane| lane.seconds);
        let one = seconds(cpu.first()).unwrap_or(0.0) / frames;
        let (on_cpu, lane) = match one {
            WORTH_THREADS.. => (one / (EFFICIENCY * self.threads as f64), cpu.last()),
            _ => (one, cpu.first()),
        };
        let on_gpu = LATENCY + SHARE * one + UPLOAD * self.triangles as f64 / frames;
        let chosen = gpu.filter(|_| on_gpu < on_cpu).or(seconds(lane));
        let all = self.fixed.iter().filter_map(|lane| lane.seconds);
        let best = all.fold(f64::INFINITY, f64::min);
        chosen.map_or(HOPELESS, |seconds| seconds / best) - 1.0
    }

    /// The line above rows that have the same fixed plans as this one.
    pub fn heading(&self) -> String {
        let plans: String = self.fixed.iter().map(|lane| format!(" {:>11}", lane.name)).collect();
        format!(
            "{:<14} {:<CLASS$} {:>9} {:>6} {:>6} {:<5}{plans} {:>11} {:>8} {:>8} {:>7} {:>7}  mostly",
            "case",
            "what moves",
            "triangles",
            "bodies",
            "frames",
            "verb",
            "chooser",
            "regret",
            "naive",
            "to seq.",
            "A/A"
        )
    }
}

/// Letters of what moves.
const CLASS: usize = 24;

/// One line of a table.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<14} {:<CLASS$.CLASS$} {:>9} ", self.name, self.class, self.triangles)?;
        write!(f, "{:>6} {:>6} {:<5}", self.bodies, self.frames, self.verb.name())?;
        let best = self.best();
        for Lane { name, seconds, .. } in &self.fixed {
            let mark = if name == best { "*" } else { "" };
            let cell = seconds.map_or("-".to_owned(), |seconds| format!("{mark}{}", time(seconds)));
            write!(f, " {cell:>11}")?;
        }
        write!(f, " {:>11} {:>7.1}%", time(self.chooser), 100.0 * self.regret())?;
        write!(f, " {:>7.1}%", 100.0 * self.naive())?;
        write!(f, " {:>7.2} {:>6.1}%", self.to_sequential(), 100.0 * self.noise)?;
        write!(f, "  {}", self.tally.mostly())
    }
}

/// Figures of all cases. A chooser that beats all fixed plans, as one that keeps answers does, has a regret below 0.
pub fn summary(rows: &[Row]) -> String {
    let (kept, others): (Vec<_>, Vec<_>) = rows.iter().partition(|row| row.tally.frames[0] > 0);
    let all: Vec<_> = rows.iter().collect();
    let sequential = rows.iter().map(Row::to_sequential).fold(0.0, f64::max);
    format!(
        "Times of all frames: the median over rounds. Ratios: the median of those within rounds. * the best fixed plan,\n\
         - not played to the end, {HOPELESS} times slower or for want of memory. The naive rule knows the time of one thread.\n\
         {} cases, {} of them with frames answered from a cache\n\
         regret      {}\n\
         naive rule  {}\n\
         A/A         {}\n\
         without cases answered from a cache:\n\
         regret      {}\n\
         naive rule  {}\n\
         sequential  at worst {sequential:.2} times as long",
        rows.len(),
        kept.len(),
        figures(&all, Row::regret),
        figures(&all, Row::naive),
        figures(&all, |row| row.noise.abs()),
        figures(&others, Row::regret),
        figures(&others, Row::naive),
    )
}

fn figures(rows: &[&Row], value: fn(&Row) -> f64) -> String {
    let mut values: Vec<f64> = rows.iter().map(|row| 100.0 * value(row)).collect();
    values.sort_by(f64::total_cmp);
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let [p95, worst] = [0.95, 1.0].map(|q| quantile(&values, q));
    format!("mean {mean:.1} %, 95th percentile {p95:.1} %, at worst {worst:.1} %")
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

/// Writes a line for each row, with times in milliseconds. Plans that were not played to the end have no time.
///
/// # Errors
/// If it cannot be written.
pub fn write_csv(to: impl Write, rows: &[Row]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(to);
    let Some(first) = rows.first() else { return Ok(table.flush()?) };
    let column = |name: &str| name.replace(' ', "_");
    let mut head = ["case", "what_moves", "triangles", "bodies", "frames", "verb", "rounds"]
        .map(str::to_owned)
        .to_vec();
    head.extend(first.fixed.iter().map(|lane| format!("{}_ms", column(&lane.name))));
    head.extend(
        ["chooser_ms", "best", "regret", "naive", "to_sequential", "a_a", "changes"]
            .map(str::to_owned),
    );
    head.extend(Tally::NAMES.map(|name| format!("frames_{}", column(name))));
    table.write_record(head)?;
    for row in rows {
        let facts = [row.triangles, row.bodies, row.frames].map(|fact| fact.to_string());
        let milliseconds = |seconds: f64| format!("{:.6}", 1e3 * seconds);
        let mut line = vec![row.name.clone(), row.class.clone()];
        line.extend(facts);
        line.extend([row.verb.name().to_owned(), row.rounds.to_string()]);
        line.extend(row.fixed.iter().map(|lane| lane.seconds.map_or(String::new(), milliseconds)));
        line.extend([milliseconds(row.chooser), row.best().to_owned()]);
        let figures = [row.regret(), row.naive(), row.to_sequential(), row.noise];
        line.extend(figures.map(|x| format!("{x:.4}")));
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
            class: String::new(),
            triangles: 1,
            bodies: 2,
            frames: 1,
            verb: Verb::All,
            rounds: 1,
            threads: 2,
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
    fn the_naive_rule_takes_threads_for_long_frames_and_a_gpu_where_its_line_promises_more() {
        let case = |milliseconds: f64, others: &[(&str, f64)]| {
            let lanes = [("sequential", milliseconds)].into_iter().chain(others.iter().copied());
            let lane = |(name, ms): (&str, f64)| Lane {
                name: name.to_owned(),
                seconds: (ms > 0.0).then_some(1e-3 * ms),
                chooser: 1.0,
            };
            let fixed = lanes.map(lane).collect();
            (100.0 * Row { fixed, ..row([("", 1.0), ("", 1.0)], 0.0) }.naive()).round()
        };
        assert_eq!(case(0.29, &[("2 threads", 0.145)]), 100.0);
        assert_eq!(case(0.31, &[("2 threads", 0.62)]), 100.0);
        assert_eq!(case(0.4, &[("2 threads", 0.2), ("GPU", 0.3)]), 50.0);
        assert_eq!(case(0.4, &[("2 threads", 0.2), ("GPU", 0.0)]), 0.0);
        assert_eq!(case(8.0, &[("2 threads", 0.0)]), 1900.0);
    }

    #[test]
    fn quantiles_are_values_that_enough_do_not_exceed() {
        let values: Vec<f64> = (1..=40).map(f64::from).collect();
        assert_eq!([0.0, 0.5, 0.95, 1.0].map(|q| quantile(&values, q)), [1.0, 20.0, 38.0, 40.0]);
        assert_eq!(quantile(&[], 0.5), 0.0);
    }
}
