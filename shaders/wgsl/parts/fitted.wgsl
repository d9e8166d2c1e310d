// The node around two others, or around some triangles.

@group(0) @binding(0) var<storage, read_write> nodes: array<Node>;
@group(0) @binding(1) var<storage, read_write> corners: array<Corner>;

fn fitted_inner(first: u32) -> Node {
    let left = nodes[first];
    let right = nodes[first + 1u];
    let low = min(ordered(left.min), ordered(right.min));
    let high = max(ordered(left.max), ordered(right.max));
    return Node(unordered(low), first, unordered(high), 0u);
}

// Moves the corners, too.
fn fitted_leaf(first: u32, count: u32) -> Node {
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
    return Node(unordered(low), first, unordered(high), count);
}
