// Reads a front, writes the next front and leaf pairs.

@compute @workgroup_size(GROUP)
fn expand(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    if lane == 0u {
        let held = min(atomicLoad(&counters.fronts[step.pass_index]), query.front_capacity);
        told = select(held, 0u, is_answered());
    }
    let length = workgroupUniformLoad(&told);
    // A workgroup that takes any takes so many that two levels below there can be one for each of its invocations, but for the
    // front that a run starts from: most of what is below is still to come.
    let takers = select(clamp(16u * length / GROUP, 1u, groups.x), groups.x, step.pass_index == 0u);
    let mine = share(length, group.x, takers);
    var rounds = 0u;
    for (var done = 0u; done < mine; done += CHUNK) {
        if rounds >= MOST_ROUNDS {
            overflowed(WORK_OVERFLOW);
            break;
        }
        if done != 0u && is_enough(lane) {
            break;
        }
        clear_queues(lane);
        let pairs = min(CHUNK, mine - done);
        if lane < pairs {
            queue[lane] = front_in[group.x + (done + lane) * takers];
        }
        if lane == 0u {
            atomicStore(&queued[0], pairs);
        }
        workgroupBarrier();
        rounds = descend(lane, rounds);
        workgroupBarrier();
    }
}
