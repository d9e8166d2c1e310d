// Reads results, writes them for the host; of the hits, which may have any order, one an invocation.

@compute @workgroup_size(GROUP)
fn bring(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let count = min(hit_count(lane), arrayLength(&read_back_hits));
    write_read_back(lane, group.x, groups.x, false);
    let place = group.x * GROUP + lane;
    if place < count {
        read_back_hits[place] = hits[place];
    }
}
