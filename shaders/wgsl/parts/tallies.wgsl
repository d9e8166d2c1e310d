// Hits of each pair of instances, if something is asked of each.

@group(1) @binding(4) var<storage, read_write> tallies: array<atomic<u32>>;

// Whether the present pair needs no more hits.
fn is_settled() -> bool {
    return ((query.each ^ nothing) == ANY_EACH) && atomicLoad(&tallies[pairs[row].number]) != 0u;
}

// Counts a hit of the present pair; whether it is one to report.
fn is_reported() -> bool {
    if (query.each ^ nothing) == 0u {
        return true;
    }
    let is_first = atomicAdd(&tallies[pairs[row].number], 1u) == 0u;
    return is_first || (query.each ^ nothing) != ANY_EACH;
}
