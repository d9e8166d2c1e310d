// Reads bodies and a row for each block of ids, writes how the boxes of the two bodies of each row are compared, and all else that
// the other passes have to know of them. `placing.rs` says why it is padded by so much.

struct Body {
    pose: array<vec4f, 3>,
    // The inverse of the first three columns, and in w a bound on the error of its entries.
    inverse: array<vec4f, 3>,
    // The farthest that posed corners get from the origin.
    reach: vec3f,
    // What flushed subnormal numbers cost a box.
    flushed: f32,
    // Some of POSED, IN_RANGE and INVERTIBLE.
    kind: u32,
    first_node: u32,
    first_slot: u32,
}

struct Row {
    bodies: vec2u,
    // Number of the pair.
    number: u32,
    first_id: u32,
}

@group(0) @binding(0) var<storage, read> bodies: array<Body>;
@group(0) @binding(1) var<storage, read> rows: array<Row>;
@group(0) @binding(2) var<storage, read_write> pairs: array<InstancePair>;

@compute @workgroup_size(GROUP)
fn pose(@builtin(global_invocation_id) own: vec3u) {
    // Buffers may have room for more than there is.
    if own.x >= min(arrayLength(&rows), arrayLength(&pairs)) {
        return;
    }
    let row = rows[own.x];
    var a = bodies[row.bodies.x];
    var b = bodies[row.bodies.y];
    var boxes = b.pose;
    var more = vec3f(0.0);
    var posed_boxes = (a.kind & POSED) | ((b.kind & POSED) << 1u);
    if (a.kind & INVERTIBLE) != 0u && (b.kind & IN_RANGE) != 0u {
        let reach = a.reach + b.reach;
        for (var i = 0u; i < 3u; i++) {
            boxes[i] = vec4f(0.0);
            for (var k = 0u; k < 3u; k++) {
                boxes[i] += a.inverse[i][k] * (b.pose[k] - vec4f(0.0, 0.0, 0.0, a.pose[k].w));
            }
            more[i] = dot(abs(a.inverse[i].xyz) * PADDING + a.inverse[i].w, reach);
        }
        posed_boxes = 2u;
    }
    pairs[own.x] = InstancePair(
        boxes,
        padding(a.pose, a.flushed),
        posed_boxes,
        padding(boxes, b.flushed) + more,
        row.number,
        row.first_id,
        a.first_node,
        a.first_slot,
        array<array<vec4f, 3>, 2>(a.pose, b.pose),
    );
}

// The padding of boxes that are posed so, beside that for the magnitudes that are turned.
fn padding(rows: array<vec4f, 3>, flushed: f32) -> vec3f {
    return abs(vec3f(rows[0].w, rows[1].w, rows[2].w)) * PADDING + flushed;
}
