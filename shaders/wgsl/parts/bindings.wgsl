// The lists of a query, by the names under which Rust binds them. A pass gets those that it mentions.
//
// Nodes and corners are read as whole vectors, since compilers load a vec3f and a u32 next to each other
// in two or three steps.

alias NodeWords = array<vec4u, 2>;
alias CornerWords = vec4u;

@group(0) @binding(0) var<uniform> query: Query;

@group(2) @binding(0) var<storage, read_write> counters: Counters;
@group(2) @binding(1) var<storage, read_write> leaves: array<vec2u>;
@group(2) @binding(2) var<storage, read_write> hits: array<vec2u>;
@group(2) @binding(3) var<storage, read_write> kept: array<vec2u>;
@group(2) @binding(4) var<storage, read_write> rest: array<Rest>;

@group(3) @binding(0) var<uniform> step: Step;
@group(3) @binding(1) var<storage, read> front_in: array<vec2u>;
@group(3) @binding(2) var<storage, read_write> front_out: array<vec2u>;

// A test compares which words become which fields with the layout of Node.
fn node_of(words: NodeWords) -> Node {
    return Node(
        bitcast<vec3f>(words[0].xyz),
        words[0].w,
        bitcast<vec3f>(words[1].xyz),
        words[1].w,
    );
}

// A leaf as the narrow phase wants it: its triangles. The host sees to it that slots stay below
// 2^LEAF_SHIFT.
fn leaf_run(node: Node) -> u32 {
    return node.first | ((node.count - 1u) << LEAF_SHIFT);
}

// The first slot of a leaf, and how many triangles it has.
fn slots_of(run: u32) -> vec2u {
    return vec2u(run & ((1u << LEAF_SHIFT) - 1u), (run >> LEAF_SHIFT) + 1u);
}

// Whether one hit is enough and there is one. No branch on a uniform alone (see `nothing`).
//
// For the first invocation of a workgroup to ask, and so are all counters of a run: what thousands of invocations load from
// one word of global memory, they load one after the other.
fn is_answered() -> bool {
    return ((query.one_hit ^ nothing) == 1u) && atomicLoad(&counters.hits) != 0u;
}
