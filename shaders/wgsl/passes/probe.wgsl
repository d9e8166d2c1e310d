// Reads operands, writes their f32 product and sum and a posed coordinate: the host compares them with
// its own to the bit, and so learns whether the adapter's arithmetic can be trusted.

struct Trial {
    row: vec4f,
    point: vec3f,
    product: f32,
    sum: f32,
    coordinate: f32,
}

@group(0) @binding(0) var<storage, read_write> trials: array<Trial>;

@compute @workgroup_size(GROUP)
fn probe(@builtin(global_invocation_id) id: vec3u, @builtin(workgroup_id) group: vec3u) {
    nothing = group.z;
    if id.x < arrayLength(&trials) {
        let trial = trials[id.x];
        trials[id.x].product = times(trial.row.x, trial.point.x);
        trials[id.x].sum = plus(trial.row.x, trial.point.x);
        trials[id.x].coordinate = posed_coordinate(trial.row, trial.point);
    }
}
