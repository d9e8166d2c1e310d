// The sides of a query about two meshes, or about one with itself. `instances` has the same functions for
// many pairs of posed bodies.

@group(1) @binding(0) var<storage, read> nodes_a: array<NodeWords>;
@group(1) @binding(1) var<storage, read> nodes_b: array<NodeWords>;
@group(1) @binding(2) var<storage, read> corners_a: array<CornerWords>;
@group(1) @binding(3) var<storage, read> corners_b: array<CornerWords>;
@group(1) @binding(4) var<storage, read> order_a: array<u32>;
@group(1) @binding(5) var<storage, read> order_b: array<u32>;
@group(1) @binding(6) var<storage, read> seeds_a: array<u32>;
@group(1) @binding(7) var<storage, read> seeds_b: array<u32>;

// Turns to the pair of bodies to which a node, slot or triangle of the first side belongs: there is one.
fn turn_to_pair_of(id: u32) {}

fn node_a(index: u32) -> Node {
    return node_of(nodes_a[index]);
}

fn node_b(index: u32) -> Node {
    return node_of(nodes_b[index]);
}

// A leaf of the first side as lists of leaf pairs hold it, and back.
fn run_a(index: u32, node: Node) -> u32 {
    return leaf_run(node);
}

fn slots_a(run: u32) -> vec2u {
    return slots_of(run);
}

fn corner_a(slot: u32, which: u32) -> CornerWords {
    return corners_a[3u * slot + which];
}

fn corner_b(slot: u32, which: u32) -> CornerWords {
    return corners_b[3u * slot + which];
}

// The triangles in two slots.
fn triangles_in(slots: vec2u) -> vec2u {
    return vec2u(order_a[slots.x], order_b[slots.y]);
}

fn is_posed(side: u32) -> bool {
    return (query.posed[side] ^ nothing) != 0u;
}

fn pose_rows(side: u32) -> array<vec4f, 3> {
    return query.sides[side].rows;
}

// Boxes are compared in the frame in which triangles are.
fn is_box_posed(side: u32) -> bool {
    return is_posed(side);
}

fn box_rows(side: u32) -> array<vec4f, 3> {
    return query.sides[side].rows;
}

fn box_reach(side: u32) -> array<vec4f, 3> {
    return query.sides[side].reach;
}
