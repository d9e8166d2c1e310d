// Reads the triangles of each node of a level, writes how to divide them: across the longest axis of the
// box around their centres, or of some hundred of them.

const SAMPLES = 4u * GROUP;

@group(0) @binding(0) var<storage, read> entries_in: array<vec2u>;

@compute @workgroup_size(GROUP)
fn survey(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    for (var node = group.x; node < (1u << build.top); node += groups.x) {
        clear_extent(lane);
        let start = node_start(build.top, node);
        let count = node_start(build.top, node + 1u) - start;
        // Evenly spread, without a product that overflows.
        let step = (count + SAMPLES - 1u) / SAMPLES;
        var low = vec3i(0x7fffffff);
        var high = -low;
        for (var i = lane * step; i < count; i += GROUP * step) {
            var triangle = start + i;
            if build.top != 0u {
                triangle = entries_in[triangle].y;
            }
            let own = half_box(triangle);
            let centre = ordered(own.min * 0.5 + own.max * 0.5);
            low = min(low, centre);
            high = max(high, centre);
        }
        add_extent(low, high);
        if lane == 0u {
            let corner = extent_low();
            let extent = extent_high() - corner;
            var axis = select(0u, 1u, extent.y > extent.x);
            axis = select(axis, 2u, extent.z > extent[axis]);
            cuts[node] = Cut(axis, corner[axis], cells_of(extent[axis], CUT_BITS));
        }
        workgroupBarrier();
    }
}
