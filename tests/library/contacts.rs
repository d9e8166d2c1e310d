//! Contact segments against the exact points in which two triangles cross.

use pfront_core::triangle::contact;
use pfront_testkit::oracle::{crossing_points, intersect};
use pfront_testkit::rng::seeded;
use pfront_testkit::{Triangle, families::Family};

const PAIRS: u32 = 10_000;

/// Each end of a segment is where an edge reaches into the other triangle, and the segment spans all
/// such points: both within the documented 2^-28 of an edge and half a unit in the last place.
#[test]
fn ends_are_where_the_documentation_says() {
    for family in Family::ALL {
        let mut rng = seeded(21);
        for _ in 0..PAIRS {
            let (a, b) = family.pair(&mut rng);
            let found = contact(&a, &b);
            assert_eq!(found.is_some(), intersect(&a, &b), "{family:?}: {a:?} {b:?}");
            let Some(found) = found.filter(|c| !c.is_flat) else { continue };

            let ends = found.segment.map(|p| p.map(f64::from));
            let truth = crossing_points(&a, &b);
            let slack = [0, 1, 2].map(|k| slack(&a, &b, k));
            let message = || format!("{family:?}: {found:?} but {truth:?} for {a:?} {b:?}");
            for end in &ends {
                let near = |p: &[f64; 3]| (0..3).all(|k| (p[k] - end[k]).abs() <= slack[k]);
                assert!(truth.iter().any(near), "{}", message());
            }
            for (p, k) in truth.iter().flat_map(|p| [(p, 0), (p, 1), (p, 2)]) {
                let [x, y] = [ends[0][k], ends[1][k]];
                assert!(
                    x.min(y) - slack[k] <= p[k] && p[k] <= x.max(y) + slack[k],
                    "{}",
                    message()
                );
            }
        }
    }
}

/// A bound on rounding along one axis.
fn slack(a: &Triangle, b: &Triangle, axis: usize) -> f64 {
    let extent = [a, b].map(|t| {
        let x = t.map(|p| f64::from(p[axis]));
        x.iter().fold(f64::MIN, |m, x| m.max(*x)) - x.iter().fold(f64::MAX, |m, x| m.min(*x))
    });
    let size = a.iter().chain(b).fold(f32::MIN_POSITIVE, |m, p| m.max(p[axis].abs()));
    extent[0].max(extent[1]) * 2f64.powi(-28) + f64::from(size) * 2f64.powi(-24)
}
