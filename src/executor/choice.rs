//! The choice between the CPU and a GPU, for one verb of one query: see [the bound](crate::executor).

use super::Reason;
use std::time::Duration;

/// On the GPU, the CPU answers one frame as soon as the GPU has taken so many times what the CPU last took, in case it has
/// become faster. Each further such frame comes twice as late.
const FIRST_CHECK: f64 = 8.0;

/// The line of a GPU and a CPU. All times are in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    /// To ask anything at all and read the answer.
    pub(super) latency: f64,
    /// The time of a longer question beyond that, as a multiple of its time on the CPU.
    pub(super) slope: f64,
    /// To bring a model there, however small.
    pub(super) setup: f64,
    /// To bring a triangle there.
    pub(super) upload: f64,
}

impl Line {
    /// To bring so many triangles there.
    pub(super) fn upload(&self, triangles: usize) -> f64 {
        if triangles == 0 { 0.0 } else { self.setup + self.upload * triangles as f64 }
    }
}

/// Predictions are the last frames of both sides. All times are in seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    is_on_gpu: bool,
    /// Whether the last frame took the CPU less than any GPU.
    pub(super) is_at_once: bool,
    cpu: Option<f64>,
    /// Uploads are not part of it.
    gpu: Option<f64>,
    /// The difference between the first frames on the GPU and the measured line.
    offset: f64,
    /// The time that the other side would have saved since the last change.
    saved: f64,
    /// Frames since the last change.
    frames: u32,
    /// The time on the GPU since the CPU was last asked, and, in frames of the CPU, when to ask it again.
    since_check: f64,
    next_check: f64,
}

impl Default for Choice {
    fn default() -> Self {
        Self {
            is_on_gpu: false,
            is_at_once: false,
            cpu: None,
            gpu: None,
            offset: 0.0,
            saved: 0.0,
            frames: 0,
            since_check: 0.0,
            next_check: FIRST_CHECK,
        }
    }
}

impl Choice {
    /// Whether the GPU answered last, checks aside.
    pub(super) fn is_on_gpu(&self) -> bool {
        self.is_on_gpu
    }

    /// The predictions for the next frame, on the CPU and on the GPU.
    pub(super) fn predicted(&self, line: &Line) -> Option<[Duration; 2]> {
        let cpu = self.cpu?;
        let duration = |time| Duration::try_from_secs_f64(time).unwrap_or(Duration::MAX);
        Some([cpu, self.on_gpu(line, cpu)].map(duration))
    }

    fn on_gpu(&self, line: &Line, cpu: f64) -> f64 {
        let by_line = (line.latency + line.slope * cpu + self.offset).max(line.latency);
        self.gpu.filter(|_| self.is_on_gpu).unwrap_or(by_line)
    }

    /// Chooses for a frame before which the GPU has to be brought what takes `upload`. Returns whether the GPU answers.
    pub(super) fn choose(&mut self, line: &Line, upload: f64) -> (bool, Reason) {
        let Some(cpu) = self.cpu else { return (false, Reason::Unknown) };
        let gpu = self.on_gpu(line, cpu);
        // A change costs the upload, and one frame on the other side if the prediction is wrong.
        let (own, other, price) = match self.is_on_gpu {
            true => (gpu + upload, cpu, cpu),
            false => (cpu, gpu, gpu + upload),
        };
        // No single frame decides.
        self.saved = (self.saved + (own - other).min(price / 2.0)).max(0.0);
        if own > other && self.saved >= price {
            (self.is_on_gpu, self.frames, self.saved) = (!self.is_on_gpu, 0, 0.0);
            (self.since_check, self.next_check) = (0.0, FIRST_CHECK);
            return (self.is_on_gpu, Reason::Faster);
        }
        if self.is_on_gpu && self.since_check >= self.next_check * cpu {
            return (false, Reason::Check);
        }
        let reason = if own > other { Reason::NotWorthChanging } else { Reason::Faster };
        (self.is_on_gpu, reason)
    }

    /// Takes note of the time of a frame, which the GPU answered or did not, after an upload or without.
    pub(super) fn took(&mut self, line: &Line, by_gpu: bool, uploaded: bool, time: Duration) {
        let time = time.as_secs_f64();
        let is_first = self.frames == 0;
        self.frames = self.frames.saturating_add(1);
        match (self.is_on_gpu, by_gpu) {
            (false, _) => self.cpu = Some(time),
            // A check wakes threads as well: it can only lower the prediction.
            (true, false) => {
                self.cpu = Some(self.cpu.map_or(time, |before| time.min(before)));
                (self.next_check, self.since_check) = (2.0 * self.next_check, 0.0);
            }
            (true, true) => {
                self.since_check += time;
                // The first frame grows buffers.
                if is_first || uploaded {
                    return;
                }
                if let (None, Some(cpu)) = (self.gpu, self.cpu) {
                    self.offset = time - (line.latency + line.slope * cpu);
                }
                self.gpu = Some(time);
            }
        }
    }
}

/// The most frames for which a GPU that has failed is not asked.
const LONGEST_PAUSE: u32 = 1 << 10;

/// A failure of the GPU, after which the CPU answers for a while: one frame after the first, twice as many after each that
/// follows, up to [`LONGEST_PAUSE`]. A device that is lost is never asked again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Failure {
    reason: Option<String>,
    /// Frames until the GPU may be asked again; `None` if it never is.
    left: Option<u32>,
    /// The frames of the last pause.
    pause: u32,
}

impl Failure {
    /// The error, as long as the GPU has not answered since.
    pub(super) fn reason(&self) -> Option<&str> {
        self.reason.as_deref()
    }

    /// Whether the GPU is not asked in the next frame.
    pub(super) fn is_pausing(&self) -> bool {
        self.reason.is_some() && self.left != Some(0)
    }

    /// Takes note of a frame in which the GPU was not asked since it is pausing.
    pub(super) fn passed(&mut self) {
        self.left = self.left.map(|left| left.saturating_sub(1));
    }

    /// Takes note of an error of the GPU.
    pub(super) fn failed(&mut self, reason: String, is_lost: bool) {
        self.pause = (2 * self.pause).clamp(1, LONGEST_PAUSE);
        self.left = (!is_lost).then_some(self.pause);
        self.reason = Some(reason);
    }

    /// Takes note of an answer of the GPU.
    pub(super) fn answered(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::rng::{RngExt, seeded};

    const LINE: Line = Line { latency: 1e-4, slope: 0.05, setup: 1e-3, upload: 5e-8 };
    const UPLOAD: f64 = 6e-3;

    /// Plays frames by their times on the CPU and on the GPU, and whether models have come that the GPU lacks. Returns
    /// the time of all frames by choice, on the CPU, and on the GPU.
    fn play(frames: impl IntoIterator<Item = (f64, f64, bool)>) -> [f64; 3] {
        let (mut choice, mut sums, mut is_there) = (Choice::default(), [0.0, 0.0, UPLOAD], false);
        for (cpu, gpu, is_new) in frames {
            is_there &= !is_new;
            let upload = if is_there { 0.0 } else { UPLOAD };
            let (by_gpu, _) = choice.choose(&LINE, upload);
            let took = if by_gpu { gpu + upload } else { cpu };
            choice.took(&LINE, by_gpu, by_gpu && !is_there, Duration::from_secs_f64(took));
            is_there |= by_gpu;
            sums = [sums[0] + took, sums[1] + cpu, sums[2] + gpu + f64::from(is_new) * UPLOAD];
        }
        sums
    }

    #[test]
    fn frames_that_are_alike_take_at_most_twice_the_better_side() {
        for cpu in [1e-6, 5e-5, 1.05e-4, 2e-4, 1e-3, 2e-2] {
            for factor in [1.0, 1.5, 5.0, 40.0] {
                let gpu = factor * (LINE.latency + LINE.slope * cpu);
                for n in [1, 2, 5, 10, 30, 300, 3000] {
                    let [own, on_cpu, on_gpu] = play(vec![(cpu, gpu, false); n]);
                    let best = on_cpu.min(on_gpu);
                    let mut most = (2.0 + 0.125) * best + 4.0 * cpu.max(gpu);
                    if factor > 1.0 {
                        // The line promised more: that costs one upload.
                        most += UPLOAD;
                    }
                    assert!(own <= most * (1.0 + 1e-9), "{cpu} {gpu} {n}: {own} of {most}");
                }
            }
        }
    }

    /// The frames of so many in which a GPU is asked that answers from this frame on.
    fn asked(frames: u32, heals_at: u32, is_lost: bool) -> Vec<u32> {
        let (mut failure, mut asked) = (Failure::default(), Vec::new());
        for frame in 0..frames {
            if failure.is_pausing() {
                failure.passed();
                continue;
            }
            asked.push(frame);
            match frame < heals_at {
                true => failure.failed("a failure".to_owned(), is_lost),
                false => failure.answered(),
            }
            assert_eq!(failure.reason().is_some(), frame < heals_at);
        }
        asked
    }

    #[test]
    fn a_gpu_that_failed_is_asked_again_after_longer_and_longer_pauses() {
        assert_eq!(asked(40, u32::MAX, false), [0, 2, 5, 10, 19, 36]);
        let often = asked(10_000, u32::MAX, false);
        assert!(often.windows(2).all(|two| two[1] - two[0] <= LONGEST_PAUSE + 1));
        assert!(often.len() > 15, "{often:?}");
        // As soon as it answers it is asked always, and a later failure is the first again.
        assert_eq!(asked(14, 5, false), [0, 2, 5, 6, 7, 8, 9, 10, 11, 12, 13]);
    }

    #[test]
    fn a_lost_gpu_is_never_asked_again() {
        assert_eq!(asked(10_000, u32::MAX, true), [0]);
    }

    #[test]
    fn long_sequences_take_what_the_better_side_takes() {
        let [own, _, on_gpu] = play([(4e-3, 3e-4, false); 300]);
        assert!(own < 1.15 * on_gpu, "{own} {on_gpu}");
        let [own, on_cpu, _] = play([(5e-5, 1.1e-4, false); 300]);
        assert_eq!(own, on_cpu);
    }

    #[test]
    fn a_gpu_that_was_overrated_is_left() {
        let [own, on_cpu, _] = play([(4e-3, 8e-3, false); 300]);
        assert!(own < 1.1 * on_cpu, "{own} {on_cpu}");
    }

    #[test]
    fn frames_that_become_small_for_the_cpu_alone_go_back_to_it() {
        // The GPU refits and poses a large scene whatever there is to find.
        let frames = [(3e-2, 3e-3, false); 100].into_iter().chain([(5e-5, 2e-3, false); 2000]);
        let [own, on_cpu, on_gpu] = play(frames);
        assert!(own < 0.3 * on_gpu && own < 0.5 * on_cpu, "{own} {on_cpu} {on_gpu}");
    }

    #[test]
    fn models_that_come_in_every_frame_are_left_to_the_cpu() {
        let frames = [(1e-2, 6e-4, false); 50].into_iter().chain([(1e-2, 6e-4, true); 500]);
        let [own, on_cpu, on_gpu] = play(frames);
        assert!(own < 1.3 * on_cpu.min(on_gpu), "{own} {on_cpu} {on_gpu}");
    }

    #[test]
    fn one_frame_that_was_interrupted_changes_nothing() {
        let calm = (5e-5, 1.1e-4, false);
        let frames = [calm; 50].into_iter().chain([(1e-2, 1.1e-4, false)]).chain([calm; 50]);
        let [own, on_cpu, _] = play(frames);
        assert_eq!(own, on_cpu);
    }

    #[test]
    fn frames_that_jump_take_at_most_four_times_the_better_side() {
        let mut rng = seeded(7);
        for round in 0..200 {
            let spread = f64::from(round % 5);
            let frames: Vec<_> = (0..400)
                .map(|_| {
                    let cpu = 1e-3 * 10_f64.powf(rng.random_range(-spread..=spread) / 2.0);
                    (cpu, 1e-4 + 0.1 * cpu, false)
                })
                .collect();
            let [own, on_cpu, on_gpu] = play(frames);
            assert!(own < 4.0 * on_cpu.min(on_gpu), "{spread}: {own} {on_cpu} {on_gpu}");
        }
    }
}
