// The depth-bounded descent (Zhang & Kim 2014, section 4): a workgroup takes node pairs into its
// own memory, goes down `query.levels` levels breadth-first, and hands on what is left: node pairs
// to the next front, leaf pairs to their list, each with one addition to a counter in global
// memory.
//
// A front holds node pairs whose boxes overlap, or that a question was divided into, and of each
// node not its index but where its children are (LEAF and its own index if it has none): a level costs one load of nodes, not a load
// of parents and then one of children. Four invocations take one pair, each a pair of children.
// Pairs that do not fit in workgroup memory go straight to the next front, so that nothing is lost;
// the host sees a front left over after the last pass and goes on from it.

// Two halves, read and written in turn.
var<workgroup> queue: array<vec2u, 2 * QUEUE>;
var<workgroup> queued: array<atomic<u32>, 2>;
var<workgroup> found: array<vec2u, FOUND>;
var<workgroup> found_count: atomic<u32>;
// Node pairs whose children were tested, until they are counted.
var<private> tested: u32;

fn clear_queues(lane: u32) {
    if lane == 0u {
        atomicStore(&queued[0], 0u);
        atomicStore(&queued[1], 0u);
        atomicStore(&found_count, 0u);
    }
    workgroupBarrier();
}

// A node with its box in the frame of the query.
struct Placed {
    box: Box,
    reference: u32,
    run: u32,
    is_leaf: bool,
    // Children come after their parents. Nodes where they do not, in a buffer that was not written
    // to, are not followed: a descent ends whatever it reads.
    is_sound: bool,
}

fn placed_a(index: u32) -> Placed {
    let node = node_a(index);
    return placed_node(0u, index, node, run_a(index, node));
}

fn placed_b(index: u32) -> Placed {
    let node = node_b(index);
    return placed_node(1u, index, node, leaf_run(node));
}

fn placed_node(side: u32, index: u32, node: Node, run: u32) -> Placed {
    let box = placed_box(side, Box(node.min, node.max));
    let is_leaf = node.count != 0u;
    let is_sound = is_leaf || node.first > index;
    let reference = select(node.first, index | LEAF, is_leaf);
    return Placed(box, reference, run, is_leaf, is_sound);
}

// Puts a pair of nodes in its place, if their boxes overlap: in a stretch of the queue that has
// room for so many. Pairs whose boxes do not are kept where the host divides a question
// (`keep_leaves`): its parts serve others, too, in which they may.
fn visit(a: Placed, b: Placed, half: u32, room: u32) {
    let is_apart = (step.keep_leaves == 0u) & !overlap(a.box, b.box);
    if is_apart || !a.is_sound || !b.is_sound {
        return;
    }
    if a.is_leaf & b.is_leaf & (step.keep_leaves == 0u) {
        let runs = vec2u(a.run, b.run);
        let slot = atomicAdd(&found_count, 1u);
        if slot < FOUND {
            found[slot] = runs;
        } else {
            add_leaf_pair(atomicAdd(&counters.leaves, 1u), runs);
        }
        return;
    }
    let pair = vec2u(a.reference, b.reference);
    let slot = atomicAdd(&queued[half], 1u);
    if slot < room {
        queue[half * QUEUE + slot] = pair;
    } else {
        add_to_front(atomicAdd(&counters.fronts[step.pass_index + 1u], 1u), pair);
    }
}

// Tests one of the four pairs of children; a leaf is its own child.
fn visit_children(pair: vec2u, which: u32, half: u32, room: u32) {
    let right = vec2u(which & 1u, which >> 1u);
    let is_leaf = (pair & vec2u(LEAF)) != vec2u(0u);
    if any(is_leaf & (right != vec2u(0u))) {
        return;
    }
    // A node with itself has three pairs: (l, l), (r, r) and (l, r).
    if (query.within == 1u) & (pair.x == pair.y) & (which == 1u) {
        return;
    }
    let child = (pair & vec2u(~LEAF)) + right;
    turn_to_pair_of(child.x);
    if is_settled() {
        return;
    }
    visit(placed_a(child.x), placed_b(child.y), half, room);
}

// Descends from what is in the queue. Takes and returns how many rounds the workgroup has done.
fn descend(lane: u32, before: u32) -> u32 {
    var rounds = before;
    // Told, for lavapipe builds conditions on uniforms into shaders (see `nothing`).
    if tell(lane, step.pass_index) == query.last_pass {
        rounds = finish(lane, before);
    } else {
        descend_some_levels(lane);
        rounds += query.levels;
    }
    write_leaf_pairs(lane);
    return rounds;
}

// Whether the workgroups have found as much as this run looks for.
fn is_enough(lane: u32) -> bool {
    if lane == 0u {
        let next = atomicLoad(&counters.fronts[step.pass_index + 1u]);
        told = max(next, atomicLoad(&counters.leaves));
    }
    return workgroupUniformLoad(&told) >= query.beam;
}

fn descend_some_levels(lane: u32) {
    var level = 0u;
    loop {
        let half = level & 1u;
        let ready = min(atomicLoad(&queued[half]), QUEUE);
        let followed = min(ready, query.beam);
        let pairs = tell(lane, select(followed, 0u, level == query.levels));
        if pairs == 0u {
            break;
        }
        if lane == 0u {
            atomicStore(&queued[half], 0u);
        }
        tested += pairs;
        for (var i = lane; i < 4u * pairs; i += GROUP) {
            visit_children(queue[half * QUEUE + i / 4u], i % 4u, 1u - half, QUEUE);
        }
        workgroupBarrier();
        level++;
    }
    hand_on(lane, level & 1u, QUEUE);
}

// The last pass goes to the bottom, from pairs on top of a stack: so few of them at once that their
// children have room.
fn finish(lane: u32, before: u32) -> u32 {
    var rounds = before;
    loop {
        let size = tell(lane, min(atomicLoad(&queued[0]), 2u * QUEUE));
        if size == 0u {
            break;
        }
        if rounds >= MOST_ROUNDS {
            overflowed(WORK_OVERFLOW);
            break;
        }
        rounds++;
        visit_top(lane, size, GROUP);
        if tell(lane, atomicLoad(&found_count)) > FOUND / 2u {
            write_leaf_pairs(lane);
            if lane == 0u {
                atomicStore(&found_count, 0u);
            }
            // The host drops a run that overflows: no need to go on.
            if lane == 0u {
                told = atomicLoad(&counters.overflow);
            }
            if workgroupUniformLoad(&told) != 0u {
                break;
            }
        }
    }
    return rounds;
}

// Tests the children of at most so many pairs on top of a stack of this size.
fn visit_top(lane: u32, size: u32, most: u32) {
    let taken = clamp((2u * QUEUE - size) / 3u, 1u, min(size, most));
    tested += taken;
    var pairs: array<vec2u, 4>;
    for (var i = 0u; i < 4u; i++) {
        pairs[i] = queue[size - taken + min((lane + i * GROUP) / 4u, taken - 1u)];
    }
    workgroupBarrier();
    if lane == 0u {
        atomicStore(&queued[0], size - taken);
    }
    workgroupBarrier();
    for (var i = 0u; i < 4u; i++) {
        if lane + i * GROUP < 4u * taken {
            visit_children(pairs[i], lane % 4u, 0u, 2u * QUEUE);
        }
    }
    workgroupBarrier();
}

// Empties a part of the queue, from the half on that begins it, into global memory.
fn hand_on(lane: u32, half: u32, size: u32) {
    let pairs = tell(lane, min(atomicLoad(&queued[half]), size));
    if pairs != 0u {
        var base = 0u;
        if lane == 0u {
            base = atomicAdd(&counters.fronts[step.pass_index + 1u], pairs);
        }
        base = tell(lane, base);
        for (var i = lane; i < pairs; i += GROUP) {
            add_to_front(base + i, queue[half * QUEUE + i]);
        }
    }
}

fn write_leaf_pairs(lane: u32) {
    if lane == 0u && tested != 0u {
        atomicAdd(&counters.node_pairs, tested);
    }
    tested = 0u;
    let leaf_pairs = tell(lane, min(atomicLoad(&found_count), FOUND));
    if leaf_pairs != 0u {
        var base = 0u;
        if lane == 0u {
            base = atomicAdd(&counters.leaves, leaf_pairs);
        }
        base = tell(lane, base);
        for (var i = lane; i < leaf_pairs; i += GROUP) {
            add_leaf_pair(base + i, found[i]);
        }
    }
}

fn add_to_front(slot: u32, pair: vec2u) {
    if slot < query.front_capacity {
        front_out[slot] = pair;
    } else {
        overflowed(FRONT_OVERFLOW);
    }
}

fn add_leaf_pair(slot: u32, runs: vec2u) {
    if slot < query.leaf_capacity {
        leaves[slot] = runs;
    } else {
        overflowed(LEAF_OVERFLOW);
    }
}
