// Triangle pairs that `narrow` passes on to `decide`, with a mark on those that f32 has proved to meet.

var<workgroup> stay: array<vec2u, STAY>;
var<workgroup> stay_count: atomic<u32>;

fn clear_outcomes(lane: u32) {
    if lane == 0u {
        atomicStore(&stay_count, 0u);
    }
    workgroupBarrier();
}

fn add_outcome(slots: vec2u, outcome: u32) {
    stay[atomicAdd(&stay_count, 1u)] = slots | vec2u(0u, select(0u, CERTIFIED, outcome == HIT));
}

// After a barrier.
fn make_room_for_outcomes(lane: u32) {
    write_staying(lane, STAY - GROUP);
}

fn write_outcomes(lane: u32) {
    write_staying(lane, 0u);
}

// Writes what stays if it is more than this; after a barrier.
fn write_staying(lane: u32, most: u32) {
    let count = tell(lane, atomicLoad(&stay_count));
    if count <= most {
        return;
    }
    var base = 0u;
    if lane == 0u {
        base = atomicAdd(&counters.kept, count);
        atomicStore(&stay_count, 0u);
    }
    base = tell(lane, base);
    for (var i = lane; i < count; i += GROUP) {
        if base + i < query.kept_capacity {
            kept[base + i] = stay[i];
        } else {
            overflowed(KEPT_OVERFLOW);
        }
    }
    workgroupBarrier();
}
