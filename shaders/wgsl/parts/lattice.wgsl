// Exact signs of determinants for six points, over the integers that their coordinates are.
//
// f32 coordinates are whole multiples of a power of two. Each axis has one of its own, the largest
// that divides all six values, for scaling an axis changes no sign. Positions count from point 0. When
// the sizes of the three axes leave 128 bits enough for every determinant (real meshes need 70), all
// predicates below are exact; when not, the CPU decides the pair. Where differences fit in 32 bits,
// as nearly all do, a determinant takes a tenth of the work.

// The positions as 64-bit integers: for each team, axis by axis, point by point.
var<workgroup> lattice: array<vec2u, TEAMS * 3 * POINTS>;
// Where this team's begin.
var<private> lattice_at: u32;
// Whether all differences fit in 32 bits.
var<private> short: bool;

// Two of three determinants of three factors each fit in 128 bits if the bits of the axes sum to 124.
const MOST_BITS = 124u;
// An axis that does not fit.
const TOO_MANY = 1000u;
// Positions below 2^62.
const MOST_SHIFT = 38;

fn difference64(x: vec2u, y: vec2u) -> vec2u {
    return vec2u(x.x - y.x, x.y - y.y - select(0u, 1u, x.x < y.x));
}

fn bits_of(x: vec2u) -> u32 {
    return select(32u - countLeadingZeros(x.x), 64u - countLeadingZeros(x.y), x.y != 0u);
}

// Places the coordinates of six points on their lattice; how many bits a difference has. The pass says
// with `coordinate` where they are.
fn place_on_lattice(axis: u32) -> u32 {
    var finest = 1000;
    for (var i = 0u; i < POINTS; i++) {
        let x = parts_of(coordinate(axis, i));
        if x.significand != 0u {
            finest = min(finest, x.exponent + i32(countTrailingZeros(x.significand)));
        }
    }
    var origin: vec2u;
    var extent: vec2u;
    for (var i = 0u; i < POINTS; i++) {
        let value = coordinate(axis, i);
        let x = parts_of(value);
        let shift = select(x.exponent - finest, 0, x.significand == 0u);
        if shift > MOST_SHIFT {
            return TOO_MANY;
        }
        var position = shifted(x.significand, shift);
        if (value & SIGN) != 0u {
            position = difference64(vec2u(0u), position);
        }
        if i == 0u {
            origin = position;
        }
        position = difference64(position, origin);
        lattice[lattice_at + axis * POINTS + i] = position;
        extent |= select(position, difference64(vec2u(0u), position), (position.y & SIGN) != 0u);
    }
    // Between two points that count from a third, one bit more.
    return bits_of(extent) + 1u;
}

// m · 2^shift, which is whole.
fn shifted(m: u32, shift: i32) -> vec2u {
    if shift <= 0 {
        return vec2u(m >> u32(-shift), 0u);
    }
    if shift >= 32 {
        return vec2u(0u, m << u32(shift - 32));
    }
    return vec2u(m << u32(shift), m >> u32(32 - shift));
}

// Along one axis, from point j to point i.
fn from_to(axis: u32, j: u32, i: u32) -> vec2u {
    let at = lattice_at + axis * POINTS;
    return difference64(lattice[at + i], lattice[at + j]);
}

// The determinant of b − a and c − a in the plane that leaves out one axis.
fn turn(axis: u32, a: u32, b: u32, c: u32) -> vec4u {
    let x = (axis + 1u) % 3u;
    let y = (axis + 2u) % 3u;
    let p = from_to(x, a, b);
    let q = from_to(y, a, c);
    let r = from_to(y, a, b);
    let s = from_to(x, a, c);
    if short {
        return extended(difference64(product_of_signed(p.x, q.x), product_of_signed(r.x, s.x)));
    }
    return subtract(multiply(extended(p), extended(q)), multiply(extended(r), extended(s)));
}

// See orient2d and orient3d in the core's predicates.
fn orient2d(axis: u32, a: u32, b: u32, c: u32) -> i32 {
    return sign_of(turn(axis, a, b, c));
}

fn orient3d(a: u32, b: u32, c: u32, d: u32) -> i32 {
    var sum = vec4u(0u);
    for (var axis = 0u; axis < 3u; axis++) {
        let area = turn(axis, a, b, c);
        let height = from_to(axis, a, d);
        if short {
            sum = add(sum, times_signed_limb(area, height.x));
        } else {
            sum = add(sum, multiply(area, extended(height)));
        }
    }
    return sign_of(sum);
}
