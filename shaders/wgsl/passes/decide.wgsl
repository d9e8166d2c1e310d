// Reads triangle pairs that f32 left open, writes those that meet, decided in integers, and the rest
// for the CPU.

@compute @workgroup_size(GROUP)
fn decide(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    let length = tell(lane, min(atomicLoad(&counters.undecided), query.undecided_capacity));
    let mine = share(length, group.x, groups.x);
    for (var done = 0u; done < mine; done += GROUP) {
        clear_results(lane);
        if done + lane < mine {
            decide_in_integers(undecided[group.x + (done + lane) * groups.x]);
        }
        workgroupBarrier();
        write_results(lane);
        workgroupBarrier();
    }
}

fn decide_in_integers(slots: vec2u) {
    switch meet_on_lattice(slots) {
        case HIT: {
            add_hit(slots);
        }
        case UNSURE: {
            add_open(slots);
        }
        default: {}
    }
}

fn meet_on_lattice(slots: vec2u) -> u32 {
    let sharing = sharing_of(slots);
    let a = triangle_a(slots.x);
    let b = triangle_b(slots.y);
    // What names a vertex twice is rare, and has rules of its own.
    if (sharing.count != 0u && sharing.repeats)
        || !place_on_lattice(array<vec3f, POINTS>(a[0], a[1], a[2], b[0], b[1], b[2])) {
        return UNSURE;
    }
    let own = rotated(vec3u(0u, 1u, 2u), sharing.first.x);
    let other = rotated(vec3u(3u, 4u, 5u), sharing.first.y);
    if sharing.count == 0u {
        return exactly_meet(own, other);
    }
    if sharing.count == 1u {
        return beyond_vertex(own, other);
    }
    return beyond_edge(own, other);
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

fn rest_of(slots: vec2u) -> Rest {
    let a = triangle_a(slots.x);
    let b = triangle_b(slots.y);
    let corners = array<Corner, 6>(
        Corner(a[0], corners_a[3u * slots.x].vertex),
        Corner(a[1], corners_a[3u * slots.x + 1u].vertex),
        Corner(a[2], corners_a[3u * slots.x + 2u].vertex),
        Corner(b[0], corners_b[3u * slots.y].vertex),
        Corner(b[1], corners_b[3u * slots.y + 1u].vertex),
        Corner(b[2], corners_b[3u * slots.y + 2u].vertex),
    );
    return Rest(corners, vec2u(order_a[slots.x], order_b[slots.y]));
}
