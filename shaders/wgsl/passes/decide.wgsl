// Reads the triangle pairs that are left, writes those that meet, and the few for the CPU.
//
// Two kinds of work take turns: deciding pairs that are not known to meet in f32, one an invocation, and those that f32
// leaves open in integers, one a team.

var<workgroup> waiting: array<vec2u, 2 * GROUP>;
var<workgroup> waiting_count: atomic<u32>;
// For each team: its corners, whether they are in doubt, the bits of each axis, and the signs of two
// rounds. Doubts are numbers: as truth values in workgroup memory, an H200 read them as false. The cause is
// not known. Idle teams then read memory that nothing had written, which they no longer do.
var<workgroup> corners: array<Corner, TEAMS * POINTS>;
var<workgroup> doubts: array<u32, TEAMS * POINTS>;
var<workgroup> widths: array<u32, TEAMS * 3>;
var<workgroup> first_signs: array<i32, TEAMS * POINTS>;
var<workgroup> second_signs: array<i32, TEAMS * TEAM>;

@compute @workgroup_size(GROUP)
fn decide(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    nothing = group.z;
    if lane == 0u {
        atomicStore(&waiting_count, 0u);
    }
    clear_results(lane);
    if lane == 0u {
        told = min(atomicLoad(&counters.kept), query.kept_capacity);
    }
    let length = workgroupUniformLoad(&told);
    let mine = share(length, group.x, groups.x);
    var next = 0u;
    var left_open = 0u;
    for (var round = 0u; ; round++) {
        if round >= MOST_ROUNDS {
            overflowed(WORK_OVERFLOW);
            break;
        }
        if has_answer(lane) {
            break;
        }
        let ready = tell(lane, atomicLoad(&waiting_count));
        if ready < TEAMS && next < mine {
            if next + lane < mine {
                decide_in_f32(kept[group.x + (next + lane) * groups.x]);
            }
            next += GROUP;
            workgroupBarrier();
        } else if ready > 0u {
            let taken = min(ready, TEAMS);
            decide_in_integers(lane, ready - taken, taken);
            if lane == 0u {
                atomicStore(&waiting_count, ready - taken);
            }
            left_open += taken;
        } else {
            break;
        }
        make_room(lane);
    }
    write_results(lane);
    if lane == 0u && left_open != 0u {
        atomicAdd(&counters.open, left_open);
    }
}

fn decide_in_f32(found: vec2u) {
    let slots = found & vec2u(~0u, ~CERTIFIED);
    var outcome = HIT;
    if (found.y & CERTIFIED) == 0u {
        outcome = outcome_in_f32(slots);
    }
    if outcome == UNSURE {
        waiting[atomicAdd(&waiting_count, 1u)] = slots;
    } else if outcome == HIT {
        add_hit(slots);
    }
}

// Decides so many of those that wait, from one of them on.
fn decide_in_integers(lane: u32, first: u32, count: u32) {
    let team = lane / TEAM;
    let member = lane % TEAM;
    lattice_at = team * 3u * POINTS;
    let is_busy = team < count;
    let slots = waiting[first + min(team, count - 1u)];
    if is_busy && member < POINTS {
        doubt = false;
        corners[team * POINTS + member] = placed_corner(slots, member);
        doubts[team * POINTS + member] = select(0u, 1u, doubt);
    }
    workgroupBarrier();
    if is_busy && member < 3u {
        widths[team * 3u + member] = place_on_lattice(member);
    }
    workgroupBarrier();
    // Workgroup memory is not zeroed: a team reads only what it has written.
    var pair: Pair;
    var is_asked = false;
    if is_busy {
        pair = pair_of(team);
        is_asked = fit_in_integers(team) && pair.shared_corners < 3u;
    }
    if is_asked && member < POINTS {
        first_signs[team * POINTS + member] = side_of_corner(pair, member);
    }
    workgroupBarrier();
    var sides: Sides;
    var asked = MISS;
    if is_asked {
        sides = sides_of(team);
        asked = question(pair, sides);
    }
    if asked != MISS {
        second_signs[team * TEAM + member] = reply(pair, sides, asked, member);
    }
    workgroupBarrier();
    if is_busy && member == 0u {
        var outcome = select(UNSURE, MISS, is_asked);
        if asked != MISS {
            outcome = conclusion(sides, pair, asked, replies(team));
        }
        if outcome == HIT {
            add_hit(slots);
        } else if outcome == UNSURE {
            add_open(slots);
        }
    }
    workgroupBarrier();
}

fn placed_corner(slots: vec2u, member: u32) -> Corner {
    let corner = corner_at(slots, member);
    let side = member / 3u;
    if !is_posed(side) {
        return corner;
    }
    return Corner(posed_position(rows_of(side), corner.position), corner.vertex);
}

// The bits of a coordinate of this team's.
fn coordinate(axis: u32, point: u32) -> u32 {
    return bitcast<u32>(corners[lattice_at / 3u + point].position[axis]);
}

// A triangle that names a vertex twice is rare, and has rules of its own: 3 shared corners.
fn pair_of(team: u32) -> Pair {
    let at = team * POINTS;
    let a = vec3u(corners[at].vertex, corners[at + 1u].vertex, corners[at + 2u].vertex);
    let b = vec3u(corners[at + 3u].vertex, corners[at + 4u].vertex, corners[at + 5u].vertex);
    let sharing = sharing_of(a, b);
    let own = rotated(vec3u(0u, 1u, 2u), sharing.first.x);
    let other = rotated(vec3u(3u, 4u, 5u), sharing.first.y);
    let is_odd = sharing.count != 0u && sharing.repeats;
    return Pair(own, other, select(sharing.count, 3u, is_odd));
}

fn fit_in_integers(team: u32) -> bool {
    for (var i = 0u; i < POINTS; i++) {
        if doubts[team * POINTS + i] != 0u {
            return false;
        }
    }
    let bits = vec3u(widths[team * 3u], widths[team * 3u + 1u], widths[team * 3u + 2u]);
    short = all(bits < vec3u(32u));
    return bits.x + bits.y + bits.z <= MOST_BITS;
}

fn sides_of(team: u32) -> Sides {
    let at = team * POINTS;
    return Sides(
        vec3i(first_signs[at], first_signs[at + 1u], first_signs[at + 2u]),
        vec3i(first_signs[at + 3u], first_signs[at + 4u], first_signs[at + 5u]),
    );
}

fn replies(team: u32) -> array<i32, TEAM> {
    var all: array<i32, TEAM>;
    for (var i = 0u; i < TEAM; i++) {
        all[i] = second_signs[team * TEAM + i];
    }
    return all;
}
