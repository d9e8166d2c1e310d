// One pass of a radix sort, by one digit: count, scan, scatter. It is stable, so that passes from the lowest
// digit up sort by the whole key.
//
// Each workgroup has a run of the entries of its own. `table` says, digit by digit and in the order of
// the runs, how many entries of a run have the digit, and after the scan how many of the runs before it
// have. Nothing waits for another workgroup, which WebGPU would not promise to end.

// Key and triangle.
@group(0) @binding(0) var<storage, read> entries_in: array<vec2u>;
@group(0) @binding(1) var<storage, read_write> entries_out: array<vec2u>;
@group(0) @binding(2) var<storage, read_write> table: array<u32>;
// How many entries have each digit.
@group(0) @binding(3) var<storage, read_write> totals: array<u32>;

fn digit(key: u32) -> u32 {
    return (key >> build.shift) % DIGITS;
}

// Where the entries of a workgroup begin, and where they end.
fn run_of(group: u32) -> vec2u {
    return min(vec2u(group, group + 1u) * build.run, vec2u(build.triangles));
}
