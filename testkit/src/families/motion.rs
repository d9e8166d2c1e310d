//! Pairs of moving triangles that are hard to decide.

use crate::oracle::MovingTriangle;
use crate::rng::{Rng, RngExt};

type Point = [f64; 3];

/// One way of making moving triangle pairs hard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionFamily {
    /// Coordinates in −2..=2 at both ends: every degenerate combination comes up.
    Lattice2,
    /// The same in −9..=9.
    Lattice9,
    /// The same, with triangles that are segments or points at one or both ends.
    Degenerate,
    /// Corners uniform in the unit cube at both ends.
    Random,
    /// Small triangles that fly past or through larger ones, mostly between the ends.
    Passing,
    /// A corner or an edge that passes the other triangle at 0 or ±1e-7.
    Grazing,
    /// Both turn together by up to a third of a circle, with a gap of 1e-6.
    Turning,
    /// All corners in one plane for ever.
    Flat,
    /// Right triangles of integers in axis-parallel planes, which land flush or beside each other.
    Landing,
    /// A pair of another family, all coordinates near 1e4.
    Offset,
    /// A pair of another family, in f32.
    Rounded,
    /// A pair of another family, scaled by 1e-38 to 1e37.
    Scaled,
    /// A pair of another family that does not move, or moves as a whole.
    Still,
}

impl MotionFamily {
    /// Every family.
    pub const ALL: [Self; 13] = [
        Self::Lattice2,
        Self::Lattice9,
        Self::Degenerate,
        Self::Random,
        Self::Passing,
        Self::Grazing,
        Self::Turning,
        Self::Flat,
        Self::Landing,
        Self::Offset,
        Self::Rounded,
        Self::Scaled,
        Self::Still,
    ];

    /// Two triangles at the start and at the end.
    pub fn pair(self, rng: &mut impl Rng) -> [MovingTriangle; 2] {
        match self {
            Self::Offset => {
                let at = point(rng, 1e4);
                changed(any(rng), |p| add(p, at))
            }
            Self::Rounded => changed(any(rng), |p| p.map(|x| f64::from(x as f32))),
            Self::Scaled => {
                let size = 10_f64.powi(rng.random_range(-38..37));
                changed(any(rng), |p| p.map(|x| x * size))
            }
            Self::Still => {
                let moved = if rng.random() { [0.0; 3] } else { [1.0, -2.0, 0.5] };
                any(rng).map(|[start, _]| [start, start.map(|p| add(p, moved))])
            }
            basic => basic.basic(rng),
        }
    }

    /// A pair of a family that none other is made of.
    fn basic(self, rng: &mut impl Rng) -> [MovingTriangle; 2] {
        match self {
            Self::Lattice2 => lattice(rng, 2),
            Self::Lattice9 => lattice(rng, 9),
            Self::Degenerate => degenerate(rng),
            Self::Random => each(|| point(rng, 1.0)),
            Self::Passing => passing(rng),
            Self::Grazing => grazing(rng),
            Self::Turning => turning(rng),
            Self::Flat => flat(rng),
            _ => landing(rng),
        }
    }
}

/// A pair of one of the families before [`MotionFamily::Offset`], whose coordinates are of moderate size.
fn any(rng: &mut impl Rng) -> [MovingTriangle; 2] {
    MotionFamily::ALL[rng.random_range(0..9)].basic(rng)
}

fn lattice(rng: &mut impl Rng, size: i32) -> [MovingTriangle; 2] {
    each(|| [0; 3].map(|_| f64::from(rng.random_range(-size..=size))))
}

fn degenerate(rng: &mut impl Rng) -> [MovingTriangle; 2] {
    let mut pair = lattice(rng, 9);
    for t in &mut pair {
        for _ in 0..rng.random_range(0..3) {
            let (from, to) = (rng.random_range(0..3), rng.random_range(0..3));
            let ends = [[0, 1], [0, 0], [1, 1]][rng.random_range(0..3)];
            ends.into_iter().for_each(|end: usize| t[end][to] = t[end][from]);
        }
    }
    pair
}

fn passing(rng: &mut impl Rng) -> [MovingTriangle; 2] {
    let [a, mut b] = each(|| point(rng, 1.0));
    let (size, turned) = ([0.3, 0.03, 1e-3][rng.random_range(0..3)], point(rng, 0.1));
    for (end, from) in b.iter_mut().zip([2.0, -2.0]) {
        let at = add(point(rng, 0.3), [0.0, 0.0, from]);
        *end = end.map(|p| add(scaled(p, size), at));
    }
    let a = a.map(|end| end.map(|[x, y, z]| add([2.0 * x, 2.0 * y, 0.2 * z], turned)));
    [a, b]
}

/// Two triangles that touch at a time, and are moved apart by a gap along the normal of the features that touch.
fn grazing(rng: &mut impl Rng) -> [MovingTriangle; 2] {
    let [mut a, mut b] = each(|| point(rng, 1.0));
    let time = [0.0, 0.5, rng.random(), 1.0][rng.random_range(0..4)];
    let gap = [0.0, 1e-7, -1e-7, 1e-12, -1e-12][rng.random_range(0..5)];
    let at = |t: &MovingTriangle, k: usize| blend(t[0][k], t[1][k], time);
    let [s, t] = [rng.random_range(0.0..0.5), rng.random_range(0.0..0.5)];
    let [p, q, r] = [0, 1, 2].map(|k| at(&a, k));
    let (touched, mut normal) = if rng.random() {
        (
            add(p, add(scaled(minus(q, p), s), scaled(minus(r, p), t))),
            cross(minus(q, p), minus(r, p)),
        )
    } else {
        (blend(p, q, s), cross(minus(q, p), minus(at(&b, 0), at(&b, 1))))
    };
    normal = scaled(normal, gap / dot(normal, normal).sqrt().max(1e-3));
    let from = if rng.random() { at(&b, 0) } else { blend(at(&b, 0), at(&b, 1), t) };
    let shift = add(minus(touched, from), normal);
    b = b.map(|end| end.map(|p| add(p, shift)));
    if rng.random() {
        // Rounded to a coarse lattice, so that what touches may do so exactly.
        let coarse = |p: Point| p.map(|x| (x * 1024.0).round() / 1024.0);
        (a, b) = (a.map(|end| end.map(coarse)), b.map(|end| end.map(coarse)));
    }
    [a, b]
}

fn turning(rng: &mut impl Rng) -> [MovingTriangle; 2] {
    let [a, mut b] = [0; 2].map(|_| [0; 3].map(|_| point(rng, 1.0)));
    let normal = cross(minus(a[1], a[0]), minus(a[2], a[0]));
    let unit = scaled(normal, 1.0 / dot(normal, normal).sqrt().max(1e-3));
    let height = |p: Point| dot(minus(p, a[0]), unit);
    let least = b.map(height).into_iter().fold(f64::INFINITY, f64::min);
    b = b.map(|p| add(p, scaled(unit, 1e-6 - least)));
    let (sin, cos) = rng.random_range(-2.0..2.0_f64).sin_cos();
    let moved = point(rng, 1.0);
    let turn = |[x, y, z]: Point| add([cos * x - sin * y, sin * x + cos * y, z], moved);
    [[a, a.map(turn)], [b, b.map(turn)]]
}

fn flat(rng: &mut impl Rng) -> [MovingTriangle; 2] {
    let (axis, height) = (rng.random_range(0..3_usize), f64::from(rng.random_range(-2..3)));
    let is_lattice = rng.random();
    each(|| {
        let mut p = if is_lattice {
            [0; 3].map(|_| f64::from(rng.random_range(-5..=5)))
        } else {
            point(rng, 1.0)
        };
        p[axis] = height;
        p
    })
}

fn landing(rng: &mut impl Rng) -> [MovingTriangle; 2] {
    let (axis, across) = (rng.random_range(0..3_usize), rng.random_range(0..3) == 0);
    let whole =
        |rng: &mut _, size: i32| [0; 3].map(|_| f64::from(RngExt::random_range(rng, -size..=size)));
    let mut flat = |axis: usize| {
        let corner = whole(rng, 3);
        [1, 2, 0].map(|k| {
            let mut p = corner;
            p[(axis + 1 + k % 2) % 3] += [0.0, 2.0, 3.0][k];
            p
        })
    };
    let (a, b) = (flat(axis), flat(if across { (axis + 1) % 3 } else { axis }));
    let (by_a, by_b) = (whole(rng, 4), whole(rng, 4));
    let rest = rng.random();
    let end = |t: [Point; 3], by| t.map(|p| add(p, by));
    [[a, if rest { a } else { end(a, by_a) }], [b, end(b, by_b)]]
}

fn each(mut point: impl FnMut() -> Point) -> [MovingTriangle; 2] {
    [[[(); 3]; 2]; 2].map(|t| t.map(|end| end.map(|()| point())))
}

fn changed(
    pair: [MovingTriangle; 2],
    mut change: impl FnMut(Point) -> Point,
) -> [MovingTriangle; 2] {
    pair.map(|t| t.map(|end| end.map(&mut change)))
}

fn point(rng: &mut impl Rng, size: f64) -> Point {
    [0; 3].map(|_| rng.random_range(-size..size))
}

fn add(p: Point, q: Point) -> Point {
    [0, 1, 2].map(|k| p[k] + q[k])
}

fn minus(p: Point, q: Point) -> Point {
    [0, 1, 2].map(|k| p[k] - q[k])
}

fn scaled(p: Point, by: f64) -> Point {
    p.map(|x| x * by)
}

fn blend(p: Point, q: Point, t: f64) -> Point {
    add(scaled(p, 1.0 - t), scaled(q, t))
}

fn dot(p: Point, q: Point) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

fn cross(p: Point, q: Point) -> Point {
    [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        p[i] * q[j] - p[j] * q[i]
    })
}
