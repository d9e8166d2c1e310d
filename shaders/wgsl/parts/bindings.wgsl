// Every buffer, by the name under which Rust binds it. A pass gets those that it mentions.
//
// Nodes and corners are read as whole vectors, since compilers load a vec3f and a u32 next to each other
// in two or three steps.

alias NodeWords = array<vec4u, 2>;
alias CornerWords = vec4u;

@group(0) @binding(0) var<storage, read> nodes_a: array<NodeWords>;
@group(0) @binding(1) var<storage, read> nodes_b: array<NodeWords>;
@group(0) @binding(2) var<storage, read> corners_a: array<CornerWords>;
@group(0) @binding(3) var<storage, read> corners_b: array<CornerWords>;
@group(0) @binding(4) var<storage, read> order_a: array<u32>;
@group(0) @binding(5) var<storage, read> order_b: array<u32>;
@group(0) @binding(6) var<storage, read> seeds_a: array<u32>;
@group(0) @binding(7) var<storage, read> seeds_b: array<u32>;

@group(1) @binding(0) var<uniform> query: Query;
@group(1) @binding(1) var<storage, read_write> counters: Counters;
@group(1) @binding(2) var<storage, read_write> leaves: array<vec2u>;
@group(1) @binding(3) var<storage, read_write> hits: array<vec2u>;
@group(1) @binding(4) var<storage, read_write> kept: array<vec2u>;
@group(1) @binding(5) var<storage, read_write> rest: array<Rest>;

@group(2) @binding(0) var<uniform> step: Step;
@group(2) @binding(1) var<storage, read> front_in: array<vec2u>;
@group(2) @binding(2) var<storage, read_write> front_out: array<vec2u>;
