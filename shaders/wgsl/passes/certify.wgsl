// Reads the triangle pairs that are left, writes those of which f32 is sure that they meet, or are within the distance, and those
// of which it is not sure, for the host to decide.

@compute @workgroup_size(GROUP)
fn certify(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    clear_results(lane);
    if lane == 0u {
        told = min(atomicLoad(&counters.kept), query.kept_capacity);
    }
    let length = workgroupUniformLoad(&told);
    let mine = share(length, group.x, groups.x);
    var rounds = 0u;
    for (var done = 0u; done < mine; done += GROUP) {
        if rounds >= MOST_ROUNDS {
            overflowed(WORK_OVERFLOW);
            break;
        }
        rounds++;
        if has_answer(lane) {
            break;
        }
        if done + lane < mine {
            settle_pair(kept[group.x + (done + lane) * groups.x]);
        }
        workgroupBarrier();
        make_room(lane);
    }
    write_results(lane);
}

fn settle_pair(found: vec2u) {
    let slots = found & vec2u(~0u, ~CERTIFIED);
    var outcome = HIT;
    if (found.y & CERTIFIED) == 0u {
        outcome = outcome_within(slots);
    }
    if outcome == UNSURE {
        add_open(slots);
    } else if outcome == HIT {
        add_hit(slots);
    }
}

fn outcome_within(slots: vec2u) -> u32 {
    let meet = outcome_in_f32(slots);
    if query.distance == 0.0 || meet == HIT {
        return meet;
    }
    doubt = false;
    let a = placed(0u, triangle_a(slots.x).positions);
    let b = placed(1u, triangle_b(slots.y).positions);
    let outcome = outcome_of_distance(a, b);
    return select(outcome, UNSURE, doubt);
}
