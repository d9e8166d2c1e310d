// The posed position of a vertex, to the bit: ((r0·x + r1·y) + r2·z) + t, each operation rounded to
// nearest, none fused. Compilers contract and reassociate, so every result passes through an xor with a
// zero that they cannot know. Where the adapter rounds otherwise or flushes subnormal numbers, which
// `probe` finds out, integers do it.

override SOFT: bool = false;

// Zero: dispatches are flat in z.
var<private> nothing: u32;

fn opaque(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ nothing);
}

fn times(x: f32, y: f32) -> f32 {
    if SOFT {
        return bitcast<f32>(soft_times(bitcast<u32>(x), bitcast<u32>(y)));
    }
    return opaque(x * y);
}

fn plus(x: f32, y: f32) -> f32 {
    if SOFT {
        return bitcast<f32>(soft_plus(bitcast<u32>(x), bitcast<u32>(y)));
    }
    return opaque(x + y);
}

fn posed_coordinate(row: vec4f, p: vec3f) -> f32 {
    return plus(plus(plus(times(row.x, p.x), times(row.y, p.y)), times(row.z, p.z)), row.w);
}
