//! Triangles in one plane, and triangles without area.
//!
//! Convex sets in a plane are apart exactly if a line along an edge of one of them separates them,
//! which takes only the signs of turns. A segment is a polygon of two edges, there and back.

use crate::Triangle;
use crate::exact::{Axes, Kernel, PROJECTIONS, Point, difference};
use core::cmp::Ordering;

/// Whether two triangles meet that lie in one plane or of which at least one has no area.
#[cold]
pub(super) fn meet<K: Kernel>(a: &Triangle, b: &Triangle) -> Result<bool, K::Undecided> {
    match (proper::<K>(a)?, proper::<K>(b)?) {
        // With area, one is here because it lies in the plane of the other.
        (Some(p), Some(q)) => polygons_meet::<K>(p.axes, &p.corners, &q.turned(p.axes, b)?),
        (Some(p), None) => segment_meets_proper::<K>(extremes(b), a, &p),
        (None, Some(q)) => segment_meets_proper::<K>(extremes(a), b, &q),
        (None, None) => segments_meet::<K>(extremes(a), extremes(b)),
    }
}

/// Whether the closed segment `s` meets the closed triangle `t`; either may be degenerate.
pub(super) fn segment_meets<K: Kernel>(s: [Point; 2], t: &Triangle) -> Result<bool, K::Undecided> {
    let [p, q] = s;
    match K::sides(t, [&p, &q])? {
        [x, y] if x * y > 0 => Ok(false),
        [0, 0] => meet::<K>(&[p, q, q], t),
        _ => pierces::<K>(s, t),
    }
}

/// A triangle with area in a projection that keeps it so, its corners counter-clockwise there.
pub(super) struct Proper<K> {
    pub(super) axes: Axes,
    pub(super) corners: Triangle,
    kernel: core::marker::PhantomData<K>,
}

/// `None` if the triangle has no area.
pub(super) fn proper<K: Kernel>(t: &Triangle) -> Result<Option<Proper<K>>, K::Undecided> {
    let (u, v) = (difference(&t[1], &t[0]), difference(&t[2], &t[0]));
    let area = u.cross(v).abs().to_array();
    // The largest projection first: for a triangle with area it nearly always decides.
    let largest = if area[0] >= area[1] && area[0] >= area[2] {
        0
    } else if area[1] >= area[2] {
        1
    } else {
        2
    };
    for k in 0..3 {
        let axes = PROJECTIONS[(largest + k) % 3];
        match K::orient2d(axes, &t[0], &t[1], &t[2])? {
            0 => {}
            turn => {
                return Ok(Some(Proper {
                    axes,
                    corners: counter_clockwise(t, turn),
                    kernel: core::marker::PhantomData,
                }));
            }
        }
    }
    Ok(None)
}

impl<K: Kernel> Proper<K> {
    /// The corners counter-clockwise in another projection, in which the triangle has area too
    /// because it shares its plane with one that has.
    fn turned(&self, axes: Axes, t: &Triangle) -> Result<Triangle, K::Undecided> {
        if axes == self.axes {
            return Ok(self.corners);
        }
        Ok(counter_clockwise(t, K::orient2d(axes, &t[0], &t[1], &t[2])?))
    }
}

fn counter_clockwise(t: &Triangle, turn: i32) -> Triangle {
    if turn < 0 { [t[0], t[2], t[1]] } else { *t }
}

/// The ends of a triangle without area. Lexicographic order is monotone along a line.
pub(super) fn extremes(t: &Triangle) -> [Point; 2] {
    let [mut low, mut high] = [t[0], t[0]];
    for p in &t[1..] {
        if order(p, &low) == Ordering::Less {
            low = *p;
        }
        if order(p, &high) == Ordering::Greater {
            high = *p;
        }
    }
    [low, high]
}

/// Lexicographic order of points with finite coordinates.
pub(super) fn order(p: &Point, q: &Point) -> Ordering {
    p.partial_cmp(q).unwrap_or(Ordering::Equal)
}

fn segment_meets_proper<K: Kernel>(
    s: [Point; 2],
    t: &Triangle,
    proper: &Proper<K>,
) -> Result<bool, K::Undecided> {
    match K::sides(t, [&s[0], &s[1]])? {
        [x, y] if x * y > 0 => Ok(false),
        [0, 0] => polygons_meet::<K>(proper.axes, &s, &proper.corners),
        _ => pierces::<K>(s, t),
    }
}

/// Whether a segment that reaches the plane of `t` in one point does so within `t`: its line passes
/// all three edges on the same side, or through one.
fn pierces<K: Kernel>([p, q]: [Point; 2], t: &Triangle) -> Result<bool, K::Undecided> {
    let (mut left, mut right) = (false, false);
    let [a, b, c] = t;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let side = K::orient3d(&p, &q, from, to)?;
        left |= side < 0;
        right |= side > 0;
        if left && right {
            return Ok(false);
        }
    }
    Ok(true)
}

fn segments_meet<K: Kernel>(s: [Point; 2], r: [Point; 2]) -> Result<bool, K::Undecided> {
    if K::orient3d(&s[0], &s[1], &r[0], &r[1])? != 0 {
        return Ok(false);
    }
    // A projection in which three of the four coplanar points still make a triangle loses nothing.
    for axes in PROJECTIONS {
        for (edge, p) in [(&s, &r[0]), (&s, &r[1]), (&r, &s[0]), (&r, &s[1])] {
            if K::orient2d(axes, &edge[0], &edge[1], p)? != 0 {
                return polygons_meet::<K>(axes, &s, &r);
            }
        }
    }
    // All four on one line, sorted along it.
    Ok(order(&s[0], &r[1]).is_le() && order(&r[0], &s[1]).is_le())
}

/// Whether two polygons in one plane meet, which are not both on one line.
fn polygons_meet<K: Kernel>(axes: Axes, p: &[Point], q: &[Point]) -> Result<bool, K::Undecided> {
    Ok(!separates::<K>(axes, p, q)? && !separates::<K>(axes, q, p)?)
}

/// Whether the line of some edge of `p` has all of `q` strictly on its outer side.
fn separates<K: Kernel>(axes: Axes, p: &[Point], q: &[Point]) -> Result<bool, K::Undecided> {
    for i in 0..p.len() {
        let (from, to) = (&p[i], &p[(i + 1) % p.len()]);
        let mut outside = true;
        for point in q {
            if K::orient2d(axes, from, to, point)? >= 0 {
                outside = false;
                break;
            }
        }
        if outside {
            return Ok(true);
        }
    }
    Ok(false)
}
