// Across which axis the triangles of a node are divided, and the grid that tells them apart along it.

struct Cut {
    axis: u32,
    low: f32,
    cells: f32,
}

// By node of the level.
@group(0) @binding(6) var<storage, read_write> cuts: array<Cut>;
