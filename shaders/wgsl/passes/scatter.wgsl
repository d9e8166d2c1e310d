// Reads entries and the table, writes the entries in the order of their digit.
//
// A workgroup takes as many entries at once as it has invocations. Each sets its bit in the mask of its
// digit; the bits below it are the entries with that digit that go first.

const WORDS = (GROUP + 31u) / 32u;

// Where the next entry with each digit goes.
var<workgroup> next: array<u32, DIGITS>;
// Two sets, one being cleared while the other is filled.
var<workgroup> masks: array<atomic<u32>, 2 * DIGITS * WORDS>;

@compute @workgroup_size(GROUP)
fn scatter(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    for (var i = lane; i < 2u * DIGITS * WORDS; i += GROUP) {
        atomicStore(&masks[i], 0u);
    }
    place_digits(lane, group.x);
    workgroupBarrier();

    let run = run_of(group.x);
    var half = 0u;
    // Loaded a turn ahead.
    var upcoming = entries_in[min(run.x + lane, run.y - 1u)];
    for (var start = run.x; start < run.y; start += GROUP) {
        let entry = upcoming;
        upcoming = entries_in[min(start + GROUP + lane, run.y - 1u)];
        let mine = start + lane < run.y;
        let own = digit(entry.x);
        if mine {
            atomicOr(&masks[half + own * WORDS + lane / 32u], 1u << (lane % 32u));
        }
        workgroupBarrier();
        var ahead = 0u;
        var alike = 0u;
        if mine {
            for (var word = 0u; word < WORDS; word++) {
                let mask = atomicLoad(&masks[half + own * WORDS + word]);
                alike += countOneBits(mask);
                ahead += countOneBits(mask & lower(lane, word));
            }
            entries_out[next[own] + ahead] = entry;
        }
        workgroupBarrier();
        if mine & (ahead == 0u) {
            next[own] += alike;
            for (var word = 0u; word < WORDS; word++) {
                atomicStore(&masks[half + own * WORDS + word], 0u);
            }
        }
        half = DIGITS * WORDS - half;
    }
}

// The bits of a word that belong to invocations before this one.
fn lower(lane: u32, word: u32) -> u32 {
    if word == lane / 32u {
        return (1u << (lane % 32u)) - 1u;
    }
    return select(0u, 0xffffffffu, word < lane / 32u);
}

// All lower digits go first, and entries of the runs before this one.
fn place_digits(lane: u32, group: u32) {
    const share = (DIGITS + GROUP - 1u) / GROUP;
    let mine = min(vec2u(lane, lane + 1u) * share, vec2u(DIGITS));
    var sum = 0u;
    for (var digit = mine.x; digit < mine.y; digit++) {
        sum += totals[digit];
    }
    var start = before(lane, sum);
    for (var digit = mine.x; digit < mine.y; digit++) {
        next[digit] = start + table[digit * build.workgroups + group];
        start += totals[digit];
    }
}
