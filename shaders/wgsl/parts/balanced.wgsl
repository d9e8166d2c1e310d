// The shape of a balanced tree, from the number of its triangles alone: 2^depth leaves, whose triangles
// differ by one at most.
//
// Node i of a level of 2^level is 2^level + i, but for the root, which is 0; so the children of node
// h are 2h and 2h + 1, as in a heap, and node 1 is unused.

// Parameters of a dispatch of a build.
struct Build {
    triangles: u32,
    // Level of the leaves.
    depth: u32,
    // The levels it is about, lowest and highest in the tree.
    bottom: u32,
    top: u32,
    // Entries that a workgroup sorts, and how many workgroups do.
    run: u32,
    workgroups: u32,
    // Lowest bit of the digit that entries are sorted by.
    shift: u32,
}

@group(1) @binding(0) var<uniform> build: Build;

// Where leaf j begins. The first leaves have the triangles that are left over.
fn leaf_start(leaf: u32) -> u32 {
    let left_over = build.triangles & ((1u << build.depth) - 1u);
    return leaf * (build.triangles >> build.depth) + min(leaf, left_over);
}

// Where node i of a level begins.
fn node_start(level: u32, i: u32) -> u32 {
    return leaf_start(i << (build.depth - level));
}

// The node of a level that holds a place in leaf order.
fn node_at(level: u32, place: u32) -> u32 {
    let least = build.triangles >> build.depth;
    let left_over = build.triangles & ((1u << build.depth) - 1u);
    let larger = left_over * (least + 1u);
    var leaf = place / (least + 1u);
    if place >= larger {
        leaf = left_over + (place - larger) / least;
    }
    return leaf >> (build.depth - level);
}
