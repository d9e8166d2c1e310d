// Reads the seeds of both BVHs, writes the first front and leaf pairs: tests each node of one level of A
// against each of one level of B, and descends.

@compute @workgroup_size(GROUP)
fn seed(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    if lane == 0u {
        told = select(query.seeds.x * query.seeds.y, 0u, is_answered());
    }
    let length = workgroupUniformLoad(&told);
    let mine = share(length, group.x, groups.x);
    var rounds = 0u;
    for (var done = 0u; done < mine; done += GROUP) {
        if rounds >= MOST_ROUNDS {
            overflowed(WORK_OVERFLOW);
            break;
        }
        if done != 0u && is_enough(lane) {
            break;
        }
        clear_queues(lane);
        if done + lane < mine {
            let product = group.x + (done + lane) * groups.x;
            let pair = vec2u(product / query.seeds.y, product % query.seeds.y);
            if (query.within == 0u) | (pair.x <= pair.y) {
                visit(placed_a(seeds_a[pair.x]), placed_b(seeds_b[pair.y]), 0u, QUEUE);
            }
        }
        workgroupBarrier();
        rounds = descend(lane, rounds);
        workgroupBarrier();
    }
}
