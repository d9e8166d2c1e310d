// The rank of a hit among others in workgroup memory: how many precede it. For a hundred or so,
// comparing all with all takes less time than the barriers of a sorting network.

const RANKED = max(BUCKET, BUCKETS);

// Two hits in each. No hit is there twice.
var<workgroup> ranked: array<vec4u, RANKED / 2>;

fn put_ranked(index: u32, hit: vec2u) {
    let at = 2u * (index % 2u);
    ranked[index / 2u][at] = hit.x;
    ranked[index / 2u][at + 1u] = hit.y;
}

fn get_ranked(index: u32) -> vec2u {
    let both = ranked[index / 2u];
    return select(both.xy, both.zw, index % 2u == 1u);
}

// What makes the number of hits a multiple of 8: later than any.
fn pad_ranked(lane: u32, length: u32) {
    if lane < 7u && length + lane < RANKED {
        put_ranked(length + lane, vec2u(0xffffffffu));
    }
}

// How many of a stretch of hits precede one; the stretch begins at a multiple of 8.
fn rank_among(own: vec2u, first: u32, end: u32) -> u32 {
    var rank = 0u;
    for (var i = first; i < end; i += 8u) {
        let at = i / 2u;
        let four = vec4u(
            before(ranked[at], own),
            before(ranked[at + 1u], own),
            before(ranked[at + 2u], own),
            before(ranked[at + 3u], own),
        );
        rank += four.x + four.y + four.z + four.w;
    }
    return rank;
}

// How many of two hits precede another.
fn before(two: vec4u, own: vec2u) -> u32 {
    return select(0u, 1u, precedes(two.xy, own)) + select(0u, 1u, precedes(two.zw, own));
}
