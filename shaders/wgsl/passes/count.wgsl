// Reads entries, writes how many of each run have each digit.

@compute @workgroup_size(GROUP)
fn count(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    clear_counts(lane);
    let run = run_of(group.x);
    for (var i = run.x + lane; i < run.y; i += GROUP) {
        count_digit(entries_in[i].x);
    }
    write_counts(lane, group.x);
}
