// Halving runs of triangles in workgroup memory, level by level, across the axis that leaves the boxes
// of the halves the least surface (as SAH weighs them).
//
// A run has a power of two of slots, and its triangles are in the first of them. To choose an axis, a
// sample of the run is halved across each; then the run is sorted along the one chosen.

const SLOT_BITS = firstLeadingBit(BLOCK);
const EMPTY = 0xffffffffu;
// The most triangles of a sample. Runs that are smaller are taken whole.
const SAMPLE_BITS = 5u;
const SAMPLE = 1u << SAMPLE_BITS;

// Number within the block of the triangle in a slot, in the lowest bits.
var<workgroup> slots: array<u32, BLOCK>;
// Boxes of the triangles and their centres, three coordinates to a word.
var<workgroup> boxes: array<vec2u, BLOCK>;
var<workgroup> centres: array<u32, BLOCK>;
// The centres of samples, and on which side each falls: a bit for each axis.
var<workgroup> sampled: array<u32, BLOCK>;
var<workgroup> sides: array<u32, BLOCK>;
// Costs of halving each run across each axis.
var<workgroup> costs: array<u32, 3 * BLOCK / 2>;

fn pack(v: vec3u) -> u32 {
    return v.x | (v.y << AXIS_BITS) | (v.z << (2u * AXIS_BITS));
}

fn unpack(word: u32) -> vec3u {
    return (vec3u(word) >> vec3u(0u, AXIS_BITS, 2u * AXIS_BITS)) & vec3u((1u << AXIS_BITS) - 1u);
}

// Where a run of a level begins in leaf order.
fn run_start(job: u32, level: u32, run: u32) -> u32 {
    return node_start(build.top + level, (job << level) + run);
}

// How many triangles a run holds, and how many of them its left half.
fn run_counts(job: u32, level: u32, run: u32) -> vec2u {
    let start = run_start(job, level, run);
    let middle = run_start(job, level + 1u, 2u * run + 1u);
    return vec2u(run_start(job, level, run + 1u), middle) - start;
}

fn halve(lane: u32, job: u32, level: u32) {
    sample(lane, job, level);
    workgroupBarrier();
    rank_samples(lane, job, level);
    workgroupBarrier();
    weigh(lane, job, level);
    workgroupBarrier();
    sort_runs(lane, level);
    divide(lane, job, level);
}

// Member i of the sample of a run of so many triangles, as its number within the block.
fn sampled_at(level: u32, run: u32, triangles: u32, i: u32) -> u32 {
    let at = select((i * triangles) >> SAMPLE_BITS, i, triangles <= SAMPLE);
    return slots[(run << (SLOT_BITS - level)) + at] % BLOCK;
}

fn sample(lane: u32, job: u32, level: u32) {
    let room_bits = min(SAMPLE_BITS, SLOT_BITS - level);
    for (var i = lane; i < (1u << (room_bits + level)); i += GROUP) {
        let run = i >> room_bits;
        let member = i - (run << room_bits);
        let triangles = run_counts(job, level, run).x;
        if member < triangles {
            sampled[i] = centres[sampled_at(level, run, triangles, member)];
        }
    }
}

fn rank_samples(lane: u32, job: u32, level: u32) {
    let room_bits = min(SAMPLE_BITS, SLOT_BITS - level);
    for (var i = lane; i < (1u << (room_bits + level)); i += GROUP) {
        let run = i >> room_bits;
        let first = run << room_bits;
        let counts = run_counts(job, level, run);
        let size = min(counts.x, 1u << room_bits);
        if i - first >= size {
            continue;
        }
        let own = unpack(sampled[i]);
        var rank = vec3u(0u);
        for (var other = first; other < first + size; other++) {
            let centre = unpack(sampled[other]);
            let goes_first = (centre < own) | ((centre == own) & vec3<bool>(other < i));
            rank += select(vec3u(0u), vec3u(1u), goes_first);
        }
        let left = max(counts.y * size / counts.x, 1u);
        let right = select(vec3u(0u), vec3u(1u, 2u, 4u), rank >= vec3u(left));
        sides[i] = right.x | right.y | right.z;
    }
}

fn weigh(lane: u32, job: u32, level: u32) {
    let room_bits = min(SAMPLE_BITS, SLOT_BITS - level);
    for (var task = lane; task < (3u << level); task += GROUP) {
        let run = task / 3u;
        let triangles = run_counts(job, level, run).x;
        var left_low = vec3u(EMPTY);
        var left_high = vec3u(0u);
        var right_low = vec3u(EMPTY);
        var right_high = vec3u(0u);
        for (var i = 0u; i < min(triangles, 1u << room_bits); i++) {
            let own = boxes[sampled_at(level, run, triangles, i)];
            let right = ((sides[(run << room_bits) + i] >> (task % 3u)) & 1u) != 0u;
            if right {
                right_low = min(right_low, unpack(own.x));
                right_high = max(right_high, unpack(own.y));
            } else {
                left_low = min(left_low, unpack(own.x));
                left_high = max(left_high, unpack(own.y));
            }
        }
        costs[task] = surface(left_high - left_low) + surface(right_high - right_low);
    }
}

// Half of it, of a box that is a cell larger: flat ones count too.
fn surface(extent: vec3u) -> u32 {
    let e = extent + 1u;
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

// Sorts each run along the axis that costs least (Batcher 1968). Triangles at the same place stay in order.
fn sort_runs(lane: u32, level: u32) {
    let size = BLOCK >> level;
    for (var i = lane; i < BLOCK; i += GROUP) {
        if slots[i] != EMPTY {
            let own = slots[i] % BLOCK;
            let key = (centres[own] >> (AXIS_BITS * axis(i >> (SLOT_BITS - level)))) % (1u << AXIS_BITS);
            slots[i] = (key << (2u * SLOT_BITS)) | (i << SLOT_BITS) | own;
        }
    }
    workgroupBarrier();
    for (var sorted = 2u; sorted <= size; sorted *= 2u) {
        for (var apart = sorted / 2u; apart != 0u; apart /= 2u) {
            for (var pair = lane; pair < BLOCK / 2u; pair += GROUP) {
                let i = 2u * pair - (pair & (apart - 1u));
                let falling = (sorted < size) & ((i & sorted) != 0u);
                let a = slots[i];
                let b = slots[i + apart];
                if (a > b) != falling {
                    slots[i] = b;
                    slots[i + apart] = a;
                }
            }
            workgroupBarrier();
        }
    }
}

fn axis(run: u32) -> u32 {
    let x = costs[3u * run];
    let y = costs[3u * run + 1u];
    let z = costs[3u * run + 2u];
    return select(select(2u, 1u, y <= z), 0u, (x <= y) & (x <= z));
}

// Moves the right half of each run to its own slots.
fn divide(lane: u32, job: u32, level: u32) {
    let size = BLOCK >> level;
    var moved: array<u32, BLOCK / GROUP>;
    for (var turn = 0u; turn < BLOCK / GROUP; turn++) {
        let i = turn * GROUP + lane;
        let at = i & (size - 1u);
        let counts = run_counts(job, level, i >> (SLOT_BITS - level));
        let right = at >= size / 2u;
        let rank = select(at, counts.y + at - size / 2u, right);
        if rank < select(counts.y, counts.x, right) {
            moved[turn] = slots[i - at + rank];
        } else {
            moved[turn] = EMPTY;
        }
    }
    workgroupBarrier();
    for (var turn = 0u; turn < BLOCK / GROUP; turn++) {
        slots[turn * GROUP + lane] = moved[turn];
    }
    workgroupBarrier();
}
