// Vertices that two triangles of one mesh share by index.

struct Sharing {
    // How many corners of each are shared; 0 between two meshes.
    count: u32,
    // Whether one of them names a vertex twice.
    repeats: bool,
    // From which corner on to read each: the shared corners come first.
    first: vec2u,
}

struct SharedCorners {
    a: vec3<bool>,
    b: vec3<bool>,
}

// Corners of each triangle that are corners of the other too; none between two meshes.
fn shared_corners_of(a: vec3u, b: vec3u) -> SharedCorners {
    let within = vec3<bool>(query.within == 1u);
    let own = (a == b) | (a == b.yzx) | (a == b.zxy);
    let other = (b == a) | (b == a.yzx) | (b == a.zxy);
    return SharedCorners(own & within, other & within);
}

fn repeats(a: vec3u, b: vec3u) -> bool {
    return any((a == a.yzx) | (b == b.yzx));
}

fn sharing_of(a: vec3u, b: vec3u) -> Sharing {
    let corners = shared_corners_of(a, b);
    let count = countOneBits(bits_of_corners(corners.a));
    let first = vec2u(first_shared(corners.a), first_shared(corners.b));
    return Sharing(count, repeats(a, b), first);
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
