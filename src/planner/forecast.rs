//! What the next frame will cost.

/// A question of fewer box tests is nothing to any way.
const NOTHING: f64 = 500.0;
/// A frame that costs so many times more or less than expected, on the logarithm's scale, is a surprise.
const SURPRISE: f64 = 0.7;
/// What each frame changes about how surprised to be.
const WEIGHT: f64 = 0.25;
/// What a frame among surprises changes about the mean.
const AMONG_SURPRISES: f64 = 0.2;

/// The cost of frames that resemble each other, as the last one, or of frames that jump, as their mean.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Forecast {
    /// The last cost and the mean.
    costs: Option<[f64; 2]>,
    /// How far one cost is from the next on average, on the logarithm's scale.
    surprise: f64,
}

impl Forecast {
    /// In box tests; `None` before the first frame.
    pub(super) fn cost(&self) -> Option<f64> {
        self.costs.map(|[last, mean]| if self.is_jumpy() { mean } else { last })
    }

    /// Whether frames are often far from what the last one cost.
    pub(super) fn is_jumpy(&self) -> bool {
        self.surprise > SURPRISE
    }

    pub(super) fn learn(&mut self, cost: f64) {
        let [last, mean] = self.costs.unwrap_or([cost; 2]);
        let off = ((cost + NOTHING) / (last + NOTHING)).ln().abs();
        self.surprise += WEIGHT * (off - self.surprise);
        self.costs = Some([cost, mean + AMONG_SURPRISES * (cost - mean)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(costs: impl IntoIterator<Item = f64>) -> Forecast {
        let mut forecast = Forecast::default();
        costs.into_iter().for_each(|cost| forecast.learn(cost));
        forecast
    }

    #[test]
    fn coherent_frames_cost_what_the_last_did_and_jumping_ones_their_mean() {
        assert_eq!(after([]).cost(), None);
        assert_eq!(after((0..50).map(|i| 1e5 + f64::from(i * i))).cost(), Some(1e5 + 2401.0));
        let jumping = after([1e6, 1e3].repeat(20));
        assert!(jumping.is_jumpy());
        assert!((2e5..8e5).contains(&jumping.cost().unwrap_or(0.0)));
        // One jump is soon forgotten, and nothing is one among costs that are next to nothing.
        assert!(!after([1e4; 20].into_iter().chain([1e6; 5])).is_jumpy());
        assert!(!after([1.0, 100.0].repeat(20)).is_jumpy());
        assert!(!after([1e6, 1e3].repeat(20).into_iter().chain([1e5; 20])).is_jumpy());
    }
}
