// Reads triangles and how to divide the nodes of a level, writes the key of each triangle and counts of its
// first digit: its node, then where it lies across the cut.
//
// Sorted by these keys, the triangles of a node stay together, and the first of them are on one side.

@compute @workgroup_size(GROUP)
fn keys(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    clear_counts(lane);
    let run = run_of(group.x);
    for (var i = run.x + lane; i < run.y; i += GROUP) {
        // At the root any order will do.
        var triangle = i;
        if build.top != 0u {
            triangle = entries_out[i].y;
        }
        let node = node_at(build.top, i);
        let cut = cuts[node];
        let own = half_box(triangle);
        let centre = own.min * 0.5 + own.max * 0.5;
        let across = cell(vec3f(centre[cut.axis]), vec3f(cut.low), cut.cells, CUT_BITS).x;
        let key = (node << CUT_BITS) | across;
        entries_out[i] = vec2u(key, triangle);
        count_digit(key);
    }
    write_counts(lane, group.x);
}
