// Whether the triangles in two slots meet, as far as f32 tells.
fn outcome_in_f32(slots: vec2u) -> u32 {
    doubt = false;
    turn_to_pair_of(slots.x);
    let own = triangle_a(slots.x);
    let other = triangle_b(slots.y);
    let a = placed(0u, own.positions);
    let b = placed(1u, other.positions);
    let sharing = sharing_of(own.vertices, other.vertices);
    var outcome = UNSURE;
    if sharing.count == 0u {
        outcome = filtered_meet(a, b);
    } else if !sharing.repeats {
        outcome = filtered_neighbours(
            sharing.count,
            turned_to(a, sharing.first.x),
            turned_to(b, sharing.first.y),
        );
    }
    return select(outcome, UNSURE, doubt);
}
