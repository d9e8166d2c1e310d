//! What the next frame will cost.

use super::history::Look;

/// A question of fewer box tests is nothing to any way.
const NOTHING: f64 = 500.0;
/// A frame that costs so many times more or less than expected, on the logarithm's scale, is a surprise.
const SURPRISE: f64 = 0.7;
/// What each frame changes about how surprised to be.
const WEIGHT: f64 = 0.25;
/// What a frame among surprises changes about the mean.
const AMONG_SURPRISES: f64 = 0.2;
/// What sizes may change about the cost.
const MOST: f64 = 100.0;
/// What the rest of a question costs over what its boxes tell: more than 0.6 of it in half of the frames of 72
/// courses of two bodies; in one of twenty more than nine times as much, or less than a thirtieth. Too little
/// goes on alone for longer.
const BIAS: f64 = 0.8;
/// What each frame changes about that.
const OF_BIAS: f64 = 0.4;

/// The cost of frames that resemble each other, as the last one for its size, or of frames that jump, as their mean.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Forecast {
    last: Option<Past>,
    /// How far one cost is from the next on average, on the logarithm's scale.
    surprise: f64,
    /// Bias of estimates, on that scale; `None` before there was one.
    bias: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Past {
    cost: f64,
    /// In units of whoever asks, if it was looked at.
    size: Option<f64>,
    mean: f64,
}

impl Past {
    fn scaled(&self, size: Option<f64>) -> f64 {
        match (self.size, size) {
            (Some(before), Some(now)) if before > 0.0 => {
                self.cost * (now / before).clamp(MOST.recip(), MOST)
            }
            _ => self.cost,
        }
    }
}

impl Forecast {
    /// In box tests, of a question of this size; `None` before the first frame.
    pub(super) fn cost(&self, size: Option<f64>) -> Option<f64> {
        let last = self.last.as_ref()?;
        Some(if self.is_jumpy() { last.mean } else { last.scaled(size) })
    }

    /// Whether frames are often far from what the last one cost.
    pub(super) fn is_jumpy(&self) -> bool {
        self.surprise > SURPRISE
    }

    pub(super) fn learn(&mut self, cost: f64, size: Option<f64>) {
        let mean = self.last.map_or(cost, |last| last.mean + AMONG_SURPRISES * (cost - last.mean));
        let expected = self.last.map_or(cost, |last| last.scaled(size));
        // A logarithm takes as long as what is nothing.
        let off = match cost.max(expected) {
            ..NOTHING => 0.0,
            _ => ((cost + NOTHING) / (expected + NOTHING)).ln().abs(),
        };
        self.surprise += WEIGHT * (off - self.surprise);
        self.last = Some(Past { cost, size, mean });
    }

    /// What a question costs of which this much is seen.
    pub(super) fn of(&self, look: Look) -> f64 {
        self.bias.map_or(BIAS, f64::exp) * look.rest
    }

    /// The question cost this much in the end.
    pub(super) fn learn_rest(&mut self, look: Look, cost: f64) {
        let sample = ((cost - look.spent).max(1.0) / look.rest.max(1.0)).ln();
        let before = self.bias.unwrap_or(BIAS.ln());
        self.bias = Some(before + OF_BIAS * (sample - before));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(costs: impl IntoIterator<Item = f64>) -> Forecast {
        let mut forecast = Forecast::default();
        costs.into_iter().for_each(|cost| forecast.learn(cost, None));
        forecast
    }

    #[test]
    fn coherent_frames_cost_what_the_last_did_and_jumping_ones_their_mean() {
        assert_eq!(after([]).cost(None), None);
        let slow = after((0..50).map(|i| 1e5 + f64::from(i * i)));
        assert_eq!(slow.cost(None), Some(1e5 + 2401.0));
        let jumping = after([1e6, 1e3].repeat(20));
        assert!(jumping.is_jumpy());
        assert!((2e5..8e5).contains(&jumping.cost(None).unwrap_or(0.0)));
        // One jump is soon forgotten, and nothing is one among costs that are next to nothing.
        assert!(!after([1e4; 20].into_iter().chain([1e6; 5])).is_jumpy());
        assert!(!after([1.0, 100.0].repeat(20)).is_jumpy());
        assert!(!after([1e6, 1e3].repeat(20).into_iter().chain([1e5; 20])).is_jumpy());
    }

    #[test]
    fn what_costs_more_for_its_size_is_no_surprise() {
        let mut forecast = Forecast::default();
        for size in [1e3, 1e4, 2e3, 1.5e4].repeat(5) {
            forecast.learn(30.0 * size, Some(size));
        }
        assert!(!forecast.is_jumpy());
        assert_eq!(forecast.cost(Some(3e3)), Some(9e4));
        assert_eq!(forecast.cost(Some(1e9)), Some(MOST * 4.5e5));
        assert_eq!(forecast.cost(None), Some(4.5e5));
    }

    #[test]
    fn how_wrong_boxes_are_is_learned() {
        let mut forecast = Forecast::default();
        let look = Look { spent: 1e3, rest: 1e6, nanoseconds: None };
        assert_eq!(forecast.of(look), BIAS * 1e6);
        (0..20).for_each(|_| forecast.learn_rest(look, 1e3 + 1e5));
        assert!((0.9e5..1.1e5).contains(&forecast.of(look)), "{}", forecast.of(look));
    }
}
