//! The volume that two closed meshes have in common, in rationals.

use crate::MeshData;
use num_bigint::BigInt;
use num_rational::Ratio;
use num_traits::{Float, Signed, ToPrimitive, Zero};

type Rational = Ratio<BigInt>;

type Point2 = [Rational; 2];

/// The space below a triangle: its shadow on the plane of the first two axes, counter-clockwise, and its height over that,
/// `[x, y, 1]` times these.
struct Prism {
    shadow: Vec<Point2>,
    height: [Rational; 3],
    /// 1 if the triangle faces up, or −1.
    turn: i32,
    low: [f32; 2],
    high: [f32; 2],
}

fn exact(x: f32) -> Rational {
    let (mantissa, exponent, sign) = x.integer_decode();
    let whole = Ratio::from(BigInt::from(mantissa) * BigInt::from(sign));
    let scale = Ratio::from(BigInt::from(1) << exponent.unsigned_abs());
    if exponent < 0 { whole / scale } else { whole * scale }
}

fn cross([a, b]: [&Rational; 2], [c, d]: [&Rational; 2]) -> Rational {
    a * d - b * c
}

fn at(linear: &[Rational; 3], [x, y]: &Point2) -> Rational {
    &linear[0] * x + &linear[1] * y + &linear[2]
}

impl Prism {
    fn of(corners: [[f32; 3]; 3]) -> Option<Self> {
        let [p, q, r] = corners.map(|p| p.map(exact));
        let u = [0, 1, 2].map(|k| &q[k] - &p[k]);
        let v = [0, 1, 2].map(|k| &r[k] - &p[k]);
        let area = cross([&u[0], &u[1]], [&v[0], &v[1]]);
        if area.is_zero() {
            return None;
        }
        let x = -cross([&u[1], &u[2]], [&v[1], &v[2]]) / &area;
        let y = -cross([&u[2], &u[0]], [&v[2], &v[0]]) / &area;
        let constant = &p[2] - &x * &p[0] - &y * &p[1];
        let mut shadow: Vec<_> = [p, q, r].map(|[x, y, _]| [x, y]).into();
        let turn = if area.is_positive() { 1 } else { -1 };
        if turn < 0 {
            shadow.reverse();
        }
        let extreme = |of: fn(f32, f32) -> f32| {
            [0, 1].map(|k| corners.iter().map(|p| p[k]).reduce(of).unwrap_or(0.0))
        };
        let (low, high) = (extreme(f32::min), extreme(f32::max));
        Some(Self { shadow, height: [x, y, constant], turn, low, high })
    }

    /// The integral of the lower of two heights over the common part of two shadows.
    fn common(&self, other: &Self) -> Rational {
        let mut both = self.shadow.clone();
        for (k, p) in other.shadow.iter().enumerate() {
            let q = &other.shadow[(k + 1) % 3];
            let [x, y] = [&q[0] - &p[0], &q[1] - &p[1]];
            let constant = &y * &p[0] - &x * &p[1];
            both = clipped(&both, &[-y, x, constant]);
        }
        let above = [0, 1, 2].map(|k| &self.height[k] - &other.height[k]);
        let below = above.clone().map(|x| -x);
        integral(&clipped(&both, &below), &self.height)
            + integral(&clipped(&both, &above), &other.height)
    }
}

/// The part of a convex polygon in which a linear function is not negative.
fn clipped(polygon: &[Point2], linear: &[Rational; 3]) -> Vec<Point2> {
    let values: Vec<_> = polygon.iter().map(|p| at(linear, p)).collect();
    let mut rest = Vec::new();
    for (k, p) in polygon.iter().enumerate() {
        let next = (k + 1) % polygon.len();
        if !values[k].is_negative() {
            rest.push(p.clone());
        }
        if (&values[k] * &values[next]).is_negative() {
            let t = &values[k] / (&values[k] - &values[next]);
            rest.push([0, 1].map(|axis| &p[axis] + &t * (&polygon[next][axis] - &p[axis])));
        }
    }
    rest
}

/// The integral of a linear function over a convex polygon: over triangles, the area of each times the mean at its corners.
fn integral(polygon: &[Point2], linear: &[Rational; 3]) -> Rational {
    let mut sum = Rational::zero();
    for k in 2..polygon.len() {
        let [p, q, r] = [&polygon[0], &polygon[k - 1], &polygon[k]];
        let [u, v] = [q, r].map(|end| [&end[0] - &p[0], &end[1] - &p[1]]);
        let twice = cross(u.each_ref(), v.each_ref());
        sum += twice * [p, q, r].map(|p| at(linear, p)).into_iter().sum::<Rational>();
    }
    sum / Rational::from(BigInt::from(6))
}

/// The volume that two closed meshes have in common, each point as often as the product of its winding numbers: exactly, and then
/// rounded to a multiple of 2^-200 and to an f64.
///
/// A point is below as many more triangles of a closed mesh that face up than of those that face down as its winding number says.
/// So the volume is the sum over all two triangles of one mesh each, facing alike or not, of what is below both.
///
/// # Panics
/// If a triangle names a vertex that does not exist, or a coordinate is not finite.
pub fn overlap_volume(a: &MeshData, b: &MeshData) -> f64 {
    let [a, b] = [a, b].map(|mesh| {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
        mesh.triangles.iter().filter_map(|t| Prism::of(corners(t))).collect::<Vec<_>>()
    });
    let mut sum = Rational::zero();
    for f in &a {
        for g in &b {
            if (0..2).all(|k| f.low[k] < g.high[k] && g.low[k] < f.high[k]) {
                sum += f.common(g) * Rational::from(BigInt::from(f.turn * g.turn));
            }
        }
    }
    let scaled = (sum * Rational::from(BigInt::from(1) << 200_u32)).to_integer();
    scaled.to_f64().unwrap_or(f64::NAN) * 2f64.powi(-200)
}
