// Reads leaf pairs, passes on the triangle pairs that meet, and those that are left open.
//
// Two kinds of work take turns: finding triangle pairs whose boxes overlap, and dropping those that a plane separates, or
// that f32 tells apart if they have no corner in common. Pairs wait in workgroup memory until there is one for every
// invocation.

var<workgroup> waiting: array<vec2u, WAITING>;
var<workgroup> waiting_count: atomic<u32>;

@compute @workgroup_size(GROUP)
fn narrow(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    if lane == 0u {
        atomicStore(&waiting_count, 0u);
        let held = min(atomicLoad(&counters.leaves), query.leaf_capacity);
        told = select(held, 0u, is_answered());
    }
    let length = workgroupUniformLoad(&told);
    clear_outcomes(lane);
    // An invocation takes one triangle of the first leaf against all of the second.
    let batch = max(GROUP / query.leaf_size, 1u);
    var next = group.x * batch;
    for (var round = 0u; ; round++) {
        // These rounds are shorter than those of other passes.
        if round >= 4u * MOST_ROUNDS {
            overflowed(WORK_OVERFLOW);
            break;
        }
        let ready = tell(lane, atomicLoad(&waiting_count));
        if ready < GROUP && next < length {
            let own = lane / query.leaf_size;
            if own < batch && next + own < length {
                test_boxes(leaves[next + own], lane % query.leaf_size);
            }
            next += groups.x * batch;
            workgroupBarrier();
        } else if ready > 0u {
            let taken = min(ready, GROUP);
            if lane < taken {
                test_planes(waiting[ready - taken + lane]);
            }
            workgroupBarrier();
            if lane == 0u {
                atomicStore(&waiting_count, ready - taken);
            }
            make_room_for_outcomes(lane);
        } else {
            break;
        }
    }
    write_outcomes(lane);
}

// Finds the triangles of the second leaf whose boxes overlap that of one triangle of the first.
fn test_boxes(runs: vec2u, which: u32) {
    turn_to_pair_of(runs.x);
    let run = slots_a(runs.x);
    let others = slots_of(runs.y);
    if which >= run.y {
        return;
    }
    let own = run.x + which;
    let box = box_of_placed(0u, triangle_a(own).positions);
    // Within one leaf, each unordered pair once.
    let first = select(0u, which + 1u, (query.within == 1u) & (run.x == others.x));
    let last = others.y - 1u;
    var found = 0u;
    // Four at once, whose loads do not wait for one another.
    for (var i = first; i <= last; i += 4u) {
        let p = triangle_b(others.x + i).positions;
        let q = triangle_b(others.x + min(i + 1u, last)).positions;
        let r = triangle_b(others.x + min(i + 2u, last)).positions;
        let s = triangle_b(others.x + min(i + 3u, last)).positions;
        let overlaps = vec4<bool>(
            overlap(box, box_of_placed(1u, p)),
            overlap(box, box_of_placed(1u, q)),
            overlap(box, box_of_placed(1u, r)),
            overlap(box, box_of_placed(1u, s)),
        );
        let bits = select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), overlaps);
        found |= (bits.x | bits.y | bits.z | bits.w) << i;
    }
    // Clears the bits beyond the last triangle, for which it was tested again.
    found &= (2u << last) - 1u;
    var place = atomicAdd(&waiting_count, countOneBits(found));
    while found != 0u {
        waiting[place] = vec2u(own, others.x + countTrailingZeros(found));
        place++;
        found &= found - 1u;
    }
}

// Keeps a triangle pair unless a plane of either has the other on one side, but for corners in common, and farther away than the
// distance that is asked for: cheap, the same for neighbours as for others, and the end of nearly all. The further tests that
// neighbours need would make all others wait.
fn test_planes(slots: vec2u) {
    doubt = false;
    turn_to_pair_of(slots.x);
    let own = triangle_a(slots.x);
    let other = triangle_b(slots.y);
    let a = placed(0u, own.positions);
    let b = placed(1u, other.positions);
    let shared_corners = shared_corners_of(own.vertices, other.vertices);
    let is_neighbour = any(shared_corners.a);
    var outcome = UNSURE;
    // How long the normals of planes are is not known of shadows.
    let has_planes = asked_distance() == 0.0 || all(query.error == vec3f(0.0));
    if !doubt && has_planes && (!is_neighbour || query.apart == 1u || !repeats(own.vertices, other.vertices)) {
        if is_neighbour && query.apart == 1u {
            return;
        }
        let a_sides = filtered_sides(b, a, asked_distance());
        if beyond(a_sides, shared_corners.a) {
            return;
        }
        let b_sides = filtered_sides(a, b, asked_distance());
        if beyond(b_sides, shared_corners.b) {
            return;
        }
        if !is_neighbour && asked_distance() == 0.0 {
            outcome = filtered_crossing(a, a_sides, b, b_sides);
        }
    }
    if outcome != MISS {
        add_outcome(slots, outcome);
    }
}

// How far apart triangles may be that are asked for.
fn asked_distance() -> f32 {
    return select(0.0, query.distance, CERTIFY == 1u);
}

// Whether all corners but those in common are strictly on one side.
fn beyond(sides: vec3i, shared_corners: vec3<bool>) -> bool {
    let above = all((sides > vec3i(0)) | shared_corners);
    let below = all((sides < vec3i(0)) | shared_corners);
    return above != below;
}
