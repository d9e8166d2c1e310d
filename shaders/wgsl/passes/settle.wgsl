// Reads results, writes them for the host; hits by bucket, which it puts in order. One workgroup a bucket.

// How many hits come before those of this bucket, and the most of any bucket.
var<workgroup> preceding: atomic<u32>;
var<workgroup> most: atomic<u32>;

@compute @workgroup_size(GROUP)
fn settle(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    if lane == 0u {
        atomicStore(&preceding, 0u);
        atomicStore(&most, 0u);
    }
    workgroupBarrier();
    var own_preceding = 0u;
    var own_most = 0u;
    for (var i = lane; i < BUCKETS; i += GROUP) {
        let size = atomicLoad(&buckets.dealt[i]);
        own_most = max(own_most, size);
        own_preceding += select(0u, size, i < group.x);
    }
    atomicAdd(&preceding, own_preceding);
    atomicMax(&most, own_most);
    workgroupBarrier();
    let start = tell(lane, atomicLoad(&preceding));
    let has_room = tell(lane, atomicLoad(&most)) <= room();
    if lane == 0u {
        told = atomicLoad(&buckets.dealt[group.x]);
    }
    let size = workgroupUniformLoad(&told);
    let count = hit_count(lane);
    write_read_back(lane, group.x, groups.x, has_room);
    if !has_room {
        put_unordered(lane, group.x, groups.x, count);
        return;
    }
    if group.x >= BUCKETS {
        return;
    }
    let bits = bits_for(size);
    for (var i = lane; i < max(1u << bits, 4u); i += GROUP) {
        if i < size {
            ranked[i] = kept[group.x * room() + i];
        } else {
            // After any hit.
            ranked[i] = vec2u(0xffffffffu);
        }
    }
    workgroupBarrier();
    if size <= GROUP {
        // So few are ranked before a network has passed its barriers.
        if lane < size {
            let own = ranked[lane];
            put_hit(start + rank_among(own, 0u, size), own);
        }
        return;
    }
    sort_ranked(lane, bits);
    for (var i = lane; i < size; i += GROUP) {
        put_hit(start + i, ranked[i]);
    }
}

// The bits of the least power of two that is not below so many.
fn bits_for(size: u32) -> u32 {
    return select(32u - countLeadingZeros(size - 1u), 0u, size < 2u);
}

// Sorts 2^bits hits in workgroup memory: the bitonic network (Batcher 1968).
fn sort_ranked(lane: u32, bits: u32) {
    for (var run = 1u; run <= bits; run++) {
        for (var step = run; step > 0u; step--) {
            // Compares what lies 2^(step - 1) apart. Runs of 2^run ascend and descend in turn.
            let apart = step - 1u;
            for (var i = lane; i < (1u << bits) / 2u; i += GROUP) {
                let low = ((i >> apart) << step) + (i & ((1u << apart) - 1u));
                let high = low + (1u << apart);
                let p = ranked[low];
                let q = ranked[high];
                if precedes(q, p) == (((low >> run) & 1u) == 0u) {
                    ranked[low] = q;
                    ranked[high] = p;
                }
            }
            workgroupBarrier();
        }
    }
}
