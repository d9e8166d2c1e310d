// Whether two triangles meet, where f32 is sure of it (accuracy.md, f32 filters).
//
// WGSL may round either way, fuse, reassociate and flush, so a sign counts only beyond
// 2^-19 · permanent + 2^-117 · (1 + M)², M being the largest difference of coordinates: 16 ulp for each
// product of three, and what flushing may cost. Above M = 1e12 nothing is sure: beyond, products may overflow. Corners are
// finite, posed ones too, and so are their differences.
//
// Differences of coordinates of shadows are off by `query.error`. A sign between shadows counts only beyond what
// that can make of the determinant besides; the host decides what it leaves open.

// 1 if the host decides what f32 leaves open: `query.certify`.
override CERTIFY = 0u;

const RELATIVE = 1.9073486328125e-6;
const ABSOLUTE = 6.018531076210112e-36;
// The bits of 1e12.
const SURE_BELOW = 0x5368d4a5u;

fn difference(p: vec3f, q: vec3f) -> vec3f {
    return opaque(p - q);
}

fn size_bits(v: vec3f) -> u32 {
    let bits = bitcast<vec3u>(v) & vec3u(0x7fffffffu);
    return max(max(bits.x, bits.y), bits.z);
}

// The side of the plane of `t` on which each corner of `p` lies, farther than `reach` from it, 0 where unsure: one bound serves all
// three.
fn filtered_sides(t: Triangle, p: Triangle, reach: f32) -> vec3i {
    let u = difference(t[1], t[0]);
    let v = difference(t[2], t[0]);
    let w = Triangle(difference(p[0], t[0]), difference(p[1], t[0]), difference(p[2], t[0]));
    let of_p = max(max(abs(w[0]), abs(w[1])), abs(w[2]));
    let most = max(max(abs(u), abs(v)), of_p);
    let extent = max(max(most.x, most.y), most.z);
    if bitcast<u32>(extent) > SURE_BELOW {
        return vec3i(0);
    }
    let r = u.yzx * v.zxy;
    let s = u.zxy * v.yzx;
    let normal = r - s;
    let heights = vec3f(dot(normal, w[0]), dot(normal, w[1]), dot(normal, w[2]));
    var bound = error_bound(dot(abs(r) + abs(s), of_p), most);
    if reach > 0.0 {
        // No corner is farther from a plane than four times the largest difference.
        if reach > 4.0 * extent {
            return vec3i(0);
        }
        // |normal| is computed from numbers about 1; what it was rounded by is a share of what it is the difference of.
        let size = max(bitcast<f32>(size_bits(normal)), 1e-30);
        let rounded = RELATIVE * dot(abs(r) + abs(s), vec3f(1.0)) + 1e-30;
        bound += reach * (size * length(normal / size) * (1.0 + RELATIVE) + rounded);
    }
    let above = select(vec3i(0), vec3i(1), heights > vec3f(bound));
    return above - select(vec3i(0), vec3i(1), heights < vec3f(-bound));
}

// The sign of det(u, v, w).
fn filtered_sign(u: vec3f, v: vec3f, w: vec3f) -> i32 {
    let extent = max(max(size_bits(u), size_bits(v)), size_bits(w));
    if extent > SURE_BELOW {
        return 0;
    }
    let p = u.yzx * v.zxy;
    let q = u.zxy * v.yzx;
    let determinant = dot(p - q, w);
    let most = max(max(abs(u), abs(v)), abs(w));
    let bound = error_bound(dot(abs(p) + abs(q), abs(w)), most);
    return select(0, 1, determinant > bound) - select(0, 1, determinant < -bound);
}

// How far a determinant may be off, by its permanent and the largest coordinates of its rows.
fn error_bound(permanent: f32, most: vec3f) -> f32 {
    let scale = 1.0 + max(max(most.x, most.y), most.z);
    let bound = RELATIVE * permanent + ABSOLUTE * scale * scale;
    if CERTIFY == 1u {
        return bound + shadow_error(most) + ABSOLUTE * scale * scale;
    }
    return bound;
}

// The most that errors of coordinates change a determinant whose rows are within `most`: it is linear in each of them, and
// has six products. A sixtieth more covers the roundings here.
fn shadow_error(most: vec3f) -> f32 {
    let e = query.error;
    let n = most + e;
    return 6.1 * (e.x * n.y * n.z + most.x * (e.y * n.z + most.y * e.z));
}

fn filtered_orient3d(a: vec3f, b: vec3f, c: vec3f, d: vec3f) -> i32 {
    return filtered_sign(difference(b, a), difference(c, a), difference(d, a));
}

// The logic of the core's `triangle::meet`, without zeros.
fn filtered_meet(a: Triangle, b: Triangle) -> u32 {
    let a_sides = filtered_sides(b, a, 0.0);
    if one_sided(a_sides) {
        return MISS;
    }
    let b_sides = filtered_sides(a, b, 0.0);
    if one_sided(b_sides) {
        return MISS;
    }
    return filtered_crossing(a, a_sides, b, b_sides);
}

// The same of triangles that neither's plane separates, by the sides on which the corners of each are of the other's.
fn filtered_crossing(a: Triangle, a_sides: vec3i, b: Triangle, b_sides: vec3i) -> u32 {
    if any(a_sides == vec3i(0)) || any(b_sides == vec3i(0)) {
        return UNSURE;
    }
    let p = lone_first(a, a_sides);
    var q = lone_first(b, b_sides);
    let delta = lone_side(a_sides);
    let epsilon = lone_side(b_sides);
    if delta != epsilon {
        q = Triangle(q[0], q[2], q[1]);
    }
    let start = filtered_orient3d(p[0], p[1], q[0], q[1]);
    let end = filtered_orient3d(p[0], p[2], q[0], q[2]);
    if start == epsilon || end == -epsilon {
        return MISS;
    }
    return select(HIT, UNSURE, start == 0 || end == 0);
}

// The sign that differs from the two others, of three that are not all the same.
fn lone_side(sides: vec3i) -> i32 {
    return -(sides.x + sides.y + sides.z);
}

fn lone_first(t: Triangle, sides: vec3i) -> Triangle {
    return turned_to(t, select(select(2u, 1u, sides.x == sides.z), 0u, sides.y == sides.z));
}

fn turned_to(t: Triangle, first: u32) -> Triangle {
    if first == 0u {
        return t;
    }
    if first == 1u {
        return Triangle(t[1], t[2], t[0]);
    }
    return Triangle(t[2], t[0], t[1]);
}

// Triangles of one mesh with so many corners in common, which come first in both: the core's
// `triangle::neighbours` where no sign is zero.
fn filtered_neighbours(shared_corners: u32, a: Triangle, b: Triangle) -> u32 {
    if shared_corners == 3u {
        return HIT;
    }
    if shared_corners == 2u {
        let is_apart =
            separated_at_edge(a, b[2]) || filtered_orient3d(a[0], a[1], a[2], b[2]) != 0;
        return select(UNSURE, MISS, is_apart);
    }
    if separated_at_vertex(a, b) {
        return MISS;
    }
    let a_sides = filtered_sides(b, a, 0.0).yz;
    let b_sides = filtered_sides(a, b, 0.0).yz;
    if a_sides.x * a_sides.y > 0 || b_sides.x * b_sides.y > 0 {
        return MISS;
    }
    // A line is past the triangle if it has edges on either side, wherever its ends are.
    let own = filtered_pierces(a[1], a[2], b);
    let other = filtered_pierces(b[1], b[2], a);
    if own == MISS && other == MISS {
        return MISS;
    }
    let reach =
        (a_sides.x * a_sides.y < 0 && own == HIT) || (b_sides.x * b_sides.y < 0 && other == HIT);
    return select(UNSURE, HIT, reach);
}

// Whether a plane through the shared vertex of neighbours, which are no shadows, the first corner, has the other corners of one triangle above it and those of the
// other below: the core's `separated_at_vertex`. Any plane will do.
fn separated_at_vertex(a: Triangle, b: Triangle) -> bool {
    let p = difference(a[1], a[0]);
    let q = difference(a[2], a[0]);
    let r = difference(b[1], a[0]);
    let s = difference(b[2], a[0]);
    if max(max(size_bits(p), size_bits(q)), max(size_bits(r), size_bits(s))) > SURE_BELOW {
        return false;
    }
    let normal = opaque((direction(p) + direction(q)) - (direction(r) + direction(s)));
    let above = is_above(normal, p) && is_above(normal, q);
    return above && is_above(normal, -r) && is_above(normal, -s);
}

fn direction(e: vec3f) -> vec3f {
    return e / max(abs(e.x) + abs(e.y) + abs(e.z), 1e-30);
}

// Whether dot(normal, e) is positive, for a normal of coordinates up to 4: it has four roundings, fewer than a determinant.
fn is_above(normal: vec3f, e: vec3f) -> bool {
    let scale = 1.0 + bitcast<f32>(size_bits(e));
    return dot(normal, e) > RELATIVE * dot(abs(normal), abs(e)) + ABSOLUTE * scale * scale;
}

// Whether a plane through the shared edge, the first two corners, has the third of `a` on one side and `d` on the other: the
// core's `separated_at_edge`. Any plane will do; this one is at a right angle to `a`.
fn separated_at_edge(a: Triangle, d: vec3f) -> bool {
    let edge = difference(a[1], a[0]);
    let other = difference(a[2], a[0]);
    if max(size_bits(edge), size_bits(other)) > SURE_BELOW {
        return false;
    }
    let normal = opaque(cross(edge, other));
    let own = filtered_sign(edge, normal, other);
    return own * filtered_sign(edge, normal, difference(d, a[0])) < 0;
}

// Whether the line through two points goes through a triangle.
fn filtered_pierces(start: vec3f, end: vec3f, t: Triangle) -> u32 {
    let line = difference(end, start);
    let p = difference(t[0], start);
    let q = difference(t[1], start);
    let r = difference(t[2], start);
    let sides =
        vec3i(filtered_sign(line, p, q), filtered_sign(line, q, r), filtered_sign(line, r, p));
    if any(sides < vec3i(0)) && any(sides > vec3i(0)) {
        return MISS;
    }
    return select(HIT, UNSURE, any(sides == vec3i(0)));
}
