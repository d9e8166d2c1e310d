// Triangles in leaf order, with their corners where the query has them.

alias Triangle = array<vec3f, 3>;

struct Corners {
    positions: Triangle,
    vertices: vec3u,
}

fn rows_of(side: u32) -> Rows {
    let rows = query.sides[side].rows;
    return Rows(
        array<vec3f, 3>(
            vec3f(rows[0].x, rows[1].x, rows[2].x),
            vec3f(rows[0].y, rows[1].y, rows[2].y),
            vec3f(rows[0].z, rows[1].z, rows[2].z),
        ),
        vec3f(rows[0].w, rows[1].w, rows[2].w),
    );
}

// To the bit.
fn placed(side: u32, t: Triangle) -> Triangle {
    if (query.posed[side] ^ nothing) == 0u {
        return t;
    }
    let rows = rows_of(side);
    var own = t;
    for (var i = 0u; i < 3u; i++) {
        own[i] = posed_position(rows, own[i]);
    }
    return own;
}

fn corners_of(p: vec4u, q: vec4u, r: vec4u) -> Corners {
    let positions = Triangle(bitcast<vec3f>(p.xyz), bitcast<vec3f>(q.xyz), bitcast<vec3f>(r.xyz));
    return Corners(positions, vec3u(p.w, q.w, r.w));
}

// In the frames of their meshes.
fn triangle_a(slot: u32) -> Corners {
    let at = 3u * slot;
    return corners_of(corners_a[at], corners_a[at + 1u], corners_a[at + 2u]);
}

fn triangle_b(slot: u32) -> Corners {
    let at = 3u * slot;
    return corners_of(corners_b[at], corners_b[at + 1u], corners_b[at + 2u]);
}
