// Sorting the hits: a sample of them, in order, divides them into buckets, and a workgroup sorts each
// bucket (sample sort, Frazer & McKellar 1970). Three dispatches whatever there is to sort, where a radix
// sort would take three for each digit. Where a bucket gets more than it can hold, the hits stay
// as they are, and the host, which is told, sorts them. Where few are expected, one dispatch ranks each among
// all others instead.

struct Buckets {
    // Where each but the first begins.
    splitters: array<vec2u, BUCKETS>,
    // How many hits each has been dealt.
    dealt: array<atomic<u32>, BUCKETS>,
}

@group(0) @binding(0) var<uniform> query: Query;
@group(1) @binding(0) var<storage, read_write> counters: Counters;
@group(1) @binding(1) var<storage, read_write> hits: array<vec2u>;
// Free when hits are sorted: `room` hits for each bucket.
@group(1) @binding(2) var<storage, read_write> kept: array<vec2u>;
@group(1) @binding(3) var<storage, read_write> buckets: Buckets;
// In order: where the leaf pairs were, which nothing reads any more.
@group(1) @binding(4) var<storage, read_write> sorted: array<vec2u>;
// Triangle pairs for the CPU, by vectors of words.
@group(1) @binding(5) var<storage, read_write> rest: array<vec4u>;

// How many hits there are, from the first invocation of a workgroup: thousands that load one word wait for each other.
fn hit_count(lane: u32) -> u32 {
    if lane == 0u {
        told = min(atomicLoad(&counters.hits), query.hit_capacity);
    }
    return workgroupUniformLoad(&told);
}

// How many hits a bucket can hold.
fn room() -> u32 {
    return min(BUCKET, query.kept_capacity / BUCKETS);
}

fn precedes(p: vec2u, q: vec2u) -> bool {
    return p.x < q.x || (p.x == q.x && p.y < q.y);
}
