// The sides of a query about many pairs of instances: bodies that share meshes, posed on the fly. The meshes
// lie in shared arrays. `meshes` has the same functions for two meshes.
//
// Nodes, slots and triangles of the first side are virtual: every pair of bodies has a run of ids of its own, in
// whose order that of the hits is right. A run takes whole blocks of 2^`query.pair_shift` ids, and each
// block has the row of its pair, so that finding it takes a shift and no search. Nodes and slots of the second side
// are those of the arrays, and its triangles are numbered within their mesh.

@group(1) @binding(0) var<storage, read> nodes_a: array<NodeWords>;
@group(1) @binding(1) var<storage, read> corners_a: array<CornerWords>;
@group(1) @binding(2) var<storage, read> order_a: array<u32>;
@group(1) @binding(3) var<storage, read> pairs: array<InstancePair>;

// The row of the present pair.
var<private> row: u32;

// Turns to the pair of bodies to which a node, slot or triangle of the first side belongs.
fn turn_to_pair_of(id: u32) {
    row = id >> query.pair_shift;
}

fn node_a(index: u32) -> Node {
    var node = node_of(nodes_a[index - pairs[row].first_id + pairs[row].first_node]);
    if node.count == 0u {
        node.first += pairs[row].first_id - pairs[row].first_node;
    }
    return node;
}

fn node_b(index: u32) -> Node {
    return node_of(nodes_a[index]);
}

// Leaf pairs hold the node: no bits are left for a number of triangles.
fn run_a(index: u32, node: Node) -> u32 {
    return index;
}

fn slots_a(run: u32) -> vec2u {
    let node = node_a(run);
    return vec2u(node.first + pairs[row].first_id - pairs[row].first_slot, node.count);
}

fn corner_a(slot: u32, which: u32) -> CornerWords {
    return corners_a[3u * (slot - pairs[row].first_id + pairs[row].first_slot) + which];
}

fn corner_b(slot: u32, which: u32) -> CornerWords {
    return corners_a[3u * slot + which];
}

fn triangles_in(slots: vec2u) -> vec2u {
    let start = pairs[row].first_id;
    return vec2u(order_a[slots.x - start + pairs[row].first_slot] + start, order_a[slots.y]);
}

fn is_posed(side: u32) -> bool {
    return true;
}

fn pose_rows(side: u32) -> array<vec4f, 3> {
    return pairs[row].poses[side];
}

// They are compared in the frame of the first body where its pose can be inverted, else in the world.
fn is_box_posed(side: u32) -> bool {
    return ((pairs[row].posed_boxes >> side) & 1u) != 0u;
}

fn box_rows(side: u32) -> array<vec4f, 3> {
    if side == 0u {
        return pairs[row].poses[0];
    }
    return pairs[row].boxes;
}

fn box_reach(side: u32) -> array<vec4f, 3> {
    let rows = box_rows(side);
    let pad = select(pairs[row].pad_b, pairs[row].pad_a, side == 0u);
    return array<vec4f, 3>(
        vec4f(abs(rows[0].xyz), pad.x),
        vec4f(abs(rows[1].xyz), pad.y),
        vec4f(abs(rows[2].xyz), pad.z),
    );
}
