// Reads a sample of the hits, writes where buckets begin. Each workgroup ranks a few of the sample among
// all of it, RANKERS invocations each.

var<workgroup> ranks: array<atomic<u32>, GROUP / RANKERS>;

@compute @workgroup_size(GROUP)
fn sample(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3u) {
    let count = hit_count(lane);
    for (var i = lane; i < BUCKETS; i += GROUP) {
        // One from each of as many equal stretches; few hits all, and then what is later than any.
        let stretch = i * (count / BUCKETS) + i * (count % BUCKETS) / BUCKETS;
        let at = select(stretch, i, count < BUCKETS);
        if at < count {
            ranked[i] = hits[at];
        } else {
            ranked[i] = vec2u(0xffffffffu, i);
        }
    }
    let mine = lane / RANKERS;
    let part = lane % RANKERS;
    if part == 0u {
        atomicStore(&ranks[mine], 0u);
    }
    workgroupBarrier();
    let place = group.x * (GROUP / RANKERS) + mine;
    let own = ranked[min(place, BUCKETS - 1u)];
    const PART = BUCKETS / RANKERS;
    atomicAdd(&ranks[mine], rank_among(own, part * PART, (part + 1u) * PART));
    workgroupBarrier();
    if part == 0u && place < BUCKETS {
        let rank = atomicLoad(&ranks[mine]);
        buckets.splitters[rank] = own;
        atomicStore(&buckets.dealt[rank], 0u);
    }
}
