// Whether two triangles meet, exactly, with corners as indices into the lattice. It is the core's
// `triangle`, whose comments say why each step is right, for triangles with area: what has none is rare
// and stays UNSURE.
//
// Compilers put every call in line, and a determinant is long. So signs are found in loops, and a
// predicate is called from as few places as will do.

// The sides on which the corners of each lie, seen from the plane of the other.
struct Sides {
    a: vec3i,
    b: vec3i,
}

fn mutual_sides(a: vec3u, b: vec3u) -> Sides {
    var sides: Sides;
    for (var i = 0u; i < 6u; i++) {
        let own = i < 3u;
        let plane = select(a, b, own);
        let points = select(b, a, own);
        let side = orient3d(plane.x, plane.y, plane.z, points[i % 3u]);
        if own {
            sides.a[i] = side;
        } else {
            sides.b[i - 3u] = side;
        }
    }
    return sides;
}

// In one plane, or one of them is without area.
fn is_flat(sides: Sides) -> bool {
    return all(sides.a == vec3i(0)) || all(sides.b == vec3i(0));
}

// No vertex in common.
fn exactly_meet(a: vec3u, b: vec3u) -> u32 {
    let sides = mutual_sides(a, b);
    if one_sided(sides.a) || one_sided(sides.b) {
        return MISS;
    }
    if is_flat(sides) {
        return flat_meet(a, b, false);
    }
    let i = lone_corner(sides.a);
    let j = lone_corner(sides.b);
    let p = rotated(a, i.corner);
    let q = select(rotated(b, j.corner), rotated(b, j.corner).xzy, i.side != j.side);
    for (var end = 1u; end < 3u; end++) {
        if orient3d(p.x, p[end], q.x, q[end]) == select(-j.side, j.side, end == 1u) {
            return MISS;
        }
    }
    return HIT;
}

struct Lone {
    corner: u32,
    side: i32,
}

fn lone_corner(sides: vec3i) -> Lone {
    var own = sides;
    for (var i = 0u; i < 3u; i++) {
        if own.x != 0 && own.x != own.y && own.x != own.z {
            return Lone(i, own.x);
        }
        if own.x == 0 && own.y != 0 && own.y == own.z {
            return Lone(i, -own.y);
        }
        own = own.yzx;
    }
    return Lone(0u, 0);
}

// One vertex in common, in the first corner of both: the opposite edge of one meets the other.
fn beyond_vertex(a: vec3u, b: vec3u) -> u32 {
    let sides = mutual_sides(a, b);
    if sides.a.y * sides.a.z > 0 || sides.b.y * sides.b.z > 0 {
        return MISS;
    }
    if is_flat(sides) {
        return flat_meet(a, b, true);
    }
    for (var i = 0u; i < 2u; i++) {
        let edge = select(b.yz, a.yz, i == 0u);
        if pierces(edge, select(a, b, i == 0u)) {
            return HIT;
        }
    }
    return MISS;
}

// Whether a segment that reaches the plane of `t` in one point does so within `t`.
fn pierces(s: vec2u, t: vec3u) -> bool {
    var seen = vec2<bool>(false);
    for (var i = 0u; i < 3u; i++) {
        let side = orient3d(s.x, s.y, t[i], t[(i + 1u) % 3u]);
        seen |= vec2<bool>((side < 0), (side > 0));
    }
    return !all(seen);
}

// An edge in common, the first two corners of both: they lie on the same side of it.
fn beyond_edge(a: vec3u, b: vec3u) -> u32 {
    if orient3d(a.x, a.y, a.z, b.z) != 0 {
        return MISS;
    }
    let seen = seen_with_area(a, vec3u(a.xy, b.z));
    return select(select(MISS, HIT, seen.turns.x == seen.turns.y), UNSURE, seen.axis == 3u);
}

struct Seen {
    // Along which axis; 3 if along none.
    axis: u32,
    turns: vec2i,
}

// How to look at two triangles of one plane so that both have area.
fn seen_with_area(a: vec3u, b: vec3u) -> Seen {
    for (var axis = 0u; axis < 3u; axis++) {
        var turns: vec2i;
        for (var i = 0u; i < 2u; i++) {
            let t = select(b, a, i == 0u);
            turns[i] = orient2d(axis, t.x, t.y, t.z);
        }
        if all(turns != vec2i(0)) {
            return Seen(axis, turns);
        }
    }
    return Seen(3u, vec2i(0));
}

// Triangles of one plane; of neighbours, the edge of each that is opposite to the first corner against
// the other.
fn flat_meet(a: vec3u, b: vec3u, neighbours: bool) -> u32 {
    let seen = seen_with_area(a, b);
    if seen.axis == 3u {
        return UNSURE;
    }
    if !neighbours {
        return select(HIT, MISS, apart(seen.axis, a, b, 3u));
    }
    for (var i = 0u; i < 2u; i++) {
        let edge = select(b.yzz, a.yzz, i == 0u);
        if !apart(seen.axis, edge, select(a, b, i == 0u), 1u) {
            return HIT;
        }
    }
    return MISS;
}

// Whether a line along an edge separates `p`, of 3 edges or a segment of 1, from the triangle `q`.
fn apart(axis: u32, p: vec3u, q: vec3u, edges: u32) -> bool {
    for (var i = 0u; i < edges + 3u; i++) {
        let own = i < edges;
        let edge = select(i - edges, i, own);
        let polygon = select(q, p, own);
        let other = select(p, q, own);
        let is_segment = own && edges == 1u;
        // The side that has to be free: where the third corner is not, or either side of a segment.
        var free = 0;
        var all_free = true;
        for (var k = 0u; k < 4u; k++) {
            let third = select(polygon[(edge + 2u) % 3u], other.x, is_segment);
            let point = select(other[(k + 2u) % 3u], third, k == 0u);
            let side = orient2d(axis, polygon[edge], polygon[(edge + 1u) % 3u], point);
            if k == 0u {
                free = select(-side, side, is_segment);
            }
            all_free = all_free && (k == 0u || side == free) && free != 0;
        }
        if all_free {
            return true;
        }
    }
    return false;
}
