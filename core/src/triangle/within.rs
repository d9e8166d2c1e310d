//! Whether two triangles are within a distance.

use super::{intersects, intersects_in_f64};
use crate::Triangle;
use crate::exact::features_are_within;

/// Whether two closed triangles have points at most `distance` apart, exactly; 0 or less asks whether they
/// [intersect](intersects).
///
/// Coordinates and the distance must be finite.
///
/// # Complexity
/// O(1), no allocation, below 12 KiB of stack: microseconds, of which [`Bvtt::within`](crate::bvtt::Bvtt::within) takes few.
///
/// # Examples
/// ```
/// use pfront_core::triangle::within;
/// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let tip = [[1.0, 1.0, 0.1], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]];
/// assert!(within(&floor, &tip, 0.1));
/// assert!(!within(&floor, &tip, 0.1_f32.next_down()));
/// ```
#[must_use]
pub fn within(a: &Triangle, b: &Triangle, distance: f32) -> bool {
    intersects(a, b) || distance > 0.0 && features_are_within(a, b, distance)
}

/// [`within`] of coordinates in f64, which are in range.
#[inline(never)]
pub(crate) fn within_in_f64(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3], distance: f32) -> bool {
    intersects_in_f64(a, b) || distance > 0.0 && features_are_within(a, b, distance)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use glam::DVec3;
    use pfront_testkit::families::{Family, InF64};
    use pfront_testkit::oracle;
    use pfront_testkit::rng::{RngExt, seeded};
    use std::vec;

    /// The distance in f64, roughly: that of points on both.
    fn roughly(a: &Triangle, b: &Triangle) -> f32 {
        let points = |t: &Triangle| {
            let [p, q, r] = t.map(|p| DVec3::from_array(p.map(f64::from)));
            (0..=16).flat_map(move |i| {
                (0..=16 - i).map(move |j| {
                    p + (q - p) * (f64::from(i) / 16.0) + (r - p) * (f64::from(j) / 16.0)
                })
            })
        };
        let lengths = points(a).flat_map(|p| points(b).map(move |q| p.distance(q)));
        lengths.fold(f64::INFINITY, f64::min) as f32
    }

    /// The largest f32 by which a pair is not within that of the oracle, and the next: the tightest questions there are.
    fn gap(a: &Triangle, b: &Triangle) -> [f32; 2] {
        let (mut low, mut high) = (0_u32, f32::MAX.to_bits());
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if oracle::within(a, b, f32::from_bits(middle)) { high = middle } else { low = middle }
        }
        [low, high].map(f32::from_bits)
    }

    #[test]
    fn triangles_are_within_as_the_oracle_says() {
        let mut rng = seeded(43);
        let rounds = if cfg!(miri) { 1 } else { 25 };
        let mut answers = [0; 2];
        for family in Family::ALL {
            for _ in 0..rounds {
                let (a, b) = family.pair(&mut rng);
                let near = roughly(&a, &b);
                let mut distances = vec![0.0, near, near * 0.5, near * 0.99, near * 2.0];
                distances.push(rng.random_range(0..4) as f32);
                if rng.random_range(0..5) == 0 {
                    distances.extend(gap(&a, &b));
                }
                for distance in distances.into_iter().filter(|d| d.is_finite()) {
                    let truth = oracle::within(&a, &b, distance);
                    assert_eq!(
                        within(&a, &b, distance),
                        truth,
                        "{family:?} {a:?} {b:?} {distance:e}"
                    );
                    assert_eq!(
                        within(&b, &a, distance),
                        truth,
                        "{family:?} {a:?} {b:?} {distance:e}"
                    );
                    answers[usize::from(truth)] += 1;
                }
            }
        }
        assert!(cfg!(miri) || answers.iter().all(|&count| count > 500), "{answers:?}");
    }

    /// A million decisions: the distance as f32 and its neighbours, 1 % more and less, and small integers.
    #[test]
    #[ignore = "takes a minute and a half: cargo test -p pfront-core --release --lib -- --ignored a_million"]
    fn a_million_decisions_are_those_of_the_oracle() {
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        let each = 1_000_000_usize.div_ceil(workers);
        std::thread::scope(|scope| {
            for worker in 0..workers {
                scope.spawn(move || decide(each, &mut seeded(1_000 + worker as u64)));
            }
        });
    }

    fn decide(most: usize, rng: &mut impl pfront_testkit::rng::Rng) {
        let (mut decided, mut answers) = (0, [0; 2]);
        for family in Family::ALL.into_iter().cycle() {
            let (a, b) = family.pair(rng);
            let near = roughly(&a, &b);
            let tight = if rng.random_range(0..40) == 0 { gap(&a, &b) } else { [near; 2] };
            let mut distances = vec![0.0, near, tight[0], tight[1], tight[0].next_down().max(0.0)];
            distances.extend([tight[1].next_up(), near * 1.01, near * 0.99]);
            distances.push(rng.random_range(1..5) as f32);
            distances.retain(|d| d.is_finite());
            let truths = oracle::within_each(&a, &b, &distances);
            for (&distance, truth) in distances.iter().zip(truths) {
                let found = within(&a, &b, distance);
                assert_eq!(found, truth, "{family:?} {a:?} {b:?} {distance:e}");
                answers[usize::from(truth)] += 1;
            }
            decided += distances.len();
            if decided >= most {
                break;
            }
        }
        std::println!("{decided} decisions, {answers:?} no and yes");
    }

    #[test]
    fn triangles_in_f64_are_within_as_the_oracle_says() {
        let mut rng = seeded(44);
        let mut answers = [0; 2];
        for (family, kind) in Family::ALL.into_iter().flat_map(|f| InF64::ALL.map(|k| (f, k))) {
            for _ in 0..if cfg!(miri) { 0 } else { 2 } {
                let Some((a, b)) = kind.pair(family, &mut rng) else { continue };
                let rounded = [a, b].map(|t| t.map(|p| p.map(|x| x as f32)));
                let near = roughly(&rounded[0], &rounded[1]);
                for distance in [0.0, near, near * 0.9].into_iter().filter(|d| d.is_finite()) {
                    let truth = oracle::within(&a, &b, f64::from(distance));
                    let found = within_in_f64(&a, &b, distance);
                    assert_eq!(found, truth, "{family:?} {kind:?} {a:?} {b:?} {distance:e}");
                    answers[usize::from(truth)] += 1;
                }
            }
        }
        assert!(cfg!(miri) || answers.iter().all(|&count| count > 100), "{answers:?}");
    }
}
