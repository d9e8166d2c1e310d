// Reads hits by bucket, writes them in order. One workgroup a bucket.

// How many hits come before those of this bucket, and the most of any bucket.
var<workgroup> preceding: atomic<u32>;
var<workgroup> most: atomic<u32>;

@compute @workgroup_size(GROUP)
fn settle(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3u) {
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
    if !has_room || group.x >= BUCKETS {
        if !has_room && lane == 0u {
            atomicOr(&counters.unordered, 1u);
        }
        return;
    }
    for (var i = lane; i < size; i += GROUP) {
        ranked[i] = kept[group.x * room() + i];
    }
    pad_ranked(lane, size);
    workgroupBarrier();
    for (var i = lane; i < size; i += GROUP) {
        let own = ranked[i];
        hits[start + rank_among(own, 0u, size)] = own;
    }
}
