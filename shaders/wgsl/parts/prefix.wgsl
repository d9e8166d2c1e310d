// Sums over the invocations of a workgroup.

var<workgroup> sums: array<u32, GROUP>;

// The sum of the values of the invocations before this one (Hillis & Steele 1986).
fn before(lane: u32, value: u32) -> u32 {
    sums[lane] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < GROUP; reach *= 2u) {
        var sum = sums[lane];
        if lane >= reach {
            sum += sums[lane - reach];
        }
        workgroupBarrier();
        sums[lane] = sum;
        workgroupBarrier();
    }
    return sums[lane] - value;
}
