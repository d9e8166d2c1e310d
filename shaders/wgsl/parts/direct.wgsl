// Triangle pairs that `narrow` writes itself: those that meet, and those that f32 leaves open, which the host decides. Where
// few are open that takes less time than another pass.

fn clear_outcomes(lane: u32) {
    clear_results(lane);
}

fn add_outcome(slots: vec2u, outcome: u32) {
    if outcome == HIT {
        add_hit(slots);
    } else {
        add_open(slots);
    }
}

// After a barrier.
fn make_room_for_outcomes(lane: u32) {
    make_room(lane);
}

fn write_outcomes(lane: u32) {
    write_results(lane);
}
