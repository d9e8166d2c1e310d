// Triangles in leaf order, with their corners where the query has them.

alias Triangle = array<vec3f, 3>;

// Corners of a pair.
const POINTS = 6u;

struct Corners {
    positions: Triangle,
    vertices: vec3u,
}

fn rows_of(side: u32) -> Rows {
    let rows = pose_rows(side);
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
    if !is_posed(side) {
        return t;
    }
    let rows = rows_of(side);
    var own = t;
    for (var i = 0u; i < 3u; i++) {
        own[i] = posed_position(rows, own[i]);
    }
    return own;
}

// A test compares which words become which fields with the layout of Corner.
fn corner_of(words: CornerWords) -> Corner {
    return Corner(bitcast<vec3f>(words.xyz), words.w);
}

fn corners_of(words: array<CornerWords, 3>) -> Corners {
    let p = corner_of(words[0]);
    let q = corner_of(words[1]);
    let r = corner_of(words[2]);
    let positions = Triangle(p.position, q.position, r.position);
    return Corners(positions, vec3u(p.vertex, q.vertex, r.vertex));
}

// In the frames of their meshes.
fn triangle_a(slot: u32) -> Corners {
    return corners_of(
        array<CornerWords, 3>(corner_a(slot, 0u), corner_a(slot, 1u), corner_a(slot, 2u))
    );
}

fn triangle_b(slot: u32) -> Corners {
    return corners_of(
        array<CornerWords, 3>(corner_b(slot, 0u), corner_b(slot, 1u), corner_b(slot, 2u))
    );
}
