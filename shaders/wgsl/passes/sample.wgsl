// Reads a sample of the hits, writes where buckets begin. Each workgroup ranks a few of the sample among
// all of it, RANKERS invocations each.

var<workgroup> ranks: array<atomic<u32>, GROUP / RANKERS>;

@compute @workgroup_size(GROUP)
fn sample(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3u) {
    const MINE = GROUP / RANKERS;
    let count = hit_count(lane);
    // The buckets between all of a sample are uneven, the largest of a thousand being some seven times the mean one, and
    // more than ten times in one of twenty samples; between each fourth of a larger sample, three times.
    let each = select(1u, FINER, count > MANY);
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

// Of 2^bits equal stretches, a hit from each, at a place that differs: hits come in runs of like ones, and places in step with
// these would make for buckets of thirty times the mean size. Few hits all, and then what is later than any.
fn sampled(i: u32, bits: u32, count: u32) -> vec2u {
    let start = stretch(i, bits, count);
    // Multiples of the golden section spread evenly, and in step with nothing.
    let part = (i * 0x9e3779b9u) >> 20u;
    let inside = (part * (stretch(i + 1u, bits, count) - start)) >> 12u;
    let at = select(start + inside, i, count < (1u << bits));
    if at < count {
        return hits[at];
    }
    return vec2u(0xffffffffu, i);
}

fn stretch(i: u32, bits: u32, count: u32) -> u32 {
    return i * (count >> bits) + ((i * (count & ((1u << bits) - 1u))) >> bits);
}
