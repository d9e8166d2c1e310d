// Reads a mesh and the order of its triangles, writes their corners in that order.

@group(0) @binding(0) var<storage, read> order: array<u32>;
@group(0) @binding(1) var<storage, read_write> corners: array<Corner>;

@compute @workgroup_size(GROUP)
fn gather(
    @builtin(global_invocation_id) own: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    // A buffer may have room for more than there is.
    let count = min(arrayLength(&order), arrayLength(&triangles) / 3u);
    for (var slot = own.x; slot < count; slot += groups.x * GROUP) {
        let triangle = order[slot];
        for (var k = 0u; k < 3u; k++) {
            let vertex = triangles[3u * triangle + k];
            corners[3u * slot + k] = Corner(position(vertex), vertex);
        }
    }
}
