// Reads operands, writes their f32 product and sum and a posed coordinate: the host compares them with
// its own to the bit, and so learns whether the adapter's arithmetic can be trusted.

struct Trial {
    row: vec4f,
    point: vec3f,
    // Whether the adapter doubts what it found.
    doubted: u32,
    found: vec3f,
}

@group(0) @binding(0) var<storage, read_write> trials: array<Trial>;

@compute @workgroup_size(GROUP)
fn probe(@builtin(global_invocation_id) id: vec3u, @builtin(workgroup_id) group: vec3u) {
    nothing = group.z;
    if id.x < arrayLength(&trials) {
        doubt = false;
        let row = trials[id.x].row;
        let columns = array<vec3f, 3>(
            vec3f(row.x, 1.0, row.x),
            vec3f(0.0, 0.0, row.y),
            vec3f(0.0, 0.0, row.z),
        );
        let rows = Rows(columns, vec3f(0.0, row.x, row.w));
        trials[id.x].found = posed_position(rows, trials[id.x].point);
        trials[id.x].doubted = u32(doubt);
    }
}
