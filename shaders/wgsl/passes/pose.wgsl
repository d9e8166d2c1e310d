// Reads the vertices of bodies, each in the frame of its body, and the poses of the bodies; writes where the
// vertices are in the world, to the bit.
//
// Here nothing is left in doubt: integers take the few vertices of which an adapter may have flushed
// something.

struct Posing {
    vertices: u32,
}

// Coordinates are copied by their bits.
@group(0) @binding(0) var<storage, read> shapes: array<u32>;
// The body of each vertex.
@group(0) @binding(1) var<storage, read> owners: array<u32>;
// Three rows a body.
@group(0) @binding(2) var<storage, read> poses: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> positions: array<u32>;
@group(1) @binding(0) var<uniform> posing: Posing;

@compute @workgroup_size(GROUP)
fn pose(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    for (var vertex = id.x; vertex < posing.vertices; vertex += groups.x * GROUP) {
        let at = 3u * vertex;
        let own = bitcast<vec3f>(vec3u(shapes[at], shapes[at + 1u], shapes[at + 2u]));
        let rows = rows_of_body(owners[vertex]);
        doubt = false;
        var posed = posed_position(rows, own);
        if doubt {
            posed = soft_position(rows, own);
        }
        let bits = bitcast<vec3u>(posed);
        positions[at] = bits.x;
        positions[at + 1u] = bits.y;
        positions[at + 2u] = bits.z;
    }
}

fn rows_of_body(body: u32) -> Rows {
    let x = poses[3u * body];
    let y = poses[3u * body + 1u];
    let z = poses[3u * body + 2u];
    return Rows(
        array<vec3f, 3>(vec3f(x.x, y.x, z.x), vec3f(x.y, y.y, z.y), vec3f(x.z, y.z, z.z)),
        vec3f(x.w, y.w, z.w),
    );
}
