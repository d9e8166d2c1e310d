// Reads results, writes them for the host; hits in order if there are few, else as they are. RANKERS invocations rank a hit
// among all others.

var<workgroup> ranks: array<atomic<u32>, GROUP / RANKERS>;

@compute @workgroup_size(GROUP)
fn order(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    const MINE = GROUP / RANKERS;
    let count = hit_count(lane);
    let first = group.x * MINE;
    let is_few = count <= FEW;
    write_read_back(lane, group.x, groups.x, is_few);
    let place = first + lane / RANKERS;
    let part = lane % RANKERS;
    let is_mine = place < count;
    let own = hits[select(0u, place, is_mine)];
    if lane < MINE {
        atomicStore(&ranks[lane], 0u);
    }
    workgroupBarrier();
    // A workgroup without a hit compares none.
    let compared = tell(lane, select(0u, count, is_few & (first < count)));
    for (var begin = 0u; begin < compared; begin += BUCKETS) {
        // A key after those of all hits fills the last turns of the loop below.
        let size = min(BUCKETS, compared - begin);
        let end = (size + 4u * RANKERS - 1u) / (4u * RANKERS) * (4u * RANKERS);
        for (var i = lane; i < end; i += GROUP) {
            if i < size {
                ranked[i] = hits[begin + i];
            } else {
                ranked[i] = vec2u(0xffffffffu);
            }
        }
        workgroupBarrier();
        // Invocations next to each other read hits next to each other, which are in different banks.
        var rank = vec4u(0u);
        for (var i = part; i < end; i += 4u * RANKERS) {
            let four = vec4<bool>(
                precedes(ranked[i], own),
                precedes(ranked[i + RANKERS], own),
                precedes(ranked[i + 2u * RANKERS], own),
                precedes(ranked[i + 3u * RANKERS], own),
            );
            rank += select(vec4u(0u), vec4u(1u), four);
        }
        atomicAdd(&ranks[lane / RANKERS], rank.x + rank.y + rank.z + rank.w);
        workgroupBarrier();
    }
    if is_few & is_mine & (part == 0u) {
        put_hit(atomicLoad(&ranks[lane / RANKERS]), own);
    }
    if !is_few {
        put_unordered(lane, group.x, groups.x, count);
    }
}
