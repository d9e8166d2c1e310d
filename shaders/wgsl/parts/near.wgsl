// Whether two triangles are at most `query.distance` apart, where f32 is sure of it: the core's `bvtt::nearest`, one pair an
// invocation.
//
// Near points x and y of both triangles are found, by any means, and then have to prove it: they are feasible, and |x - y| is at
// most the distance; or along y - x the second triangle begins farther behind the first than the distance. These are off by
// at most the margin, 2^-15 of the largest coordinate R: seven times the core's, whose operations round to nearest; these may round either
// way, fuse, reassociate, and divide with some units of error, which only moves points within their triangles. Coordinates
// are scaled so that R is from 1 to 2, where nothing overflows, and what is flushed is far below the margin. There is no
// division by less than 2^-60, since compilers may take it that no number is infinite, or none at all.

// The bits of 2^-100 and of 2^100.
const LEAST_EXTENT = 0x0d800000u;
const MOST_EXTENT = 0x71800000u;
// 2^-15; 2^-60; 2^-20.
const MARGIN = 3.0517578125e-5;
const LEAST_DIVISOR = 8.673617379884035e-19;
const LEAST_LENGTH = 9.5367431640625e-7;

struct Shortest {
    // x - y, and its square.
    z: vec3f,
    square: f32,
}

fn outcome_of_distance(a: Triangle, b: Triangle) -> u32 {
    let p = Triangle(vec3f(0.0), difference(a[1], a[0]), difference(a[2], a[0]));
    let q = Triangle(difference(b[0], a[0]), difference(b[1], a[0]), difference(b[2], a[0]));
    let of_a = max(size_bits(p[1]), size_bits(p[2]));
    let bits = max(of_a, max(size_bits(q[0]), max(size_bits(q[1]), size_bits(q[2]))));
    let error = 1.75 * max(max(query.error.x, query.error.y), query.error.z);
    let extent = bitcast<f32>(bits);
    if bits < LEAST_EXTENT || bits > MOST_EXTENT || error > extent {
        return UNSURE;
    }
    // No two points are so far apart.
    if query.distance > 64.0 * extent {
        return HIT;
    }
    // 2^-e for an extent from 2^e to 2^(e + 1).
    let scale = bitcast<f32>(0x7f000000u - (bits & 0x7f800000u));
    return certified(
        Triangle(p[0], p[1] * scale, p[2] * scale),
        Triangle(q[0] * scale, q[1] * scale, q[2] * scale),
        query.distance * scale,
        2.0 * MARGIN + error * scale,
    );
}

fn certified(a: Triangle, b: Triangle, distance: f32, margin: f32) -> u32 {
    let z = between(a, b);
    let square = dot(z, z);
    let most = distance - margin;
    if most > 0.0 && square * (1.0 + MARGIN) <= most * most {
        return HIT;
    }
    let least = distance + margin;
    let of_a = vec3f(dot(z, a[0]), dot(z, a[1]), dot(z, a[2]));
    let of_b = vec3f(dot(z, b[0]), dot(z, b[1]), dot(z, b[2]));
    // From x to y, heights are along -z.
    let gap = min(min(of_a.x, of_a.y), of_a.z) - max(max(of_b.x, of_b.y), of_b.z);
    let is_direction = square >= LEAST_LENGTH * LEAST_LENGTH;
    if is_direction && gap > 0.0 && square * least * least * (1.0 + MARGIN) <= gap * gap {
        return MISS;
    }
    return UNSURE;
}

fn between(a: Triangle, b: Triangle) -> vec3f {
    var best = Shortest(a[0] - b[0], 1e30);
    let of_a = edges(a);
    let of_b = edges(b);
    // Written out, since arrays that a loop indexes are not kept in registers.
    best = shorter(best, between_edges(a[0], of_a[0], b[0], of_b[0]));
    best = shorter(best, between_edges(a[0], of_a[0], b[1], of_b[1]));
    best = shorter(best, between_edges(a[0], of_a[0], b[2], of_b[2]));
    best = shorter(best, between_edges(a[1], of_a[1], b[0], of_b[0]));
    best = shorter(best, between_edges(a[1], of_a[1], b[1], of_b[1]));
    best = shorter(best, between_edges(a[1], of_a[1], b[2], of_b[2]));
    best = shorter(best, between_edges(a[2], of_a[2], b[0], of_b[0]));
    best = shorter(best, between_edges(a[2], of_a[2], b[1], of_b[1]));
    best = shorter(best, between_edges(a[2], of_a[2], b[2], of_b[2]));
    best = shorter(best, from_face(a, b[0]));
    best = shorter(best, from_face(a, b[1]));
    best = shorter(best, from_face(a, b[2]));
    best = shorter(best, -from_face(b, a[0]));
    best = shorter(best, -from_face(b, a[1]));
    best = shorter(best, -from_face(b, a[2]));
    return best.z;
}

fn shorter(best: Shortest, z: vec3f) -> Shortest {
    let square = dot(z, z);
    if square < best.square {
        return Shortest(z, square);
    }
    return best;
}

fn edges(t: Triangle) -> Triangle {
    return Triangle(t[1] - t[0], t[2] - t[1], t[0] - t[2]);
}

// Between 0 and 1, whatever the quotient.
fn share_of(numerator: f32, divisor: f32) -> f32 {
    return clamp(numerator / max(divisor, LEAST_DIVISOR), 0.0, 1.0);
}

// x - y for near points of two segments, from p along g and from q along h (Ericson, Real-Time Collision Detection, 5.1.9).
fn between_edges(p: vec3f, g: vec3f, q: vec3f, h: vec3f) -> vec3f {
    let w = p - q;
    let gg = dot(g, g);
    let gh = dot(g, h);
    let hh = dot(h, h);
    let gw = dot(g, w);
    let hw = dot(h, w);
    let s = share_of(gh * hw - gw * hh, gg * hh - gh * gh);
    let t = share_of(gh * s + hw, hh);
    return w + g * share_of(gh * t - gw, gg) - h * t;
}

// x - y for a point y and a point x of a triangle that is near it; the nearest if that is inside.
fn from_face(t: Triangle, y: vec3f) -> vec3f {
    let g = t[1] - t[0];
    let h = t[2] - t[0];
    let w = y - t[0];
    let n = cross(g, h);
    let gg = dot(g, g);
    let gh = dot(g, h);
    let hh = dot(h, h);
    let gw = dot(g, w);
    let hw = dot(h, w);
    let s = share_of(hh * gw - gh * hw, dot(n, n));
    let other = share_of(gg * hw - gh * gw, dot(n, n));
    return g * s + h * min(other, 1.0 - s) - w;
}
