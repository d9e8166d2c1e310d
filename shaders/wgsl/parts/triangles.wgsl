// Triangles in leaf order, with their corners where the query has them.

fn placed(side: u32, p: vec3f) -> vec3f {
    let rows = query.sides[side].rows;
    let posed = vec3f(
        posed_coordinate(rows[0], p),
        posed_coordinate(rows[1], p),
        posed_coordinate(rows[2], p),
    );
    return select(p, posed, query.posed[side] != 0u);
}

fn triangle_a(slot: u32) -> array<vec3f, 3> {
    return array<vec3f, 3>(
        placed(0u, corners_a[3u * slot].position),
        placed(0u, corners_a[3u * slot + 1u].position),
        placed(0u, corners_a[3u * slot + 2u].position),
    );
}

fn triangle_b(slot: u32) -> array<vec3f, 3> {
    return array<vec3f, 3>(
        placed(1u, corners_b[3u * slot].position),
        placed(1u, corners_b[3u * slot + 1u].position),
        placed(1u, corners_b[3u * slot + 2u].position),
    );
}
