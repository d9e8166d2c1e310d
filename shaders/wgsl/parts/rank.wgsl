// The rank of a hit among others in workgroup memory: how many precede it. For a hundred or so,
// comparing all with all takes less time than the barriers of a sorting network.

const RANKED = max(BUCKET, BUCKETS);

// No hit is there twice.
var<workgroup> ranked: array<vec2u, RANKED>;

// Makes the number of hits a multiple of 4, by entries that sort after any.
fn pad_ranked(lane: u32, length: u32) {
    if lane < 3u && length + lane < RANKED {
        ranked[length + lane] = vec2u(0xffffffffu);
    }
}

// How many of a stretch of hits precede one; the stretch begins at a multiple of 4.
fn rank_among(own: vec2u, first: u32, end: u32) -> u32 {
    var rank = vec4u(0u);
    for (var i = first; i < end; i += 4u) {
        let four = vec4<bool>(
            precedes(ranked[i], own),
            precedes(ranked[i + 1u], own),
            precedes(ranked[i + 2u], own),
            precedes(ranked[i + 3u], own),
        );
        rank += select(vec4u(0u), vec4u(1u), four);
    }
    return rank.x + rank.y + rank.z + rank.w;
}
