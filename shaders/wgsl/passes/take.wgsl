// Reads vertices from a buffer of the caller's, writes their positions one after the other, and tells which is not in the box that
// the caller promised. Coordinates stay bits: their order is that of whole numbers, beyond which lies all that is not finite.

@group(0) @binding(0) var<storage, read> given: array<u32>;
@group(0) @binding(1) var<storage, read_write> taken: array<u32>;
// The number of vertices less that of the first one outside; 0 if there is none.
@group(0) @binding(2) var<storage, read_write> outside: atomic<u32>;
@group(1) @binding(0) var<uniform> taking: Taking;

@compute @workgroup_size(GROUP)
fn take(
    @builtin(global_invocation_id) own: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    for (var vertex = own.x; vertex < taking.vertices; vertex += groups.x * GROUP) {
        let at = taking.first + vertex * taking.stride;
        var bits = vec3u(given[at], given[at + 1u], given[at + 2u]);
        let place = in_order(bits);
        if any(place < taking.low) || any(place > taking.high) {
            atomicMax(&outside, taking.vertices - vertex);
            // Nobody hears an answer about it, and the passes of the query come to an end.
            bits = vec3u(0u);
        }
        for (var axis = 0u; axis < 3u; axis++) {
            taken[3u * vertex + axis] = bits[axis];
        }
    }
}

// Whole numbers in the order of the f32 of these bits.
fn in_order(bits: vec3u) -> vec3i {
    let signed = bitcast<vec3i>(bits);
    return select(signed, signed ^ vec3i(0x7fffffff), signed < vec3i(0));
}
