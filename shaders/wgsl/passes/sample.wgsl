// Reads a sample of the hits, writes where buckets begin and empties them. Each workgroup ranks a few of the sample among
// all of it, RANKERS invocations each.

var<workgroup> ranks: array<atomic<u32>, GROUP / RANKERS>;

@compute @workgroup_size(GROUP)
fn sample(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3u) {
    const MINE = GROUP / RANKERS;
    let count = hit_count(lane);
    // A bucket between k sampled hits is as large as a sum of k exponential numbers. With one sampled hit, the largest of 1,024
    // buckets is about seven times the mean, and seldom ten times; with eight, it is four times the mean, the most that a run is
    // made for, in one list of 10,000.
    let each = select(1u, FINER, count > room() * (BUCKETS / 10u));
    let size = each * BUCKETS;
    let bits = countTrailingZeros(size);
    let first = group.x * MINE;
    let mine = lane / RANKERS;
    let part = lane % RANKERS;
    let own = sampled(first + mine, bits, count);
    if part == 0u {
        atomicStore(&ranks[mine], 0u);
    }
    let tiles = tell(lane, select(each, 0u, first >= size));
    for (var tile = 0u; tile < tiles; tile++) {
        for (var i = lane; i < BUCKETS; i += GROUP) {
            ranked[i] = sampled(tile * BUCKETS + i, bits, count);
        }
        workgroupBarrier();
        const PART = BUCKETS / RANKERS;
        atomicAdd(&ranks[mine], rank_among(own, part * PART, (part + 1u) * PART));
        workgroupBarrier();
    }
    let rank = atomicLoad(&ranks[mine]);
    if part == 0u && first + mine < size && rank % each == 0u {
        buckets.splitters[rank / each] = own;
        atomicStore(&buckets.dealt[rank / each], 0u);
    }
}

// Takes a hit from each of 2^bits equal stretches, at a random place: like hits come in runs, and places in step with runs made
// for buckets of thirty times the mean size. If there are fewer hits, takes them all, and then entries later than any hit.
fn sampled(i: u32, bits: u32, count: u32) -> vec2u {
    let start = stretch_start(i, bits, count);
    // Bits without a pattern (PCG-RXS-M-XS, O'Neill 2014).
    let state = i * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    let part = ((word >> 22u) ^ word) >> 20u;
    let inside = (part * (stretch_start(i + 1u, bits, count) - start)) >> 12u;
    let at = select(start + inside, i, count < (1u << bits));
    if at < count {
        return hits[at];
    }
    return vec2u(0xffffffffu, i);
}

// The place at which a stretch begins.
fn stretch_start(i: u32, bits: u32, count: u32) -> u32 {
    return i * (count >> bits) + ((i * (count & ((1u << bits) - 1u))) >> bits);
}
