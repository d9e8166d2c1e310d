// Boxes in the frame of the query. A posed box is padded for roundings in either direction and flushed
// subnormal numbers: it contains every posed corner (accuracy.md, with 2^-23 for the unit).

struct Box {
    min: vec3f,
    max: vec3f,
}

// 2^-124: what flushed subnormal numbers cost centre and extent, before a pose magnifies it.
const FLUSHED = 4.70197740328915e-38;

fn placed_box(side: u32, own: Box) -> Box {
    if !is_box_posed(side) {
        return own;
    }
    let centre = own.min * 0.5 + own.max * 0.5;
    let extent = own.max * 0.5 - own.min * 0.5;
    let grown = extent + (abs(centre) + extent) * PADDING + vec3f(FLUSHED);
    let middle = about(side, centre);
    let half = spread(side, grown);
    return Box(middle - half, middle + half);
}

// The box of a triangle: tighter than a placed box, and as safe.
fn box_of_placed(side: u32, t: array<vec3f, 3>) -> Box {
    if !is_box_posed(side) {
        let own = box_of(t);
        return Box(own.min - vec3f(FLUSHED), own.max + vec3f(FLUSHED));
    }
    let own = box_of(array<vec3f, 3>(about(side, t[0]), about(side, t[1]), about(side, t[2])));
    let most = max(max(abs(t[0]), abs(t[1])), abs(t[2]));
    let pad = spread(side, most * PADDING + vec3f(FLUSHED));
    return Box(own.min - pad, own.max + pad);
}

fn box_of(t: array<vec3f, 3>) -> Box {
    return Box(min(min(t[0], t[1]), t[2]), max(max(t[0], t[1]), t[2]));
}

// A posed position, however it rounds.
fn about(side: u32, p: vec3f) -> vec3f {
    let rows = box_rows(side);
    return vec3f(
        dot(rows[0].xyz, p) + rows[0].w,
        dot(rows[1].xyz, p) + rows[1].w,
        dot(rows[2].xyz, p) + rows[2].w,
    );
}

// How far a pose spreads an extent, with what its own roundings cost.
fn spread(side: u32, extent: vec3f) -> vec3f {
    let reach = box_reach(side);
    return vec3f(
        dot(reach[0].xyz, extent) + reach[0].w,
        dot(reach[1].xyz, extent) + reach[1].w,
        dot(reach[2].xyz, extent) + reach[2].w,
    );
}

fn overlap(a: Box, b: Box) -> bool {
    return all(a.min <= b.max) && all(b.min <= a.max);
}
