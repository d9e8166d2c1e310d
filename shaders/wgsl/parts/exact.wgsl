// Whether two triangles meet, exactly, with corners as points of the lattice. It is the core's `triangle`,
// whose comments say why each step is right, for triangles with area: what has none is rare and
// stays UNSURE.
//
// A team decides a pair in two rounds of signs, each member finding one: one invocation alone would take
// many times as long, and there are rarely so many pairs that it matters how long all of them take.

struct Pair {
    a: vec3u,
    b: vec3u,
    // How many corners are shared; they come first in both.
    shared_corners: u32,
}

// The sides on which the corners of each lie, seen from the plane of the other.
struct Sides {
    a: vec3i,
    b: vec3i,
}

// The test that the sides leave to do; or MISS.
const INTERVALS = 3u;
const PIERCES = 4u;
const FLAT = 5u;
const EDGE = 6u;

// The first round, for each of six members.
fn side_of_corner(pair: Pair, member: u32) -> i32 {
    let own = member < 3u;
    let plane = select(pair.a, pair.b, own);
    let points = select(pair.b, pair.a, own);
    return orient3d(plane.x, plane.y, plane.z, points[member % 3u]);
}

fn question(pair: Pair, sides: Sides) -> u32 {
    if pair.shared_corners == 2u {
        return select(EDGE, MISS, sides.b.z != 0);
    }
    let shares = pair.shared_corners == 1u;
    let is_apart = select(
        one_sided(sides.a) || one_sided(sides.b),
        sides.a.y * sides.a.z > 0 || sides.b.y * sides.b.z > 0,
        shares,
    );
    if is_apart {
        return MISS;
    }
    // In one plane, or one of them is without area.
    let is_flat = all(sides.a == vec3i(0)) || all(sides.b == vec3i(0));
    return select(select(INTERVALS, PIERCES, shares), FLAT, is_flat);
}

// The second round, for each member of a team.
fn reply(pair: Pair, sides: Sides, asked: u32, member: u32) -> i32 {
    if asked == INTERVALS || asked == PIERCES {
        let line = select(piercing_line(pair, member), interval(pair, sides, member), asked == INTERVALS);
        return orient3d(line.x, line.y, line.z, line.w);
    }
    if asked == EDGE {
        return i32(beyond_edge(pair));
    }
    return i32(flat_reply(pair, member));
}

fn conclusion(sides: Sides, pair: Pair, asked: u32, replies: array<i32, TEAM>) -> u32 {
    let r = replies;
    switch asked {
        case INTERVALS: {
            let side = lone_corner(sides.b).side;
            return select(HIT, MISS, r[0] == side || r[1] == -side);
        }
        case PIERCES: {
            let own = vec3i(r[0], r[1], r[2]);
            let other = vec3i(r[3], r[4], r[5]);
            return select(HIT, MISS, has_both(own) && has_both(other));
        }
        case EDGE: {
            return u32(r[0]);
        }
        case FLAT: {
            let own = vec4i(r[0], r[1], r[2], r[3]);
            let other = vec4i(r[4], r[5], r[6], r[7]);
            if any(own == vec4i(i32(UNSURE))) {
                return UNSURE;
            }
            // A MISS says that some line separates them.
            let misses = vec2<bool>(any(own == vec4i(i32(MISS))), any(other == vec4i(i32(MISS))));
            return select(HIT, MISS, select(any(misses), all(misses), pair.shared_corners == 1u));
        }
        default: {
            return asked;
        }
    }
}

fn has_both(sides: vec3i) -> bool {
    return any(sides < vec3i(0)) && any(sides > vec3i(0));
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

// No vertex in common: the ends of the intervals on the line that both planes share.
fn interval(pair: Pair, sides: Sides, member: u32) -> vec4u {
    let i = lone_corner(sides.a);
    let j = lone_corner(sides.b);
    let p = rotated(pair.a, i.corner);
    let turned = rotated(pair.b, j.corner);
    let q = select(turned, turned.xzy, i.side != j.side);
    let end = select(2u, 1u, member == 0u);
    return vec4u(p.x, p[end], q.x, q[end]);
}

// One vertex in common: the edge opposite to it in one, and an edge of the other.
fn piercing_line(pair: Pair, member: u32) -> vec4u {
    let own = member < 3u;
    let edge = select(pair.b.yz, pair.a.yz, own);
    let t = select(pair.a, pair.b, own);
    return vec4u(edge, t[member % 3u], t[(member + 1u) % 3u]);
}

// An edge in common, the first two corners of both, in one plane: on the same side of it?
fn beyond_edge(pair: Pair) -> u32 {
    let seen = seen_with_area(pair.a, vec3u(pair.a.xy, pair.b.z));
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

// Triangles of one plane: whether the line along one edge separates them. Neighbours are tested by
// the edge of either opposite to its first corner, against the other: a segment has 1 edge.
fn flat_reply(pair: Pair, member: u32) -> u32 {
    let seen = seen_with_area(pair.a, pair.b);
    if seen.axis == 3u {
        return UNSURE;
    }
    if pair.shared_corners == 0u {
        return select(HIT, MISS, member < 6u && separates(seen.axis, pair.a, pair.b, 3u, member));
    }
    let own = member < 4u;
    let segment = select(pair.b.yzz, pair.a.yzz, own);
    let t = select(pair.a, pair.b, own);
    return select(HIT, MISS, separates(seen.axis, segment, t, 1u, member % 4u));
}

// Whether the line along one edge, of `p` with so many edges or of the triangle `q`, separates them.
fn separates(axis: u32, p: vec3u, q: vec3u, edges: u32, which: u32) -> bool {
    let own = which < edges;
    let edge = select(which - edges, which, own);
    let polygon = select(q, p, own);
    let other = select(p, q, own);
    let is_segment = own && edges == 1u;
    // The side that has to be free: where the third corner is not, or either side of a segment.
    var free = 0;
    for (var k = 0u; k < 4u; k++) {
        let third = select(polygon[(edge + 2u) % 3u], other.x, is_segment);
        let point = select(other[(k + 2u) % 3u], third, k == 0u);
        let side = orient2d(axis, polygon[edge], polygon[(edge + 1u) % 3u], point);
        if k == 0u {
            free = select(-side, side, is_segment);
        }
        if free == 0 || (k != 0u && side != free) {
            return false;
        }
    }
    return true;
}
