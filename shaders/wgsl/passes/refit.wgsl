// Reads positions and a schedule, writes the corners of triangles and the boxes of nodes.
//
// A job is a part of the tree, whole below its root but for what earlier jobs have done. A
// workgroup does it in rounds, from the leaves up, each round being some entries of the schedule.

struct Stage {
    first_job: u32,
    end_job: u32,
}

// Nodes, in the order of jobs and rounds.
@group(0) @binding(6) var<storage, read> schedule: array<u32>;
// Where each round begins; it ends where the next begins.
@group(0) @binding(7) var<storage, read> rounds: array<u32>;
// The first round of each job, which ends likewise.
@group(0) @binding(8) var<storage, read> jobs: array<u32>;
@group(1) @binding(0) var<uniform> stage: Stage;

@compute @workgroup_size(GROUP)
fn refit(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    for (var job = stage.first_job + group.x; job < stage.end_job; job += groups.x) {
        for (var round = jobs[job]; round < jobs[job + 1u]; round++) {
            for (var i = rounds[round] + lane; i < rounds[round + 1u]; i += GROUP) {
                fit(schedule[i]);
            }
            storageBarrier();
        }
    }
}

fn fit(index: u32) {
    let first = nodes[index].first;
    let count = nodes[index].count;
    if count == 0u {
        nodes[index] = fitted_inner(first);
    } else {
        nodes[index] = fitted_leaf(first, count);
    }
}
