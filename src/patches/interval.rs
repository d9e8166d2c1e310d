//! Intervals that hold a number: each operation is rounded outward.

use pfront_core::Pose64;

/// All numbers from the first to the second.
pub(super) type Interval = [f64; 2];

fn outward([low, high]: Interval) -> Interval {
    [low.next_down(), high.next_up()]
}

pub(super) fn plus(x: Interval, y: Interval) -> Interval {
    outward([x[0] + y[0], x[1] + y[1]])
}

fn minus(x: Interval, y: Interval) -> Interval {
    outward([x[0] - y[1], x[1] - y[0]])
}

pub(super) fn times(x: Interval, y: Interval) -> Interval {
    let products = [x[0] * y[0], x[0] * y[1], x[1] * y[0], x[1] * y[1]];
    let [first, ..] = products;
    outward(products.iter().fold([first; 2], |[low, high], &z| [low.min(z), high.max(z)]))
}

/// q − p.
pub(super) fn towards(p: &[Interval; 3], q: &[Interval; 3]) -> [Interval; 3] {
    [0, 1, 2].map(|k| minus(q[k], p[k]))
}

/// u × v.
pub(super) fn cross(u: &[Interval; 3], v: &[Interval; 3]) -> [Interval; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| minus(times(u[i], v[j]), times(u[j], v[i])))
}

pub(super) fn length(v: &[Interval; 3]) -> Interval {
    let squares = v.map(|[low, high]| {
        let nearest = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
        let farthest = low.abs().max(high.abs());
        outward([nearest * nearest, farthest * farthest])
    });
    let [low, high] = plus(plus(squares[0], squares[1]), squares[2]);
    let [low, high] = outward([low.max(0.0).sqrt(), high.sqrt()]);
    [low.max(0.0), high]
}

/// A point in a pose.
pub(super) fn posed(pose: &Pose64, p: &[Interval; 3]) -> [Interval; 3] {
    if *pose == Pose64::IDENTITY {
        return *p;
    }
    pose.rows.map(|[x, y, z, t]| {
        let of = |factor: f64, k: usize| times([factor; 2], p[k]);
        plus(plus(plus(of(x, 0), of(y, 1)), of(z, 2)), [t; 2])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_hold_what_is_true_and_little_else() {
        let third = [(1.0 / 3.0_f64).next_down(), (1.0 / 3.0_f64).next_up()];
        let whole = plus(plus(third, third), third);
        assert!(whole[0] <= 1.0 && 1.0 <= whole[1] && whole[1] - whole[0] < 1e-15);
        assert!(times([-2.0, 1.0], [-3.0, 4.0])[0] <= -8.0);
        assert!(times([-2.0, 1.0], [-3.0, 4.0])[1] >= 6.0);
        let [low, high] = length(&[[3.0; 2], [-4.0; 2], [-1.0, 1.0]]);
        assert!(low <= 5.0 && high >= 26_f64.sqrt() && low > 4.999 && high < 5.1);
        let turned =
            Pose64::new([[0.0, -1.0, 0.0, 5.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
        let [x, y, z] = posed(&turned, &[[1.0; 2], [2.0; 2], [0.5; 2]]);
        let holds = |[low, high]: Interval, x: f64| low <= x && x <= high && high - low < 1e-14;
        assert!(holds(x, 3.0) && holds(y, 1.0) && holds(z, 0.5));
    }
}
