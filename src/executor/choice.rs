//! The choice between the CPU and a GPU, for one query: see [the bound](crate::executor).

use super::Reason;
use super::measure::Line;
use std::time::Duration;

/// The weight of what one change to the GPU tells about its slope.
const WEIGHT: f64 = 0.5;

/// All times are in seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Choice {
    is_on_gpu: bool,
    /// How many times as long as the CPU the GPU takes beyond its latency; that of the line before it was ever asked.
    slope: Option<f64>,
    /// What the last frame took on the CPU.
    cpu: Option<f64>,
    /// What the next frame is predicted to take on the CPU and on the GPU.
    predicted: Option<[f64; 2]>,
    /// What the other side would have saved.
    saved: f64,
    /// Frames since the last change.
    frames: u32,
    /// What it took to move vertices for the next frame.
    moving: f64,
}

impl Choice {
    pub(super) fn is_on_gpu(&self) -> bool {
        self.is_on_gpu
    }

    pub(super) fn predicted(&self) -> Option<[Duration; 2]> {
        Some(self.predicted?.map(|time| Duration::try_from_secs_f64(time).unwrap_or(Duration::MAX)))
    }

    /// Chooses for the next frame, before which the GPU lacks so many triangles.
    pub(super) fn choose(&mut self, line: &Line, to_upload: usize) -> Reason {
        let Some([cpu, gpu]) = self.predicted else { return Reason::NotWorthChanging };
        let (own, other) = if self.is_on_gpu { (gpu, cpu) } else { (cpu, gpu) };
        self.saved = (self.saved + own - other).max(0.0);
        let price = match (self.is_on_gpu, to_upload) {
            // What it costs if the prediction is wrong: a frame like the last one there.
            (true, _) => self.cpu.unwrap_or_default(),
            (false, 0) => line.latency,
            (false, triangles) => line.setup + line.upload * triangles as f64,
        };
        if own <= other {
            Reason::Faster
        } else if self.saved <= price {
            Reason::NotWorthChanging
        } else {
            (self.is_on_gpu, self.frames, self.saved) = (!self.is_on_gpu, 0, 0.0);
            Reason::Faster
        }
    }

    /// Takes note of what it took to move vertices, which belongs to the next frame.
    pub(super) fn moved(&mut self, time: Duration) {
        self.moving += time.as_secs_f64();
    }

    /// Takes note of what a frame took where it was asked.
    pub(super) fn took(&mut self, line: &Line, time: Duration) {
        let time = time.as_secs_f64() + std::mem::take(&mut self.moving);
        let slope = self.slope.unwrap_or(line.slope);
        let before = self.frames;
        self.frames = before.saturating_add(1);
        if !self.is_on_gpu {
            self.cpu = Some(time);
            self.predicted = Some([time, line.latency + slope * time]);
            return;
        }
        // The first frame also brings models there, and the second is the nearest to the last on the CPU.
        let beyond = (time - line.latency).max(0.0);
        let slope = match (before, self.cpu) {
            (0, _) => return,
            (1, Some(cpu)) if cpu > 0.0 => slope + WEIGHT * (beyond / cpu - slope),
            _ => slope,
        };
        self.slope = Some(slope);
        self.predicted = Some([beyond / slope.max(f64::EPSILON), time]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: Line = Line { latency: 1e-4, slope: 0.05, setup: 1e-3, upload: 5e-8 };

    /// Plays frames that take so long on the CPU, and `slope` times as long on a GPU with 100,000 triangles to bring there;
    /// returns what they took, and would have taken on either side all the time.
    fn play(slope: f64, frames: impl IntoIterator<Item = f64>) -> [f64; 3] {
        let (mut choice, mut is_there) = (Choice::default(), false);
        let mut sums = [0.0, 0.0, LINE.setup + LINE.upload * 1e5];
        for cpu in frames {
            choice.choose(&LINE, if is_there { 0 } else { 100_000 });
            let gpu = LINE.latency + slope * cpu;
            let mut took = if choice.is_on_gpu() { gpu } else { cpu };
            if choice.is_on_gpu() && !is_there {
                took += LINE.setup + LINE.upload * 1e5;
                is_there = true;
            }
            choice.took(&LINE, Duration::from_secs_f64(took));
            sums = [sums[0] + took, sums[1] + cpu, sums[2] + gpu];
        }
        sums
    }

    #[test]
    fn steady_frames_take_at_most_twice_the_better_side() {
        for cpu in [1e-6, 5e-5, 1.05e-4, 2e-4, 1e-3, 2e-2] {
            for slope in [0.02, 0.05, 0.5, 2.0] {
                for n in [1, 2, 5, 10, 30, 300, 3000] {
                    let [own, on_cpu, on_gpu] = play(slope, vec![cpu; n]);
                    let most = 2.0 * on_cpu.min(on_gpu) + cpu.max(LINE.latency + slope * cpu);
                    assert!(own <= most * (1.0 + 1e-9), "{cpu} {slope} {n}: {own} of {most}");
                }
            }
        }
    }

    #[test]
    fn long_sequences_take_what_the_better_side_takes() {
        let [own, _, on_gpu] = play(0.05, vec![4e-3; 300]);
        assert!(own < 1.1 * on_gpu, "{own} {on_gpu}");
        let [own, on_cpu, _] = play(0.05, vec![5e-5; 300]);
        assert_eq!(own, on_cpu);
    }

    #[test]
    fn a_gpu_that_was_overrated_is_left() {
        let [own, on_cpu, _] = play(2.0, vec![4e-3; 300]);
        assert!(own < 1.1 * on_cpu, "{own} {on_cpu}");
        // Frames that become small go back to the CPU.
        let frames = [4e-3; 100].into_iter().chain([1e-5; 2000]);
        let [own, _, on_gpu] = play(0.05, frames);
        assert!(own < 0.6 * on_gpu, "{own} {on_gpu}");
    }
}
