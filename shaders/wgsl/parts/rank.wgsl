// Some hits in workgroup memory, and the rank of one among them: how many precede it.

const RANKED = max(BUCKET, BUCKETS);

// No hit is there twice.
var<workgroup> ranked: array<vec2u, RANKED>;

// How many of a stretch of hits precede one. The stretch begins at a multiple of 4, and what lies between its end and the next
// multiple sorts after any hit.
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
