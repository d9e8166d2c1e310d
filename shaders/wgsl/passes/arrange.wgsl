// Reads sorted entries and the mesh, writes the order of the triangles and the vertices of their corners.
//
// A workgroup takes the triangles of a node that is small enough and halves them in its own memory, down
// to the leaves. It sees them in the cells of a grid of their own.

@group(0) @binding(0) var<storage, read> entries_in: array<vec2u>;
@group(0) @binding(1) var<storage, read_write> corners: array<Corner>;
@group(0) @binding(2) var<storage, read_write> order: array<u32>;

@compute @workgroup_size(GROUP)
fn arrange(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let levels = build.bottom - build.top;
    for (var job = group.x; job < (1u << build.top); job += groups.x) {
        measure(lane, job);
        fill(lane, job);
        workgroupBarrier();
        for (var level = 0u; level < levels; level++) {
            halve(lane, job, level);
        }
        write(lane, job);
        workgroupBarrier();
    }
}

fn member(place: u32) -> u32 {
    if build.top == 0u {
        return place;
    }
    return entries_in[place].y;
}

fn measure(lane: u32, job: u32) {
    clear_extent(lane);
    let end = run_start(job + 1u, 0u, 0u);
    var low = vec3i(0x7fffffff);
    var high = -low;
    for (var i = run_start(job, 0u, 0u) + lane; i < end; i += GROUP) {
        let own = half_box(member(i));
        low = min(low, ordered(own.min));
        high = max(high, ordered(own.max));
    }
    add_extent(low, high);
}

// Puts the triangles of a job into the first slots.
fn fill(lane: u32, job: u32) {
    let low = extent_low();
    let extent = extent_high() - low;
    let cells = cells_of(max(max(extent.x, extent.y), extent.z), AXIS_BITS);
    let start = run_start(job, 0u, 0u);
    let count = run_start(job + 1u, 0u, 0u) - start;
    for (var i = lane; i < BLOCK; i += GROUP) {
        slots[i] = select(EMPTY, i, i < count);
        if i < count {
            let own = half_box(member(start + i));
            let min_cell = cell(own.min, low, cells, AXIS_BITS);
            let max_cell = cell(own.max, low, cells, AXIS_BITS);
            boxes[i] = vec2u(pack(min_cell), pack(max_cell));
            centres[i] = pack((min_cell + max_cell) / 2u);
        }
    }
}

fn write(lane: u32, job: u32) {
    let levels = build.bottom - build.top;
    let leaf_bits = SLOT_BITS - levels;
    let start = run_start(job, 0u, 0u);
    for (var i = lane; i < BLOCK; i += GROUP) {
        if slots[i] != EMPTY {
            let triangle = member(start + slots[i] % BLOCK);
            let leaf = i >> leaf_bits;
            let slot = run_start(job, levels, leaf) + i - (leaf << leaf_bits);
            order[slot] = triangle;
            for (var k = 0u; k < 3u; k++) {
                corners[3u * slot + k].vertex = triangles[3u * triangle + k];
            }
        }
    }
}
