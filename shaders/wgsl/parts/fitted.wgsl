// Boxes around two others, or around some triangles.
//
// A workgroup reads the boxes that it has fitted from its own memory. In storage they are only written:
// a barrier orders the storage accesses of a workgroup in WGSL, but naga 30 does not decorate the buffer
// as coherent, and where invocations of a workgroup have caches of their own they may read old boxes
// (gfx-rs/wgpu#9221). Boxes that an earlier dispatch has written are read from storage.

@group(0) @binding(0) var<storage, read_write> nodes: array<Node>;
@group(0) @binding(1) var<storage, read_write> corners: array<Corner>;

// A box in integers (`ordered`).
struct Extent {
    low: vec3i,
    high: vec3i,
}

// The boxes of a job by slot, three coordinates each, without the padding of a vec3i.
var<workgroup> lows: array<i32, 3 * JOB>;
var<workgroup> highs: array<i32, 3 * JOB>;

fn keep(slot: u32, box: Extent) {
    let at = 3u * slot;
    lows[at] = box.low.x;
    lows[at + 1u] = box.low.y;
    lows[at + 2u] = box.low.z;
    highs[at] = box.high.x;
    highs[at + 1u] = box.high.y;
    highs[at + 2u] = box.high.z;
}

fn kept_box(slot: u32) -> Extent {
    let at = 3u * slot;
    return Extent(
        vec3i(lows[at], lows[at + 1u], lows[at + 2u]),
        vec3i(highs[at], highs[at + 1u], highs[at + 2u]),
    );
}

// The box of a node that an earlier dispatch has fitted.
fn earlier_box(index: u32) -> Extent {
    return Extent(ordered(nodes[index].min), ordered(nodes[index].max));
}

fn around(left: Extent, right: Extent) -> Extent {
    return Extent(min(left.low, right.low), max(left.high, right.high));
}

fn write_node(index: u32, box: Extent, first: u32, count: u32) {
    nodes[index] = Node(unordered(box.low), first, unordered(box.high), count);
}

// Moves the corners, too.
fn leaf_box(first: u32, count: u32) -> Extent {
    var low = vec3i(0x7fffffff);
    var high = -low;
    for (var slot = first; slot < first + count; slot++) {
        // Three loads that do not wait for one another.
        let a = position(corners[3u * slot].vertex);
        let b = position(corners[3u * slot + 1u].vertex);
        let c = position(corners[3u * slot + 2u].vertex);
        corners[3u * slot].position = a;
        corners[3u * slot + 1u].position = b;
        corners[3u * slot + 2u].position = c;
        low = min(min(low, ordered(a)), min(ordered(b), ordered(c)));
        high = max(max(high, ordered(a)), max(ordered(b), ordered(c)));
    }
    return Extent(low, high);
}
