// Reads hits, writes them by bucket, each bucket in any order.

var<workgroup> splitters: array<vec2u, BUCKETS>;

@compute @workgroup_size(GROUP)
fn deal(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let count = hit_count(lane);
    for (var i = lane; i < BUCKETS; i += GROUP) {
        splitters[i] = buckets.splitters[i];
    }
    workgroupBarrier();
    for (var i = group.x * GROUP + lane; i < count; i += groups.x * GROUP) {
        let hit = hits[i];
        let bucket = bucket_of(hit);
        let place = atomicAdd(&buckets.dealt[bucket], 1u);
        if place < room() {
            kept[bucket * room() + place] = hit;
        }
    }
}

// The last bucket that does not begin after it.
fn bucket_of(hit: vec2u) -> u32 {
    var bucket = 0u;
    for (var half = BUCKETS / 2u; half > 0u; half /= 2u) {
        let next = bucket + half;
        bucket = select(next, bucket, precedes(hit, splitters[next]));
    }
    return bucket;
}
