// Counts the digits of a workgroup's run.

var<workgroup> counts: array<atomic<u32>, DIGITS>;

fn clear_counts(lane: u32) {
    for (var i = lane; i < DIGITS; i += GROUP) {
        atomicStore(&counts[i], 0u);
    }
    workgroupBarrier();
}

fn count_digit(key: u32) {
    atomicAdd(&counts[digit(key)], 1u);
}

fn write_counts(lane: u32, group: u32) {
    workgroupBarrier();
    // A row of the table has one place for each workgroup that has a run.
    if group >= build.workgroups {
        return;
    }
    for (var i = lane; i < DIGITS; i += GROUP) {
        table[i * build.workgroups + group] = atomicLoad(&counts[i]);
    }
}
