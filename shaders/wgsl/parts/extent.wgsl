// The box of what the invocations of a workgroup have seen, in integers (`ordered`).

var<workgroup> lowest: array<atomic<i32>, 3>;
var<workgroup> highest: array<atomic<i32>, 3>;

fn clear_extent(lane: u32) {
    if lane < 3u {
        atomicStore(&lowest[lane], 0x7fffffff);
        atomicStore(&highest[lane], -0x7fffffff);
    }
    workgroupBarrier();
}

fn add_extent(low: vec3i, high: vec3i) {
    for (var k = 0u; k < 3u; k++) {
        atomicMin(&lowest[k], low[k]);
        atomicMax(&highest[k], high[k]);
    }
    workgroupBarrier();
}

fn extent_low() -> vec3f {
    return unordered(vec3i(atomicLoad(&lowest[0]), atomicLoad(&lowest[1]), atomicLoad(&lowest[2])));
}

fn extent_high() -> vec3f {
    return unordered(
        vec3i(atomicLoad(&highest[0]), atomicLoad(&highest[1]), atomicLoad(&highest[2])),
    );
}
