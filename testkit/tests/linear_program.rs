//! The oracle against a second exact formulation: linear programming by definition.
//!
//! Two hulls share a point exactly if Σλᵢpᵢ = Σμⱼqⱼ for some weights λ, μ ≥ 0 with sums 1. The simplex
//! method in integers (Bland's rule, so it ends) decides this, with numbers scaled by 2^149, which
//! makes every f32 an integer.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test fails by panicking")]

use num_bigint::BigInt;
use num_traits::{FromPrimitive, One, Signed, Zero};
use pfront_testkit::Point;
use pfront_testkit::families::Family;
use pfront_testkit::oracle::{intersect, self_hit};
use pfront_testkit::rng::seeded;

#[test]
fn known_answers() {
    let t = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let tiny = f32::from_bits(1);
    let spike = |z| [[1.0, 1.0, z], [1.0, 1.0, 9.0], [2.0, 1.0, 9.0]];
    assert!(intersect(&t, &spike(0.0)));
    assert!(intersect(&t, &spike(-tiny)));
    assert!(!intersect(&t, &spike(tiny)));
    assert!(intersect(&t, &[[2.0, 2.0, 0.0]; 3]), "a point on an edge");
    assert!(!intersect(&t, &[[2.0, 2.0 + 2e-7, 0.0]; 3]), "a point beside an edge");
    assert!(intersect(&t, &[[4.0, 0.0, 0.0], [9.0, 1.0, 0.0], [6.5, 0.5, 0.0]]), "end to corner");
    assert!(!intersect(&t, &[[5.0, 0.0, 0.0], [9.0, 0.0, 0.0], [6.0, 0.0, 0.0]]), "in line");
    assert!(intersect(&[[1.0; 3]; 3], &[[1.0; 3]; 3]), "two points");

    let points = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]];
    assert!(self_hit([0, 1, 2], [1, 0, 3], &points), "folded flat");
    assert!(!self_hit([0, 1, 2], [1, 0, 4], &points), "a flat sheet");
    assert!(!self_hit([0, 1, 1], [1, 0, 2], &points), "an edge of a neighbour");
    assert!(self_hit([0, 1, 1], [1, 0, 0], &points), "twice the same edge");
    assert!(!self_hit([2, 0, 1], [2, 3, 3], &points), "a segment from a corner");
}

/// Pairs of each family; `PFRONT_ROUNDS` says how many.
fn rounds() -> u32 {
    std::env::var("PFRONT_ROUNDS").map_or(1000, |rounds| rounds.parse().unwrap())
}

#[test]
fn closed_triangles_against_the_program() {
    for family in Family::ALL {
        let mut rng = seeded(1);
        for _ in 0..rounds() {
            let (a, b) = family.pair(&mut rng);
            assert_eq!(intersect(&a, &b), meet(&a, &b), "{family:?}: {a:?} {b:?}");
        }
    }
}

#[test]
fn triangles_of_one_mesh_against_the_program() {
    for family in Family::ALL {
        let mut rng = seeded(2);
        for _ in 0..rounds() / 2 {
            let (positions, ta, tb) = family.indexed(&mut rng);
            let expected = self_hit_by_program(ta, tb, &positions);
            let found = self_hit(ta, tb, &positions);
            assert_eq!(found, expected, "{family:?}: {ta:?} {tb:?} {positions:?}");
        }
    }
}

/// Families that never touch, or never miss, would test little.
#[test]
fn families_are_finite_and_mixed() {
    for family in Family::ALL {
        let mut rng = seeded(3);
        let pairs: Vec<_> = (0..1000).map(|_| family.pair(&mut rng)).collect();
        let finite = |t: &[Point; 3]| t.iter().flatten().all(|x| x.is_finite());
        assert!(pairs.iter().all(|(a, b)| finite(a) && finite(b)), "{family:?}");
        let hits = pairs.iter().filter(|(a, b)| intersect(a, b)).count();
        eprintln!("{family:?}: {:.1} % hit", hits as f64 / 10.0);
        let always = [Family::SharedVertex, Family::SharedEdge, Family::Duplicate];
        assert_eq!(hits == 1000, always.contains(&family), "{family:?}: {hits} hits");
        assert!(hits > 10 || family == Family::RawBits, "{family:?}: {hits} hits");
    }
}

type Integers = [BigInt; 3];

fn integers(p: &Point) -> Integers {
    p.map(|x| BigInt::from_f64(f64::from(x) * 2f64.powi(149)).unwrap())
}

fn meet(p: &[Point], q: &[Point]) -> bool {
    highest(p, q, &|_| BigInt::zero()).is_some()
}

fn self_hit_by_program(ta: [u32; 3], tb: [u32; 3], positions: &[Point]) -> bool {
    let at = |t: &[u32]| -> Vec<Point> { t.iter().map(|&v| positions[v as usize]).collect() };
    let only = |t: &[u32; 3], keep: &dyn Fn(&u32) -> bool| -> Vec<u32> {
        let mut kept: Vec<u32> = t.iter().copied().filter(keep).collect();
        kept.sort_unstable();
        kept.dedup();
        kept
    };
    let shared = only(&ta, &|v| tb.contains(v));
    let (rest_a, rest_b) = (only(&ta, &|v| !tb.contains(v)), only(&tb, &|v| !ta.contains(v)));
    if shared.len() == 3 || (rest_a.is_empty() && rest_b.is_empty()) {
        return true;
    }
    match shared.len() {
        0 => meet(&at(&ta), &at(&tb)),
        1 => meet(&at(&rest_a), &at(&tb)) || meet(&at(&rest_b), &at(&ta)),
        _ => leave(&at(&ta), &at(&tb), [0, 1].map(|i| integers(&positions[shared[i] as usize]))),
    }
}

/// Whether the common part of two hulls leaves the closed edge from `e` to `f`, that is: on some
/// side of the box of the edge, or of a plane through its line.
fn leave(p: &[Point], q: &[Point], [e, f]: [Integers; 2]) -> bool {
    let u: Integers = [0, 1, 2].map(|i| &f[i] - &e[i]);
    (0..3).any(|i| {
        let j = (i + 1) % 3;
        let turn = |x: &Integers| &u[i] * (&x[j] - &e[j]) - &u[j] * (&x[i] - &e[i]);
        let (low, high) = ((&e[i]).min(&f[i]), (&e[i]).max(&f[i]));
        let sides: [&dyn Fn(&Integers) -> BigInt; 4] =
            [&|x| &x[i] - high, &|x| low - &x[i], &turn, &|x| -turn(x)];
        sides.iter().any(|side| highest(p, q, side).unwrap())
    })
}

/// `None` if the hulls share no point, else whether the affine function `gain` is positive somewhere
/// in what they share.
fn highest(p: &[Point], q: &[Point], gain: &dyn Fn(&Integers) -> BigInt) -> Option<bool> {
    let [p, q]: [Vec<Integers>; 2] = [p, q].map(|set| set.iter().map(integers).collect());
    let row = |of_p: &dyn Fn(&Integers) -> BigInt, of_q: &dyn Fn(&Integers) -> BigInt, sum: i32| {
        let columns = p.iter().map(of_p).chain(q.iter().map(of_q));
        columns.chain([BigInt::from(sum)]).collect::<Vec<_>>()
    };
    let (one, none) = (|_: &Integers| BigInt::one(), |_: &Integers| BigInt::zero());
    let mut rows = vec![row(&one, &none, 1), row(&none, &one, 1)];
    for i in 0..3 {
        rows.push(row(&|x| x[i].clone(), &|x| -&x[i], 0));
    }
    // The sum of the rows is how far the weights are from a solution; the simplex method lowers it
    // to 0 if there is one. Then it raises the gain.
    let distance = (0..rows[0].len()).map(|j| rows.iter().map(|row| &row[j]).sum()).collect();
    let mut table = Table { basis: vec![None; 5], rows, denominator: BigInt::one() };
    table.rows.push(row(gain, &none, 0));
    table.rows.push(distance);
    table.maximise(6);
    if !table.rows.pop()?.last()?.is_zero() {
        return None;
    }
    table.leave_only_weights();
    let objective = table.rows.len() - 1;
    table.maximise(objective);
    Some(table.rows[objective].last()?.is_negative())
}

/// A simplex tableau over `denominator`: a row for each basic variable (`None` is an artificial one),
/// then objectives; the last column is the right side.
struct Table {
    rows: Vec<Vec<BigInt>>,
    basis: Vec<Option<usize>>,
    denominator: BigInt,
}

impl Table {
    fn maximise(&mut self, objective: usize) {
        let columns = self.rows[0].len() - 1;
        while let Some(c) = (0..columns).find(|&c| self.rows[objective][c].is_positive()) {
            let ratio = |i: &usize, j: &usize| {
                let [x, y] = [&self.rows[*i], &self.rows[*j]];
                let order = (&x[columns] * &y[c]).cmp(&(&y[columns] * &x[c]));
                order.then(self.basis[*i].cmp(&self.basis[*j]))
            };
            let rows = (0..self.basis.len()).filter(|&r| self.rows[r][c].is_positive());
            let row = rows.min_by(ratio).expect("weights are bounded");
            self.pivot(row, c);
        }
    }

    /// Replaces artificial variables, which are 0 by now, and drops rows that say nothing more.
    fn leave_only_weights(&mut self) {
        let columns = self.rows[0].len() - 1;
        while let Some(r) = self.basis.iter().position(Option::is_none) {
            match (0..columns).find(|&c| !self.rows[r][c].is_zero()) {
                Some(c) => {
                    if self.rows[r][c].is_negative() {
                        self.rows[r].iter_mut().for_each(|x| *x = -&*x);
                    }
                    self.pivot(r, c);
                }
                None => {
                    self.rows.remove(r);
                    self.basis.remove(r);
                }
            }
        }
    }

    /// Edmonds' integer pivoting: every division is exact.
    fn pivot(&mut self, r: usize, c: usize) {
        let row = self.rows[r].clone();
        for (i, other) in self.rows.iter_mut().enumerate().filter(|(i, _)| *i != r) {
            let factor = other[c].clone();
            for (x, y) in other.iter_mut().zip(&row) {
                *x = (&*x * &row[c] - &factor * y) / &self.denominator;
            }
            debug_assert!(i != r && other[c].is_zero());
        }
        self.denominator = row[c].clone();
        self.basis[r] = Some(c);
    }
}
