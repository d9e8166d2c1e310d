// The structs that Rust shares. A test compares size and offsets by reflection.

struct Node {
    min: vec3f,
    // Leaf: its first slot in leaf order. Inner: its left child; the right one is next to it.
    first: u32,
    max: vec3f,
    // Leaf: how many triangles it holds. Inner: 0.
    count: u32,
}

// Three of them make a triangle. Triangles lie in leaf order: a leaf is one run of memory.
struct Corner {
    position: vec3f,
    vertex: u32,
}

// How one side stands in the frame of the query.
struct Placement {
    rows: array<vec4f, 3>,
    // |rows| for boxes, and in w what the translation and underflow may cost.
    reach: array<vec4f, 3>,
}

struct Query {
    sides: array<Placement, 2>,
    // Whether each side is posed at all.
    posed: vec2u,
    seeds: vec2u,
    front_capacity: u32,
    leaf_capacity: u32,
    hit_capacity: u32,
    kept_capacity: u32,
    rest_capacity: u32,
    // The most triangles of a leaf of the first mesh.
    leaf_size: u32,
    // 1 for one mesh against itself.
    within: u32,
    // 1 if triangles that share a vertex are left out.
    apart: u32,
    // How many levels a pass descends, but for the last, which goes to the bottom.
    levels: u32,
    last_pass: u32,
    // 1 if one hit is enough: once there is one, what is left of the work is dropped.
    one_hit: u32,
    // Node pairs that a workgroup follows on each level, the others being dropped; and how many node pairs and
    // leaf pairs suffice for a pass. BEAM in a run that only looks for a hit, else all.
    beam: u32,
    // Bits of an id within a block of ids, each of which is of one pair of instances.
    pair_shift: u32,
    // 0, or ANY_EACH or COUNT_EACH for a question about each pair of instances.
    each: u32,
    // 1 if the host decides what f32 leaves open: about shadows of meshes in f64, and within a distance.
    certify: u32,
    // Between shadows, how far the difference of two coordinates may be from that of what they stand for; else 0.
    error: vec3f,
    // Triangles that are at most so far apart are asked for, if this is not 0, in place of those that meet.
    distance: f32,
    // Number of the host's question, to recognise the answer.
    ticket: u32,
}

// A pair of instances.
struct InstancePair {
    // The second body, seen from the frame in which boxes are compared.
    boxes: array<vec4f, 3>,
    // The padding of boxes of each side beside PADDING; bit i of `posed_boxes`: boxes of side i are posed.
    pad_a: vec3f,
    posed_boxes: u32,
    pad_b: vec3f,
    // Number of the pair.
    number: u32,
    // Where its run of ids begins, and the nodes and slots of the first mesh.
    first_id: u32,
    first_node: u32,
    first_slot: u32,
    // Poses in the world.
    poses: array<array<vec4f, 3>, 2>,
}

// Where vertices are in a buffer of the caller's, by words, and the box that holds them, in whole numbers that are in the order of f32.
struct Taking {
    low: vec3i,
    vertices: u32,
    high: vec3i,
    // From one vertex to the next.
    stride: u32,
    first: u32,
}

struct Step {
    // Index of this pass, and of the front it reads.
    pass_index: u32,
    // 1 if leaf pairs stay in the front.
    keep_leaves: u32,
}

// Demands, not contents: they count on beyond what a list can hold.
struct Counters {
    // The same of the last run, for consumers on the device.
    last_hits: u32,
    last_overflow: u32,
    last_rest: u32,
    // The host reads these of its question here.
    ticket: u32,
    // A run that looks for one hit leaves these two to the next.
    leaves: atomic<u32>,
    hits: atomic<u32>,
    overflow: atomic<u32>,
    // Triangle pairs that are left after the first tests, and those of them that f32 leaves open.
    kept: atomic<u32>,
    open: atomic<u32>,
    rest: atomic<u32>,
    // For the host, not 0 if there were too many hits to put them in order.
    unordered: atomic<u32>,
    // Node pairs whose children were tested.
    node_pairs: atomic<u32>,
    fronts: array<atomic<u32>, FRONTS>,
    // Workgroups of the last pass that have read all these. The last has them at 0 again, for the next run.
    readers: atomic<u32>,
}

// A triangle pair for the CPU: everything its predicates need.
struct Rest {
    corners: array<Corner, 6>,
    pair: vec2u,
}
