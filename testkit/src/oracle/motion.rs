//! Exact truth: whether two triangles meet while their corners move in straight lines.
//!
//! Two triangles that do not meet at first meet first where a corner of one comes upon the other, or an edge of each upon the other. Then the four
//! points concerned are coplanar: at a root of a cubic, or always. Two sets of coplanar points have a point of their hulls in common exactly
//! if their projections along all three axes have: along an axis that does not see the plane edge-on (or their line end-on) nothing is lost.
//! Asked of the projections are signs of quadratics and linear functions of time, which closed conditions combine. So the first time at
//! which they hold, if there is one, is the beginning or a root of one of these polynomials; all are tried, with signs by Sturm sequences.

use super::lattice::Vector;
use super::separated;
use super::sturm::{Dyadic, Polynomial, Time};
use num_bigint::BigInt;
use num_traits::Zero;

/// The corners of a triangle at the times 0 and 1.
pub type MovingTriangle = [[[f64; 3]; 3]; 2];

/// A point whose coordinates are linear in time.
type Moving = [Polynomial; 3];

/// Whether two closed triangles share a point at a time of the interval, which is in [0, 1]; one without area is its segment or point.
pub fn meet_while_moving(a: &MovingTriangle, b: &MovingTriangle, interval: [f64; 2]) -> bool {
    let [from, to] = interval.map(dyadic);
    let [ends_a, ends_b] = on_lattice(a, b);
    let at = |ends: &[[Vector<BigInt>; 3]; 2]| -> Vec<Vector<BigInt>> {
        let one = BigInt::from(1) << from.exponent;
        (0..3)
            .map(|k| {
                [0, 1, 2].map(|axis| {
                    &ends[0][k][axis] * (&one - &from.numerator)
                        + &ends[1][k][axis] * &from.numerator
                })
            })
            .collect()
    };
    if !separated(&at(&ends_a), &at(&ends_b)) {
        return true;
    }
    let moving = |ends: &[[Vector<BigInt>; 3]; 2]| {
        [0, 1, 2].map(|k| {
            [0, 1, 2].map(|axis| {
                let (start, end) = (&ends[0][k][axis], &ends[1][k][axis]);
                Polynomial::new(vec![start.clone(), end - start])
            })
        })
    };
    let (a, b) = (moving(&ends_a), moving(&ends_b));
    let interval = [from, to];
    let edges = |t: &[Moving; 3]| [0, 1, 2].map(|k| [t[k].clone(), t[(k + 1) % 3].clone()]);
    [(&a, &b), (&b, &a)].into_iter().any(|(t, other)| {
        t.iter().any(|corner| hulls_meet(&interval, std::slice::from_ref(corner), other))
    }) || edges(&a).iter().any(|e| edges(&b).iter().any(|f| hulls_meet(&interval, e, f)))
}

/// Whether two triangles of one mesh meet at a time of the interval, what they share by index being no contact: as in
/// [`self_hit`](super::self_hit), but with a shared edge they meet where the opposite corner of one is in the other, or two edges meet
/// that have no vertex in common.
///
/// # Panics
/// If an index is out of range.
pub fn self_hit_while_moving(
    ta: [u32; 3],
    tb: [u32; 3],
    positions: [&[[f64; 3]]; 2],
    interval: [f64; 2],
) -> bool {
    let rest = |own: [u32; 3], other: [u32; 3]| -> Vec<u32> {
        let mut rest: Vec<_> = own.into_iter().filter(|v| !other.contains(v)).collect();
        rest.sort_unstable();
        rest.dedup();
        rest
    };
    // Up to three vertices as a triangle.
    let hull = |of: &[u32]| -> MovingTriangle {
        positions.map(|p| [0, 1, 2].map(|k| p[of[k.min(of.len() - 1)] as usize]))
    };
    let meet = |p: &[u32], q: &[u32]| meet_while_moving(&hull(p), &hull(q), interval);
    let mut shared: Vec<u32> = ta.into_iter().filter(|v| tb.contains(v)).collect();
    shared.sort_unstable();
    shared.dedup();
    let (rest_a, rest_b) = (rest(ta, tb), rest(tb, ta));
    match (&shared[..], &rest_a[..], &rest_b[..]) {
        ([], _, _) => meet(&ta, &tb),
        ([_, _, _], _, _) | (_, [], []) => true,
        ([_, _], [], _) | ([_, _], _, []) => false,
        (&[e, f], &[c, ..], &[d, ..]) => {
            meet(&[c], &tb) || meet(&[d], &ta) || meet(&[e, c], &[f, d]) || meet(&[f, c], &[e, d])
        }
        _ => !rest_a.is_empty() && meet(&rest_a, &tb) || !rest_b.is_empty() && meet(&rest_b, &ta),
    }
}

/// Whether a point and a triangle, or two segments, have a point in common at a time of the interval.
fn hulls_meet(interval: &[Dyadic; 2], p: &[Moving], q: &[Moving]) -> bool {
    let points: Vec<_> = p.iter().chain(q).collect();
    let [u, v, w] = [1, 2, 3].map(|k| minus(points[k], points[0]));
    let volume = &(&(&minor(&u, &v, 0) * &w[0]) + &(&minor(&u, &v, 1) * &w[1]))
        + &(&minor(&u, &v, 2) * &w[2]);
    let conditions = Conditions::new(p, q);
    let [from, to] = interval;
    let mut times = vec![Time::At(from.clone())];
    if volume.is_zero() {
        let roots = conditions.polynomials().filter(|p| !p.is_zero());
        times.extend(roots.flat_map(|p| p.sturm().roots(from, to)));
    } else {
        times.extend(volume.sturm().roots(from, to));
    }
    times.into_iter().any(|mut time| time.sign(&volume) == 0 && conditions.hold(&mut time))
}

/// The conditions under which two sets of coplanar points meet.
struct Conditions {
    /// Along each axis, turns: of a corner with three edges, or of the ends of each segment with the other.
    turns: Vec<Vec<Polynomial>>,
    is_corner: bool,
    /// Along each axis, the coordinates of the first points minus those of the second.
    differences: Vec<Vec<Polynomial>>,
}

impl Conditions {
    fn new(p: &[Moving], q: &[Moving]) -> Self {
        let turn =
            |a: &Moving, b: &Moving, c: &Moving, axis| minor(&minus(b, a), &minus(c, a), axis);
        let turns = |axis| match (p, q) {
            ([p], [r, s, t]) => vec![turn(r, s, p, axis), turn(s, t, p, axis), turn(t, r, p, axis)],
            ([p, p_end], [q, q_end]) => vec![
                turn(p, p_end, q, axis),
                turn(p, p_end, q_end, axis),
                turn(q, q_end, p, axis),
                turn(q, q_end, p_end, axis),
            ],
            _ => unreachable!("a point and a triangle, or two segments"),
        };
        let differences = |axis: usize| {
            p.iter().flat_map(|p| q.iter().map(move |q| &p[axis] - &q[axis])).collect()
        };
        Self {
            turns: (0..3).map(turns).collect(),
            is_corner: p.len() == 1,
            differences: (0..3).map(differences).collect(),
        }
    }

    fn polynomials(&self) -> impl Iterator<Item = &Polynomial> {
        self.turns.iter().chain(&self.differences).flatten()
    }

    /// Whether the projections along all three axes meet: boxes overlap, and the corner is on one side of all edges, or neither segment has
    /// the other on one side.
    fn hold(&self, time: &mut Time) -> bool {
        let mut signs = |of: &[Polynomial]| of.iter().map(|p| time.sign(p)).collect::<Vec<_>>();
        self.differences.iter().all(|of| {
            let signs = signs(of);
            signs.iter().any(|&s| s >= 0) && signs.iter().any(|&s| s <= 0)
        }) && self.turns.iter().all(|of| {
            let signs = signs(of);
            if self.is_corner {
                signs.iter().all(|&s| s >= 0) || signs.iter().all(|&s| s <= 0)
            } else {
                signs[0] * signs[1] <= 0 && signs[2] * signs[3] <= 0
            }
        })
    }
}

fn minus(p: &Moving, q: &Moving) -> Moving {
    [0, 1, 2].map(|axis| &p[axis] - &q[axis])
}

/// One component of the cross product.
fn minor(u: &Moving, v: &Moving, axis: usize) -> Polynomial {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    &(&u[j] * &v[k]) - &(&u[k] * &v[j])
}

pub(super) fn dyadic(time: f64) -> Dyadic {
    let (numerator, exponent) = parts(time);
    match exponent {
        0.. => Dyadic { numerator: BigInt::from(numerator) << exponent as u32, exponent: 0 },
        _ => Dyadic { numerator: numerator.into(), exponent: exponent.unsigned_abs() },
    }
}

/// The corners as integers, in a unit for each axis.
fn on_lattice(a: &MovingTriangle, b: &MovingTriangle) -> [[[Vector<BigInt>; 3]; 2]; 2] {
    let all = || [a, b].into_iter().flatten().flatten();
    let units = [0, 1, 2].map(|axis| {
        let exponents = all().map(|p| parts(p[axis])).filter(|x| x.0 != 0).map(|x| x.1);
        exponents.min().unwrap_or(0)
    });
    [a, b].map(|t| {
        t.map(|end| {
            end.map(|p| {
                [0, 1, 2].map(|axis| match parts(p[axis]) {
                    (0, _) => BigInt::zero(),
                    (odd, exponent) => BigInt::from(odd) << (exponent - units[axis]) as u32,
                })
            })
        })
    })
}

/// The odd integer m (or 0) and the exponent e of x = m · 2^e.
fn parts(x: f64) -> (i64, i32) {
    super::lattice::decode(x)
}
