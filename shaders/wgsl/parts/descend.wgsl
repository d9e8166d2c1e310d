// The depth-bounded descent (Zhang & Kim 2014, section 4): a workgroup takes node pairs into its own
// memory, goes down `step.levels` levels breadth-first, and hands on what is left: node pairs to
// the next front, leaf pairs to their list, each with one addition to a counter in global memory.
//
// A front holds node pairs whose boxes overlap, and of each node not its index but where its children
// are (LEAF and its own index if it has none). Four invocations take one pair, and each tests
// one pair of children: a level costs one load of nodes, not a load of parents and then one of
// children. What does not fit in workgroup memory goes straight to the next front, so that nothing is
// lost; the host sees a front left over after the last pass and goes on from it.

const LEAF = 0x80000000u;

// Two halves, read and written in turn.
var<workgroup> queue: array<vec2u, 2 * QUEUE>;
var<workgroup> queued: array<atomic<u32>, 2>;
var<workgroup> found: array<vec2u, FOUND>;
var<workgroup> found_count: atomic<u32>;

fn clear_queues(lane: u32) {
    if lane == 0u {
        atomicStore(&queued[0], 0u);
        atomicStore(&queued[1], 0u);
        atomicStore(&found_count, 0u);
    }
    workgroupBarrier();
}

fn reference(index: u32, node: Node) -> u32 {
    return select(node.first, index | LEAF, node.count != 0u);
}

// A leaf as the narrow phase wants it: its triangles. Slots stay below 2^28, because 2^28 triangles
// of 48 bytes are more than any binding holds.
fn leaf_run(node: Node) -> u32 {
    return node.first | ((node.count - 1u) << LEAF_SHIFT);
}

// Puts a pair of nodes in its place, if their boxes overlap.
fn visit(a: u32, b: u32, half: u32) {
    let own = nodes_a[a];
    let other = nodes_b[b];
    if !overlap(placed_box(0u, Box(own.min, own.max)), placed_box(1u, Box(other.min, other.max))) {
        return;
    }
    if (own.count != 0u) & (other.count != 0u) & (step.keep_leaves == 0u) {
        let runs = vec2u(leaf_run(own), leaf_run(other));
        let slot = atomicAdd(&found_count, 1u);
        if slot < FOUND {
            found[slot] = runs;
        } else {
            add_leaf_pair(atomicAdd(&counters.leaves, 1u), runs);
        }
        return;
    }
    let pair = vec2u(reference(a, own), reference(b, other));
    let slot = atomicAdd(&queued[half], 1u);
    if slot < QUEUE {
        queue[half * QUEUE + slot] = pair;
    } else {
        add_to_front(atomicAdd(&counters.fronts[step.pass_index + 1u], 1u), pair);
    }
}

// Tests one of the four pairs of children.
fn visit_children(pair: vec2u, which: u32, half: u32) {
    let right = vec2u(which & 1u, which >> 1u);
    let leaf = (pair & vec2u(LEAF)) != vec2u(0u);
    if any(leaf & (right != vec2u(0u))) {
        return;
    }
    // A node with itself has three children: (l, l), (r, r) and (l, r).
    if (query.within == 1u) & (pair.x == pair.y) & (which == 1u) {
        return;
    }
    let child = select(pair + right, pair & vec2u(~LEAF), leaf);
    visit(child.x, child.y, half);
}

// Descends from what is in the first half of the queue.
fn descend(lane: u32) {
    var level = 0u;
    loop {
        let half = level & 1u;
        if lane == 0u {
            told = select(min(atomicLoad(&queued[half]), QUEUE), 0u, level == step.levels);
        }
        let pairs = workgroupUniformLoad(&told);
        if pairs == 0u {
            break;
        }
        if lane == 0u {
            atomicStore(&queued[half], 0u);
        }
        for (var i = lane; i < 4u * pairs; i += GROUP) {
            visit_children(queue[half * QUEUE + i / 4u], i % 4u, 1u - half);
        }
        workgroupBarrier();
        level++;
    }
    hand_on(lane, level & 1u);
}

// Empties the queues into global memory.
fn hand_on(lane: u32, half: u32) {
    let pairs = tell(lane, min(atomicLoad(&queued[half]), QUEUE));
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
