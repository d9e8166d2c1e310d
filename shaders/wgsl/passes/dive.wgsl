// Reads a front, writes triangle pairs that answer for their pair of instances, and the front and leaf pairs that are
// left over: looks for one hit of each, depth-first, a workgroup for each node pair.
//
// A breadth-first descent would do all the box tests of a pair of bodies that meet, and this does about as many
// as one thread. Once it has found a hit it drops the rest. Pairs that f32 leaves open are left to `decide`, which
// also writes the hits; a workgroup that has found many of these, or has taken long, hands its stack on.

// Triangle pairs whose boxes overlap.
var<workgroup> waiting: array<vec2u, 2 * GROUP>;
var<workgroup> waiting_count: atomic<u32>;
// Triangle pairs that meet, and those that f32 leaves open.
var<workgroup> met: atomic<u32>;
var<workgroup> unsure: atomic<u32>;

@compute @workgroup_size(GROUP)
fn dive(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    if lane == 0u {
        told = min(atomicLoad(&counters.fronts[0]), query.front_capacity);
    }
    let length = workgroupUniformLoad(&told);
    var rounds = 0u;
    for (var at = group.x; at < length; at += groups.x) {
        clear_queues(lane);
        if lane == 0u {
            queue[0] = front_in[at];
            atomicStore(&queued[0], 1u);
            atomicStore(&waiting_count, 0u);
            atomicStore(&met, 0u);
            atomicStore(&unsure, 0u);
        }
        workgroupBarrier();
        rounds = look_for_hit(lane, rounds);
        hand_on(lane, 0u, 2u * QUEUE);
        write_leaf_pairs(lane);
        workgroupBarrier();
    }
}

// Takes and returns how many rounds the workgroup has done.
fn look_for_hit(lane: u32, before: u32) -> u32 {
    var rounds = before;
    let last = min(before + DIVE, MOST_ROUNDS);
    let tests = query.leaf_size * query.leaf_size;
    let batch = max(GROUP / tests, 1u);
    loop {
        let size = tell(lane, min(atomicLoad(&queued[0]), 2u * QUEUE));
        let leaf_pairs = tell(lane, min(atomicLoad(&found_count), FOUND));
        let ready = tell(lane, atomicLoad(&waiting_count));
        if rounds >= last && ready == 0u {
            break;
        }
        rounds++;
        if ready >= GROUP || (ready > 0u && (rounds >= last || size + leaf_pairs == 0u)) {
            let taken = min(ready, GROUP);
            if lane < taken {
                try_pair(waiting[ready - taken + lane]);
            }
            workgroupBarrier();
            if lane == 0u {
                atomicStore(&waiting_count, ready - taken);
            }
            let is_met = tell(lane, atomicLoad(&met)) != 0u;
            if is_met && lane == 0u {
                atomicStore(&queued[0], 0u);
                atomicStore(&found_count, 0u);
            }
            if is_met || tell(lane, atomicLoad(&unsure)) >= GROUP {
                // Waiting node pairs are dropped only where nothing more is wanted.
                if !is_met && lane < ready - taken {
                    keep(waiting[lane]);
                }
                workgroupBarrier();
                break;
            }
        } else if leaf_pairs >= batch || (leaf_pairs != 0u && size == 0u) {
            let taken = min(leaf_pairs, batch);
            let own = lane / tests;
            if own < taken {
                test_boxes(found[leaf_pairs - taken + own], lane % tests);
            }
            workgroupBarrier();
            if lane == 0u {
                atomicStore(&found_count, leaf_pairs - taken);
            }
            workgroupBarrier();
        } else if size != 0u {
            visit_top(lane, size, GROUP / 4u);
        } else {
            break;
        }
    }
    return rounds;
}

// Tests the boxes of one of the triangles of two leaves each.
fn test_boxes(runs: vec2u, which: u32) {
    turn_to_pair_of(runs.x);
    let own = slots_a(runs.x);
    let other = slots_of(runs.y);
    let i = which / query.leaf_size;
    let j = which % query.leaf_size;
    if i >= own.y || j >= other.y {
        return;
    }
    let slots = vec2u(own.x + i, other.x + j);
    let box = box_of_placed(0u, triangle_a(slots.x).positions);
    if overlap(box, box_of_placed(1u, triangle_b(slots.y).positions)) {
        waiting[atomicAdd(&waiting_count, 1u)] = slots;
    }
}

fn try_pair(slots: vec2u) {
    let outcome = outcome_in_f32(slots);
    if outcome == UNSURE {
        atomicAdd(&unsure, 1u);
        keep(slots);
    }
    if outcome == HIT && atomicAdd(&met, 1u) == 0u {
        keep(slots | vec2u(0u, CERTIFIED));
    }
}

fn keep(slots: vec2u) {
    let slot = atomicAdd(&counters.kept, 1u);
    if slot < query.kept_capacity {
        kept[slot] = slots;
    } else {
        overflowed(KEPT_OVERFLOW);
    }
}
