// Reads positions, writes the corners of triangles and the nodes of some levels of a balanced tree.
//
// A job is the part of these levels below one node of the highest. A workgroup does it level by level, and
// neighbouring invocations read and write neighbouring nodes.

@compute @workgroup_size(GROUP)
fn fit(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    for (var job = group.x; job < (1u << build.top); job += groups.x) {
        for (var above = 0u; above <= build.bottom - build.top; above++) {
            let level = build.bottom - above;
            let width = 1u << (level - build.top);
            for (var i = lane; i < width; i += GROUP) {
                fit_node(level, job * width + i);
            }
            storageBarrier();
        }
    }
}

fn fit_node(level: u32, i: u32) {
    let heap = (1u << level) + i;
    var node: Node;
    if level == build.depth {
        let first = leaf_start(i);
        node = fitted_leaf(first, leaf_start(i + 1u) - first);
    } else {
        node = fitted_inner(2u * heap);
    }
    nodes[select(heap, 0u, level == 0u)] = node;
}
