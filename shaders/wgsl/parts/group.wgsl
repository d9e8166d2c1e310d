// Values that the invocations of a workgroup share.

var<workgroup> told: u32;

// One value for the whole workgroup, from its first invocation: control flow may depend on it.
fn tell(lane: u32, value: u32) -> u32 {
    if lane == 0u {
        told = value;
    }
    return workgroupUniformLoad(&told);
}

// How many of `n` items are this workgroup's, when they are dealt out in turn.
fn share(n: u32, group: u32, groups: u32) -> u32 {
    return (n + groups - 1u - min(group, groups - 1u)) / groups * u32(group < groups);
}

// Rounds of work that a workgroup does in a pass before it gives up and the host divides the run. Rust sets
// it for the adapter.
override MOST_ROUNDS: u32;

// Why the answer of a run may lack something.
fn overflowed(what: u32) {
    atomicOr(&counters.overflow, what);
}
