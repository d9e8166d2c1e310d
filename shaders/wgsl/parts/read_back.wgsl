// The results as the host reads them: as many hits, and as many triangle pairs for the CPU, as there is room for. Written by the
// last pass of a run, into memory that the host maps where the adapter can.

struct ReadBack {
    counters: Counters,
    // What a device tells about the positions of each mesh that the host has not seen.
    outside_a: u32,
    outside_b: u32,
    // By vectors of words, so that invocations next to each other write memory next to each other.
    rest: array<vec4u>,
}

@group(2) @binding(0) var<storage, read_write> read_back: ReadBack;
@group(2) @binding(1) var<storage, read_write> read_back_hits: array<vec2u>;

// Writes everything but hits, and has the counters at 0 for the next run. All workgroups call it, in uniform control flow, once
// they have read the counters.
fn write_read_back(lane: u32, group: u32, groups: u32, in_order: bool) {
    if group == 0u {
        if lane < FRONTS {
            atomicStore(&read_back.counters.fronts[lane], atomicLoad(&counters.fronts[lane]));
        }
        if lane == 0u {
            write_counters(in_order);
        }
    }
    if lane == 0u {
        told = min(atomicLoad(&counters.rest), query.rest_capacity);
    }
    let words = min(workgroupUniformLoad(&told) * REST_WORDS, arrayLength(&read_back.rest));
    if lane == 0u && atomicAdd(&counters.readers, 1u) == groups - 1u {
        clear_counters();
    }
    for (var i = group * GROUP + lane; i < words; i += groups * GROUP) {
        read_back.rest[i] = rest[i];
    }
}

fn write_counters(in_order: bool) {
    let hits = atomicLoad(&counters.hits);
    let overflow = atomicLoad(&counters.overflow);
    let rest = atomicLoad(&counters.rest);
    read_back.counters.ticket = query.ticket;
    atomicStore(&read_back.counters.leaves, atomicLoad(&counters.leaves));
    atomicStore(&read_back.counters.hits, hits);
    atomicStore(&read_back.counters.overflow, overflow);
    atomicStore(&read_back.counters.kept, atomicLoad(&counters.kept));
    atomicStore(&read_back.counters.open, atomicLoad(&counters.open));
    atomicStore(&read_back.counters.rest, rest);
    atomicStore(&read_back.counters.unordered, select(1u, 0u, in_order));
    atomicStore(&read_back.counters.node_pairs, atomicLoad(&counters.node_pairs));
    counters.last_hits = hits;
    counters.last_overflow = overflow;
    counters.last_rest = rest;
}

// By one invocation, once all workgroups have read them.
fn clear_counters() {
    atomicStore(&counters.leaves, 0u);
    atomicStore(&counters.hits, 0u);
    atomicStore(&counters.overflow, 0u);
    atomicStore(&counters.kept, 0u);
    atomicStore(&counters.open, 0u);
    atomicStore(&counters.rest, 0u);
    atomicStore(&counters.node_pairs, 0u);
    for (var i = 0u; i < FRONTS; i++) {
        atomicStore(&counters.fronts[i], 0u);
    }
    atomicStore(&counters.readers, 0u);
}

// Puts a hit in its place, on the device and for the host.
fn put_hit(place: u32, hit: vec2u) {
    sorted[place] = hit;
    if place < arrayLength(&read_back_hits) {
        read_back_hits[place] = hit;
    }
}

// Puts all hits as they are. All workgroups call it.
fn put_unordered(lane: u32, group: u32, groups: u32, count: u32) {
    for (var i = group * GROUP + lane; i < count; i += groups * GROUP) {
        put_hit(i, hits[i]);
    }
}
