// Reads positions, writes the corners of triangles and the nodes of some levels of a balanced tree.
//
// A job is the part of these levels below one node of the highest. A workgroup does it level by level, and
// neighbouring invocations read and write neighbouring nodes. A box is kept in the slot of its leftmost
// descendant on the lowest level: it takes the place of its left child, which nothing else reads.

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
                fit_node(level, job * width + i, above, i << above);
            }
            workgroupBarrier();
        }
    }
}

// Fits node i of a level, so many levels above the lowest of the job, and keeps its box in a slot.
fn fit_node(level: u32, i: u32, above: u32, slot: u32) {
    let heap = (1u << level) + i;
    var box: Extent;
    var first = 2u * heap;
    var count = 0u;
    if level == build.depth {
        first = leaf_start(i);
        count = leaf_start(i + 1u) - first;
        box = leaf_box(first, count);
    } else if above == 0u {
        box = around(earlier_box(first), earlier_box(first + 1u));
    } else {
        box = around(kept_box(slot), kept_box(slot + (1u << (above - 1u))));
    }
    keep(slot, box);
    write_node(select(heap, 0u, level == 0u), box, first, count);
}
