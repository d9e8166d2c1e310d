// Reads leaf pairs, writes triangle pairs that meet, and those that f32 cannot decide.

var<workgroup> candidates: array<vec2u, RESULTS>;
var<workgroup> candidate_count: atomic<u32>;

@compute @workgroup_size(GROUP)
fn narrow(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    let length = tell(lane, min(atomicLoad(&counters.leaves), query.leaf_capacity));
    let mine = share(length, group.x, groups.x);
    for (var done = 0u; done < mine; done += LEAF_PAIRS) {
        if lane == 0u {
            atomicStore(&candidate_count, 0u);
        }
        clear_results(lane);
        let own = done + lane / LANES;
        if own < mine {
            test_boxes(leaves[group.x + own * groups.x], lane % LANES);
        }
        workgroupBarrier();
        let count = tell(lane, atomicLoad(&candidate_count));
        for (var i = lane; i < count; i += GROUP) {
            decide_in_f32(candidates[i]);
        }
        workgroupBarrier();
        write_results(lane);
        workgroupBarrier();
    }
}

// Finds the triangle pairs of a leaf pair whose boxes overlap; LANES invocations share them.
fn test_boxes(runs: vec2u, first: u32) {
    let slots = runs & vec2u((1u << LEAF_SHIFT) - 1u);
    let counts = (runs >> vec2u(LEAF_SHIFT)) + vec2u(1u);
    for (var i = first; i < counts.x * counts.y; i += LANES) {
        let pair = slots + vec2u(i % counts.x, i / counts.x);
        // Within one leaf, each unordered pair once.
        let again = (query.within == 1u) & (slots.x == slots.y) & (pair.x >= pair.y);
        if !again && overlap(box_of(triangle_a(pair.x)), grown(box_of(triangle_b(pair.y)))) {
            candidates[atomicAdd(&candidate_count, 1u)] = pair;
        }
    }
}

fn box_of(t: array<vec3f, 3>) -> Box {
    return Box(min(min(t[0], t[1]), t[2]), max(max(t[0], t[1]), t[2]));
}

// By what minima and maxima may lose where subnormal numbers are flushed.
fn grown(box: Box) -> Box {
    return Box(box.min - vec3f(FLUSHED), box.max + vec3f(FLUSHED));
}

fn decide_in_f32(slots: vec2u) {
    let a = triangle_a(slots.x);
    let b = triangle_b(slots.y);
    let sharing = sharing_of(slots);
    var outcome = UNSURE;
    if sharing.count == 0u {
        outcome = filtered_meet(a, b);
    } else if query.apart == 1u {
        outcome = MISS;
    } else if !sharing.repeats {
        let own = turned_to(a, sharing.first.x);
        let other = turned_to(b, sharing.first.y);
        outcome = filtered_neighbours(sharing.count, own, other);
    }
    switch outcome {
        case HIT: {
            add_hit(slots);
        }
        case UNSURE: {
            add_open(slots);
        }
        default: {}
    }
}

fn put_aside(lane: u32, count: u32) {
    var base = 0u;
    if lane == 0u {
        base = atomicAdd(&counters.undecided, count);
    }
    base = tell(lane, base);
    for (var i = lane; i < count; i += GROUP) {
        if base + i < query.undecided_capacity {
            undecided[base + i] = results[RESULTS - 1u - i];
        } else {
            overflowed(UNDECIDED_OVERFLOW);
        }
    }
}
