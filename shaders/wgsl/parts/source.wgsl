// The mesh that a tree is built of, and grids that tell its triangles apart.

@group(0) @binding(4) var<storage, read> positions: array<f32>;
@group(0) @binding(5) var<storage, read> triangles: array<u32>;

fn position(vertex: u32) -> vec3f {
    return vec3f(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

// At half scale, where no difference overflows.
struct HalfBox {
    min: vec3f,
    max: vec3f,
}

fn half_box(triangle: u32) -> HalfBox {
    let a = position(triangles[3u * triangle]) * 0.5;
    let b = position(triangles[3u * triangle + 1u]) * 0.5;
    let c = position(triangles[3u * triangle + 2u]) * 0.5;
    return HalfBox(min(min(a, b), c), max(max(a, b), c));
}

// How many cells of a grid of 2^bits go to a unit. An extent that is too small to be divided has one cell.
fn cells_of(extent: f32, bits: u32) -> f32 {
    return select(0.0, f32(1u << bits) / extent, extent > 1e-30);
}

// The cell of a point, whatever the point.
fn cell(p: vec3f, low: vec3f, cells: f32, bits: u32) -> vec3u {
    let last = (1u << bits) - 1u;
    return min(vec3u(clamp((p - low) * cells, vec3f(0.0), vec3f(f32(last)))), vec3u(last));
}
