// Reads and writes the table: from how many entries of a run have a digit to how many of the runs before it
// have. Writes how many have it in all.

@compute @workgroup_size(GROUP)
fn scan(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let share = (build.workgroups + GROUP - 1u) / GROUP;
    let mine = min(vec2u(lane, lane + 1u) * share, vec2u(build.workgroups));
    for (var digit = group.x; digit < DIGITS; digit += groups.x) {
        let row = digit * build.workgroups;
        var sum = 0u;
        for (var i = row + mine.x; i < row + mine.y; i++) {
            sum += table[i];
        }
        var start = before(lane, sum);
        for (var i = row + mine.x; i < row + mine.y; i++) {
            let count = table[i];
            table[i] = start;
            start += count;
        }
        if lane == GROUP - 1u {
            totals[digit] = start;
        }
    }
}
