// Exact signs of determinants for six points, over the integers that their coordinates are.
//
// f32 coordinates are whole multiples of a power of two. Each axis has one of its own, the largest
// that divides all six values, for scaling an axis changes no sign. Positions count from point 0. When
// the sizes of the three axes leave 128 bits enough for every determinant (real meshes need 70), all
// predicates below are exact; when not, the CPU decides the pair.

const POINTS = 6u;

// The positions as 64-bit integers: axis + 3 · point.
var<private> lattice: array<vec2u, 18>;

// Two of three determinants of three factors each fit in 128 bits if the bits of the axes sum to 124.
const MOST_BITS = 124u;
// Positions below 2^62.
const MOST_SHIFT = 38;

fn difference64(x: vec2u, y: vec2u) -> vec2u {
    return vec2u(x.x - y.x, x.y - y.y - select(0u, 1u, x.x < y.x));
}

fn bits_of(x: vec2u) -> u32 {
    return select(32u - countLeadingZeros(x.x), 64u - countLeadingZeros(x.y), x.y != 0u);
}

// Places six points on their lattice; false if they do not fit.
fn place_on_lattice(points: array<vec3f, POINTS>) -> bool {
    var own = points;
    var bits = 0u;
    for (var axis = 0u; axis < 3u; axis++) {
        var finest = 1000;
        for (var i = 0u; i < POINTS; i++) {
            let x = parts_of(bitcast<u32>(own[i][axis]));
            if x.significand != 0u {
                finest = min(finest, x.exponent + i32(countTrailingZeros(x.significand)));
            }
        }
        var origin: vec2u;
        var extent: vec2u;
        for (var i = 0u; i < POINTS; i++) {
            let value = bitcast<u32>(own[i][axis]);
            let x = parts_of(value);
            let shift = select(x.exponent - finest, 0, x.significand == 0u);
            if shift > MOST_SHIFT {
                return false;
            }
            var position = shifted(x.significand, shift);
            if (value & SIGN) != 0u {
                position = difference64(vec2u(0u), position);
            }
            if i == 0u {
                origin = position;
            }
            position = difference64(position, origin);
            lattice[axis + 3u * i] = position;
            extent |= select(position, difference64(vec2u(0u), position), (position.y & SIGN) != 0u);
        }
        // Between two points that count from a third, one bit more.
        bits += bits_of(extent) + 1u;
    }
    return bits <= MOST_BITS;
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
fn from_to(axis: u32, j: u32, i: u32) -> vec4u {
    let d = difference64(lattice[axis + 3u * i], lattice[axis + 3u * j]);
    return vec4u(d, vec2u(select(0u, 0xffffffffu, (d.y & SIGN) != 0u)));
}

// The determinant of b − a and c − a in the plane that leaves out one axis.
fn turn(axis: u32, a: u32, b: u32, c: u32) -> vec4u {
    let x = (axis + 1u) % 3u;
    let y = (axis + 2u) % 3u;
    return subtract(
        multiply(from_to(x, a, b), from_to(y, a, c)),
        multiply(from_to(y, a, b), from_to(x, a, c)),
    );
}

// See orient2d and orient3d in the core's predicates.
fn orient2d(axis: u32, a: u32, b: u32, c: u32) -> i32 {
    return sign_of(turn(axis, a, b, c));
}

fn orient3d(a: u32, b: u32, c: u32, d: u32) -> i32 {
    var sum = vec4u(0u);
    for (var axis = 0u; axis < 3u; axis++) {
        sum = add(sum, multiply(turn(axis, a, b, c), from_to(axis, a, d)));
    }
    return sign_of(sum);
}
