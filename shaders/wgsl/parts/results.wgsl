// Triangle pairs that a workgroup has decided on, and those that it leaves to the CPU: one array filled from both ends, written
// out with one addition to a global counter for each end.

var<workgroup> results: array<vec2u, RESULTS>;
var<workgroup> sure: atomic<u32>;
var<workgroup> open: atomic<u32>;

fn clear_results(lane: u32) {
    if lane == 0u {
        atomicStore(&sure, 0u);
        atomicStore(&open, 0u);
    }
    workgroupBarrier();
}

fn add_hit(slots: vec2u) {
    turn_to_pair_of(slots.x);
    if !is_reported() {
        return;
    }
    results[atomicAdd(&sure, 1u)] = slots;
}

fn add_open(slots: vec2u) {
    results[RESULTS - 1u - atomicAdd(&open, 1u)] = slots;
}

// After a barrier.
fn write_results(lane: u32) {
    let hit = tell(lane, atomicLoad(&sure));
    if hit != 0u {
        var base = 0u;
        if lane == 0u {
            base = atomicAdd(&counters.hits, hit);
        }
        base = tell(lane, base);
        for (var i = lane; i < hit; i += GROUP) {
            let pair = named(results[i]);
            if base + i < query.hit_capacity {
                hits[base + i] = pair;
            } else {
                overflowed(HIT_OVERFLOW);
            }
        }
    }
    let left = tell(lane, atomicLoad(&open));
    if left != 0u {
        put_aside(lane, left);
    }
}

// Whether a question for one hit has its answer; the same in all invocations.
fn has_answer(lane: u32) -> bool {
    if lane == 0u {
        // A hit that this workgroup has still to write answers as well.
        told = u32(is_answered() | ((query.one_hit == 1u) & (atomicLoad(&sure) != 0u)));
    }
    return workgroupUniformLoad(&told) == 1u;
}

// Writes results out unless those of another round fit; after a barrier.
fn make_room(lane: u32) {
    if tell(lane, atomicLoad(&sure) + atomicLoad(&open)) > RESULTS - GROUP {
        write_results(lane);
        workgroupBarrier();
        clear_results(lane);
    }
}

fn put_aside(lane: u32, count: u32) {
    var base = 0u;
    if lane == 0u {
        base = atomicAdd(&counters.rest, count);
    }
    base = tell(lane, base);
    for (var i = lane; i < count; i += GROUP) {
        if base + i < query.rest_capacity {
            rest[base + i] = rest_of(results[RESULTS - 1u - i]);
        } else {
            overflowed(REST_OVERFLOW);
        }
    }
}

// Unposed: the CPU poses what the device may doubt.
fn rest_of(slots: vec2u) -> Rest {
    var all: array<Corner, POINTS>;
    for (var i = 0u; i < POINTS; i++) {
        all[i] = corner_at(slots, i);
    }
    return Rest(all, triangles_in(slots));
}

fn corner_at(slots: vec2u, member: u32) -> Corner {
    turn_to_pair_of(slots.x);
    if member < 3u {
        return corner_of(corner_a(slots.x, member));
    }
    return corner_of(corner_b(slots.y, member - 3u));
}

// The triangles in two slots; of one mesh, the lower index first.
fn named(slots: vec2u) -> vec2u {
    turn_to_pair_of(slots.x);
    let pair = triangles_in(slots);
    return select(pair, pair.yx, (query.within == 1u) & (pair.x > pair.y));
}
