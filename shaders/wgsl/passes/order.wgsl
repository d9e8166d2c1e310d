// Reads hits, writes them in order if there are few, else as many as there is room for as they are. RANKERS invocations
// rank a hit among all others.

var<workgroup> ranks: array<atomic<u32>, GROUP / RANKERS>;

@compute @workgroup_size(GROUP)
fn order(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3u) {
    const MINE = GROUP / RANKERS;
    const PART = BUCKETS / RANKERS;
    let count = tell(lane, hit_count());
    let first = group.x * MINE;
    let is_few = count <= FEW;
    let place = first + lane / RANKERS;
    let part = lane % RANKERS;
    let is_mine = place < min(count, FEW);
    let own = hits[select(0u, place, is_mine)];
    if lane < MINE {
        atomicStore(&ranks[lane], 0u);
    }
    workgroupBarrier();
    // A workgroup without a hit compares none.
    let compared = tell(lane, select(0u, count, is_few & (first < count)));
    for (var begin = 0u; begin < compared; begin += BUCKETS) {
        let size = min(BUCKETS, compared - begin);
        for (var i = lane; i < size; i += GROUP) {
            ranked[i] = hits[begin + i];
        }
        pad_ranked(lane, size);
        workgroupBarrier();
        atomicAdd(&ranks[lane / RANKERS], rank_among(own, part * PART, min(size, (part + 1u) * PART)));
        workgroupBarrier();
    }
    if is_mine & (part == 0u) {
        ordered[select(place, atomicLoad(&ranks[lane / RANKERS]), is_few)] = own;
    }
}
