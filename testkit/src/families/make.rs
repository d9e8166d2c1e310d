//! How each family makes its pairs: f64 geometry, rounded to f32 at the end.

use super::Family;
use crate::rng::finite;
use crate::{Point, Triangle};
use rand::{Rng, RngExt};

type Point64 = [f64; 3];

pub(super) fn pair(family: Family, rng: &mut impl Rng) -> [Triangle; 2] {
    match family {
        Family::Random => [triangle(rng, 1.0), triangle(rng, 1.0)].map(rounded),
        Family::MeshLike => {
            let at = point(rng, 1.0);
            [0.01, 0.01].map(|edge| rounded(triangle(rng, edge).map(|p| add(p, at))))
        }
        Family::VertexFaceGap3 => vertex_face(rng, 1e-3),
        Family::VertexFaceGap5 => vertex_face(rng, 1e-5),
        Family::VertexFaceGap7 => vertex_face(rng, 1e-7),
        Family::VertexFaceGap8 => vertex_face(rng, 1e-8),
        Family::VertexFaceGap9 => vertex_face(rng, 1e-9),
        Family::EdgeEdgeGap => {
            let gap = [0.0, 1e-8, 1e-7, 1e-6][rng.random_range(0..4usize)];
            edge_edge(rng, gap)
        }
        Family::EdgeEdgeGap3 => edge_edge(rng, 1e-3),
        Family::EdgeEdgeGap5 => edge_edge(rng, 1e-5),
        Family::EdgeEdgeGap7 => edge_edge(rng, 1e-7),
        Family::EdgeEdgeGap8 => edge_edge(rng, 1e-8),
        Family::EdgeEdgeGap9 => edge_edge(rng, 1e-9),
        Family::CoplanarAxis => {
            let (axis, height) = (rng.random_range(0..3usize), rng.random_range(-1.0..1.0));
            [0, 1].map(|_| {
                rounded(triangle(rng, 1.0).map(|mut p| {
                    p[axis] = height;
                    p
                }))
            })
        }
        Family::CoplanarRotated => {
            let [o, u, v] = triangle(rng, 1.0);
            [0, 1].map(|_| rounded(triangle(rng, 1.0).map(|[x, y, _]| combine(o, x, u, y, v))))
        }
        Family::SharedVertex => {
            let [a, mut b] = pair(Family::Random, rng);
            b[0] = a[0];
            [a, b]
        }
        Family::SharedEdge => {
            let family = if rng.random() { Family::CoplanarRotated } else { Family::Random };
            let [a, mut b] = pair(family, rng);
            [b[0], b[1]] = [a[1], a[0]];
            [a, b]
        }
        Family::TJunction => {
            let [a, mut b] = [triangle(rng, 1.0), triangle(rng, 1.0)];
            b[0] = on_segment(a[0], a[1], rng.random());
            [a, b].map(rounded)
        }
        Family::EdgeThroughVertex => {
            let [a, mut b] = [triangle(rng, 1.0), triangle(rng, 1.0)];
            b[1] = on_segment(b[0], a[0], rng.random_range(1.0..2.0));
            [a, b].map(rounded)
        }
        Family::Sliver => {
            let narrow = |rng: &mut _| {
                let [p, q, off] = triangle(rng, 1.0);
                let r = on_segment(p, q, RngExt::random_range(rng, -0.2..1.2));
                rounded([p, q, add(r, off.map(|x| 1e-6 * x))])
            };
            let [a, b] = [narrow(rng), narrow(rng)];
            let other = match rng.random_range(0..3) {
                0 => triangle(rng, 1.0).map(round),
                1 => b,
                // Two slivers along nearly the same line.
                _ => [a[1], a[0], b[2]],
            };
            [a, other]
        }
        Family::Degenerate => degenerate(rng),
        Family::Offset => {
            let (pair, at) = (moderate(rng), point(rng, 1e7));
            let size = [1.0, 10.0, 1000.0][rng.random_range(0..3usize)];
            each(pair, |p| add(p.map(|x| x * size), at))
        }
        Family::Scaled => {
            let size = ten_to(rng.random_range(-20..=20));
            each(moderate(rng), |p| p.map(|x| x * size))
        }
        Family::MixedScale => {
            let [a, b] = moderate(rng);
            let mut size = || [0; 3].map(|_| ten_to(rng.random_range(-20..=20)));
            let (by_axis, [for_b, _, _]) = (size(), size());
            if rng.random() {
                each([a, b], |p| [0, 1, 2].map(|i| p[i] * by_axis[i]))
            } else {
                let [b, _] = each([b, b], |p| p.map(|x| x * for_b));
                [a, b]
            }
        }
        Family::Huge => {
            let size = f64::from(f32::MAX) * rng.random_range(0.3..0.33);
            each(moderate(rng), |p| p.map(|x| x.clamp(-3.0, 3.0) * size))
        }
        Family::Subnormal => {
            let steps = [3.0, 20.0, 1e4][rng.random_range(0..3usize)];
            each(moderate(rng), |p| p.map(|x| x * steps * f64::from(f32::from_bits(1))))
        }
        Family::Lattice => {
            let size = rng.random_range(1..=3);
            [[[0; 3]; 3]; 2]
                .map(|t| t.map(|p: [i32; 3]| p.map(|_| rng.random_range(-size..=size) as f32)))
        }
        Family::Duplicate => {
            let [a, _] = moderate(rng);
            let mut b = a;
            if rng.random() {
                let x = &mut b[rng.random_range(0..3usize)][rng.random_range(0..3usize)];
                *x = if rng.random() { x.next_up() } else { x.next_down() };
            }
            [a, b]
        }
        Family::RawBits => [[[0; 3]; 3]; 2].map(|t| t.map(|p: [i32; 3]| p.map(|_| finite(rng)))),
    }
}

fn moderate(rng: &mut impl Rng) -> [Triangle; 2] {
    let family = Family::MODERATE[rng.random_range(0..Family::MODERATE.len())];
    pair(family, rng)
}

/// A corner of b at ±`gap` along the normal from inside a, b's other corners anywhere beyond.
fn vertex_face(rng: &mut impl Rng, gap: f64) -> [Triangle; 2] {
    let [p, q, r] = triangle(rng, 1.0);
    let (u, v) = (sub(q, p), sub(r, p));
    let up = unit(cross(u, v));
    let (s, t) = (rng.random_range(0.1..0.5), rng.random_range(0.1..0.5));
    let foot = combine(p, s, u, t, v);
    let mut above = |height: f64| {
        let side = combine(foot, rng.random_range(-0.5..0.5), u, rng.random_range(-0.5..0.5), v);
        combine(side, height, up, 0.0, up)
    };
    let far = [above(0.5), above(0.7)];
    let sign = if rng.random() { gap } else { -gap };
    [[p, q, r], [combine(foot, sign, up, 0.0, up), far[0], far[1]]].map(rounded)
}

/// Two edges that cross when seen from above, at heights ±`gap` apart.
fn edge_edge(rng: &mut impl Rng, gap: f64) -> [Triangle; 2] {
    let [at, u, v] = triangle(rng, 1.0);
    let up = unit(cross(u, v));
    let gap = if rng.random() { gap } else { -gap };
    let mut edge = |along: Point64, height: f64, apex: f64| {
        let end = |t: f64| combine(at, t, along, height, up);
        let [s, t] = [-rng.random_range(0.1..1.0), rng.random_range(0.1..1.0)];
        [end(s), end(t), combine(at, rng.random_range(-0.3..0.3), along, apex, up)]
    };
    [edge(u, 0.0, -0.2), edge(v, gap, 0.2)].map(rounded)
}

/// A segment or point against a triangle, segment or point, mostly touching.
fn degenerate(rng: &mut impl Rng) -> [Triangle; 2] {
    let [a, b] = [triangle(rng, 1.0), triangle(rng, 1.0)].map(rounded);
    let [mut a, mut b] = if rng.random() { pair(Family::Lattice, rng) } else { [a, b] };
    collapse(&mut b, rng);
    if rng.random() {
        collapse(&mut a, rng);
    }
    match rng.random_range(0..4) {
        0 => {}
        1 => {
            // b starts at a corner of a.
            let corner = a[rng.random_range(0..3usize)];
            let old = b[0];
            b = b.map(|p| if p == old { corner } else { p });
        }
        2 => {
            // b goes along an edge of a.
            let [p, q, _] = a.map(widened);
            b = b.map(|_| round(on_segment(p, q, f64::from(rng.random_range(-4..=12)) / 8.0)));
        }
        _ => {
            // b goes through a.
            let [p, q, r] = a.map(widened);
            let (s, t) = (rng.random_range(0.0..0.6), rng.random_range(0.0..0.6));
            let middle = combine(p, s, sub(q, p), t, sub(r, p));
            let end = widened(b[0]);
            let ends = [end, on_segment(end, middle, rng.random_range(1.0..2.0)), middle];
            b = ends.map(round);
        }
    }
    [a, b]
}

/// Makes a triangle a segment or a point.
fn collapse(t: &mut Triangle, rng: &mut impl Rng) {
    match rng.random_range(0..3) {
        0 => *t = [t[0]; 3],
        1 => t[1] = t[0],
        _ => t[1] = round(on_segment(widened(t[0]), widened(t[2]), 0.5)),
    }
}

fn triangle(rng: &mut impl Rng, size: f64) -> [Point64; 3] {
    [size; 3].map(|size| point(rng, size))
}

fn point(rng: &mut impl Rng, size: f64) -> Point64 {
    [size; 3].map(|size| rng.random::<f64>() * size)
}

fn each(pair: [Triangle; 2], change: impl Fn(Point64) -> Point64) -> [Triangle; 2] {
    pair.map(|t| t.map(|p| round(change(widened(p)))))
}

fn widened(p: Point) -> Point64 {
    p.map(f64::from)
}

fn round(p: Point64) -> Point {
    p.map(|x| x as f32)
}

fn rounded(t: [Point64; 3]) -> Triangle {
    t.map(round)
}

fn add(p: Point64, q: Point64) -> Point64 {
    [0, 1, 2].map(|i| p[i] + q[i])
}

fn sub(p: Point64, q: Point64) -> Point64 {
    [0, 1, 2].map(|i| p[i] - q[i])
}

fn cross(u: Point64, v: Point64) -> Point64 {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| u[i] * v[j] - u[j] * v[i])
}

/// A vector of length 1 in the same direction, unless it is next to nothing.
fn unit(v: Point64) -> Point64 {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
    v.map(|x| x / length)
}

/// 10^`exponent` for exponents of −22 to 22, correctly rounded and so the same on every machine, which
/// `powi` does not promise: 10^22 is the last power of ten that f64 holds.
fn ten_to(exponent: i32) -> f64 {
    let power = (0..exponent.abs()).fold(1.0, |power, _| power * 10.0);
    if exponent < 0 { 1.0 / power } else { power }
}

/// o + x·u + y·v.
fn combine(o: Point64, x: f64, u: Point64, y: f64, v: Point64) -> Point64 {
    [0, 1, 2].map(|i| o[i] + x * u[i] + y * v[i])
}

fn on_segment(p: Point64, q: Point64, t: f64) -> Point64 {
    combine(p, t, sub(q, p), 0.0, p)
}
