//! Where a segment first meets a triangle, by inequalities in its parameter, as fractions.

type Vector = [i128; 3];

fn minus(p: Vector, q: Vector) -> Vector {
    [0, 1, 2].map(|k| p[k] - q[k])
}

fn dot(p: Vector, q: Vector) -> i128 {
    (0..3).map(|k| p[k] * q[k]).sum()
}

fn cross(p: Vector, q: Vector) -> Vector {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

/// The smallest t from 0 to 1 at which p + t (q − p) is in a closed triangle, as a fraction whose denominator is positive; one without
/// area is its segment or point. Coordinates are integers below 2^15.
///
/// Being in it is linear in t: the point is in the plane, and on the inner side of each edge; or on the line, and between the ends.
pub fn first_parameter([p, q]: [[i64; 3]; 2], triangle: &[[i64; 3]; 3]) -> Option<(i128, i128)> {
    let [p, q] = [p, q].map(|point| point.map(i128::from));
    let t = triangle.map(|corner| corner.map(i128::from));
    let normal = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    let (mut low, mut high) = ((0, 1), (1, 1));
    // Leaves t with (x − at) · along ≥ 0. Returns whether there is one.
    let mut is_along = |at: Vector, along: Vector| {
        let (value, slope) = (dot(minus(p, at), along), dot(minus(q, p), along));
        match slope.signum() {
            0 => return value >= 0,
            1 if -value * low.1 > low.0 * slope => low = (-value, slope),
            -1 if value * high.1 < high.0 * -slope => high = (value, -slope),
            _ => {}
        }
        low.0 * high.1 <= high.0 * low.1
    };
    let mut is_met = true;
    if normal == [0; 3] {
        let (mut ends, mut line) = ([t[0]; 2], [0; 3]);
        for corner in t {
            ends = [ends[0].min(corner), ends[1].max(corner)];
            line = minus(ends[1], ends[0]);
        }
        for k in 0..3 {
            let axis = [0, 1, 2].map(|i| i128::from(i == k));
            let across = if line == [0; 3] { axis } else { cross(line, axis) };
            is_met &= is_along(ends[0], across) && is_along(ends[0], across.map(|x| -x));
        }
        is_met &= is_along(ends[0], line) && is_along(ends[1], line.map(|x| -x));
    } else {
        is_met &= is_along(t[0], normal) && is_along(t[0], normal.map(|x| -x));
        for k in 0..3 {
            let inwards = cross(normal, minus(t[(k + 1) % 3], t[k]));
            is_met &= is_along(t[k], inwards);
        }
    }
    is_met.then_some(low)
}
