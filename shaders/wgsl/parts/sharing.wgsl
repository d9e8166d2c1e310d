// Which vertices two triangles of one mesh share by index.

struct Sharing {
    // How many corners of each are shared; 0 between two meshes.
    count: u32,
    // Whether one of them names a vertex twice.
    repeats: bool,
    // From which corner on to read each: the shared corners come first.
    first: vec2u,
}

fn vertices_a(slot: u32) -> vec3u {
    let at = 3u * slot;
    return vec3u(corners_a[at].vertex, corners_a[at + 1u].vertex, corners_a[at + 2u].vertex);
}

fn vertices_b(slot: u32) -> vec3u {
    let at = 3u * slot;
    return vec3u(corners_b[at].vertex, corners_b[at + 1u].vertex, corners_b[at + 2u].vertex);
}

fn sharing_of(slots: vec2u) -> Sharing {
    let a = vertices_a(slots.x);
    let b = vertices_b(slots.y);
    let own = (a == b) | (a == b.yzx) | (a == b.zxy);
    let other = (b == a) | (b == a.yzx) | (b == a.zxy);
    let count = countOneBits(bits_of_corners(own));
    let repeats = any((a == a.yzx) | (b == b.yzx));
    let first = vec2u(first_shared(own), first_shared(other));
    return Sharing(select(0u, count, query.within == 1u), repeats, first);
}

fn bits_of_corners(corners: vec3<bool>) -> u32 {
    let bits = select(vec3u(0u), vec3u(1u, 2u, 4u), corners);
    return bits.x | bits.y | bits.z;
}

// The shared corner that comes after one that is not; the first if all or none are.
fn first_shared(corners: vec3<bool>) -> u32 {
    let begins = bits_of_corners(corners & !corners.zxy);
    return select(countTrailingZeros(begins), 0u, begins == 0u);
}

fn rotated(t: vec3u, first: u32) -> vec3u {
    return select(select(t, t.yzx, first == 1u), t.zxy, first == 2u);
}
