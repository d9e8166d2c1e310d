//! Latin hypercubes (McKay, Beckman & Conover, *A Comparison of Three Methods for Selecting Values of Input
//! Variables*, Technometrics 1979): of n cases, one lies in each of n equal parts of every variable's range,
//! so that a few dozen cover all of them evenly, whatever the seed.

use pfront_testkit::rng::{ChaCha8Rng, RngExt, seq::SliceRandom};

/// One number in each of `n` equal parts of 0 to 1, in random order.
pub(super) fn spread(n: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let mut all: Vec<f64> =
        (0..n).map(|part| (part as f64 + random.random::<f64>()) / n as f64).collect();
    all.shuffle(random);
    all
}

/// `n` of some values, each as often as the others or once more, in random order.
pub(super) fn deal<T: Copy>(values: &[T], n: usize, random: &mut ChaCha8Rng) -> Vec<T> {
    let mut turns = values.to_vec();
    turns.shuffle(random);
    let mut all: Vec<T> = turns.into_iter().cycle().take(n).collect();
    all.shuffle(random);
    all
}

/// From `least` to `most` as `share` goes from 0 to 1, by equal factors for equal steps.
pub(super) fn by_factors(least: usize, most: usize, share: f64) -> usize {
    let [low, high] = [least, most.max(least)].map(|n| (n as f64).ln());
    ((low + (high - low) * share).exp().round() as usize).clamp(least, most.max(least))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::rng::seeded;

    #[test]
    fn every_part_is_met_once() {
        for n in [1, 2, 7, 40] {
            let mut all = spread(n, &mut seeded(n as u64));
            all.sort_by(f64::total_cmp);
            assert!(all.iter().enumerate().all(|(part, x)| (x * n as f64) as usize == part));
        }
    }

    #[test]
    fn values_are_dealt_evenly() {
        let dealt = deal(&[1, 2, 3], 8, &mut seeded(3));
        let mut counts = [1, 2, 3].map(|value| dealt.iter().filter(|x| **x == value).count());
        counts.sort_unstable();
        assert_eq!(counts, [2, 3, 3]);
    }

    #[test]
    fn factors_are_even() {
        assert_eq!([0.0, 0.5, 1.0].map(|share| by_factors(1, 10_000, share)), [1, 100, 10_000]);
        assert_eq!(by_factors(20, 4, 0.7), 20);
    }
}
