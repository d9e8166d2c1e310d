//! The knowledge of each way.

/// Weight of the last frame in what is known of a way.
const WEIGHT: f64 = 0.25;
/// A way that takes so many times longer than another is not tried any further.
pub(super) const HOPELESS: f64 = 4.0;
/// A stay shorter than this was a mistake.
pub(super) const SHORT: u32 = 8;

/// What frames took over what was predicted for their costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ratio {
    pub(super) value: f64,
    /// How many frames have told.
    pub(super) frames: u32,
}

impl Ratio {
    pub(super) fn learn(&mut self, sample: f64) {
        let Self { value, frames } = *self;
        self.value = match frames {
            // The first frame also wakes threads or uploads, and says little, unless it is far off.
            0 => value * sample.max(HOPELESS) / HOPELESS,
            1 => sample.clamp(0.05, 20.0),
            // What interrupts a frame now and then says nothing either.
            _ => {
                let weight = if frames < SHORT { 0.5 } else { WEIGHT };
                value + weight * (sample.clamp(0.5 * value, 2.0 * value) - value)
            }
        };
        self.frames = frames.saturating_add(1);
    }

    /// Forgets, in so many frames, most of what was too much.
    pub(super) fn forget(&mut self, frames: f64) {
        self.value -= (self.value - 1.0).max(0.0) / frames;
    }
}

/// The knowledge of one way.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfWay {
    pub(super) ratio: Ratio,
    /// What it would have saved since it was last thought worse, in nanoseconds.
    pub(super) saved: f64,
    pub(super) forget: f64,
}
