// Boxes in the frame of the query. A posed box is padded for roundings in either direction and flushed
// subnormal numbers: it contains every posed corner (accuracy.md, with 2^-23 for the unit).

struct Box {
    min: vec3f,
    max: vec3f,
}

// 16 · 2^-23.
const PADDING = 1.9073486328125e-6;
// 2^-124: what flushed subnormal numbers cost centre and extent, before a pose magnifies it.
const FLUSHED = 4.70197740328915e-38;

fn placed_box(side: u32, own: Box) -> Box {
    let rows = query.sides[side].rows;
    let reach = query.sides[side].reach;
    let centre = own.min * 0.5 + own.max * 0.5;
    let extent = own.max * 0.5 - own.min * 0.5;
    let grown = extent + (abs(centre) + extent) * PADDING + vec3f(FLUSHED);
    let middle = vec3f(
        dot(rows[0].xyz, centre) + rows[0].w,
        dot(rows[1].xyz, centre) + rows[1].w,
        dot(rows[2].xyz, centre) + rows[2].w,
    );
    let half = vec3f(
        dot(reach[0].xyz, grown) + reach[0].w,
        dot(reach[1].xyz, grown) + reach[1].w,
        dot(reach[2].xyz, grown) + reach[2].w,
    );
    let posed = query.posed[side] != 0u;
    return Box(select(own.min, middle - half, posed), select(own.max, middle + half, posed));
}

fn overlap(a: Box, b: Box) -> bool {
    return all(a.min <= b.max) && all(b.min <= a.max);
}
