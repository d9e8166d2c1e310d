// Reads positions and a schedule, writes the corners of triangles and the boxes of nodes.
//
// A job is a part of the tree, whole below its root but for what earlier stages have done. A
// workgroup does it in rounds, from the leaves up, each round being some entries of the schedule. Each
// entry of a job has a slot of its own, in order, where its box is kept for that of its parent.

struct Stage {
    first_job: u32,
    end_job: u32,
}

// Nodes, in the order of jobs and rounds, each with the slots of its children, 16 bits each: EARLIER if
// an earlier stage has fitted the child.
@group(0) @binding(6) var<storage, read> schedule: array<vec2u>;
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
        let start = rounds[jobs[job]];
        for (var round = jobs[job]; round < jobs[job + 1u]; round++) {
            for (var i = rounds[round] + lane; i < rounds[round + 1u]; i += GROUP) {
                fit(schedule[i], i - start);
            }
            workgroupBarrier();
        }
    }
}

fn fit(entry: vec2u, slot: u32) {
    let first = nodes[entry.x].first;
    let count = nodes[entry.x].count;
    var box: Extent;
    if count == 0u {
        box = around(child_box(first, entry.y & 0xffffu), child_box(first + 1u, entry.y >> 16u));
    } else {
        box = leaf_box(first, count);
    }
    keep(slot, box);
    write_node(entry.x, box, first, count);
}

fn child_box(index: u32, slot: u32) -> Extent {
    if slot == EARLIER {
        return earlier_box(index);
    }
    return kept_box(slot);
}
