// The posed position of a vertex, to the bit: ((r0·x + r1·y) + r2·z) + t, each operation rounded to
// nearest, none fused. Compilers contract and reassociate, so every result passes through an xor with a
// zero that they cannot know. Where an adapter flushes subnormal numbers, a position that may have lost
// one is in doubt, and the CPU decides the pair; where it rounds otherwise, integers do all of it.
// `probe` finds out.

const HARDWARE = 0u;
const FLUSHING = 1u;
const INTEGER = 2u;
override ARITHMETIC: u32 = HARDWARE;

// Whether a subnormal number may have been flushed since this was last cleared.
var<private> doubt: bool;

struct Rows {
    // The first three columns of a pose, and the translation.
    columns: array<vec3f, 3>,
    translation: vec3f,
}

fn opaque(v: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(v) ^ vec3u(nothing));
}

fn posed_position(rows: Rows, p: vec3f) -> vec3f {
    if ARITHMETIC == INTEGER {
        return soft_position(rows, p);
    }
    let x = times(rows.columns[0], p.x);
    let y = times(rows.columns[1], p.y);
    let z = times(rows.columns[2], p.z);
    return plus(plus(plus(x, y), z), rows.translation);
}

fn times(c: vec3f, x: f32) -> vec3f {
    let product = opaque(c * x);
    if ARITHMETIC == FLUSHING {
        let is_zero = (magnitude(c) == vec3u(0u)) | (magnitude(vec3f(x)) == vec3u(0u));
        doubt |= any(is_small(product) & !is_zero);
    }
    return product;
}

fn plus(x: vec3f, y: vec3f) -> vec3f {
    let sum = opaque(x + y);
    if ARITHMETIC == FLUSHING {
        // Opposite numbers give a true zero, and so do two zeros.
        let is_zero = magnitude(x) == magnitude(y);
        doubt |= any((is_small(sum) & !is_zero) | is_subnormal(y));
    }
    return sum;
}

// The bits without the sign. Integers, since an adapter that flushes may do so in comparisons, too.
fn magnitude(v: vec3f) -> vec3u {
    return bitcast<vec3u>(v) & vec3u(0x7fffffffu);
}

// Zero or subnormal, or the smallest normal number.
fn is_small(v: vec3f) -> vec3<bool> {
    return magnitude(v) <= vec3u(0x800000u);
}

fn is_subnormal(v: vec3f) -> vec3<bool> {
    return magnitude(v) - vec3u(1u) < vec3u(0x7fffffu);
}

// One operation at a time, in a loop: compilers put every call in line.
fn soft_position(rows: Rows, p: vec3f) -> vec3f {
    var own = rows;
    var point = p;
    var posed: vec3f;
    for (var row = 0u; row < 3u; row++) {
        var sum = 0u;
        for (var i = 0u; i < 3u; i++) {
            let product = soft_times(bitcast<u32>(own.columns[i][row]), bitcast<u32>(point[i]));
            if i == 0u {
                sum = product;
            } else {
                sum = soft_plus(sum, product);
            }
        }
        posed[row] = bitcast<f32>(soft_plus(sum, bitcast<u32>(own.translation[row])));
    }
    return posed;
}
