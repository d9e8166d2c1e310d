// Minima and maxima of f32 in integers, exact where an adapter flushes subnormal numbers.

// Ordered as the number is; both zeros are 0.
fn ordered(v: vec3f) -> vec3i {
    let bits = bitcast<vec3u>(v);
    let size = vec3i(bits & vec3u(0x7fffffffu));
    return select(size, -size, bits != vec3u(size));
}

fn unordered(v: vec3i) -> vec3f {
    return bitcast<vec3f>(select(vec3u(v), vec3u(-v) | vec3u(0x80000000u), v < vec3i(0)));
}
