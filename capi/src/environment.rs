//! Tests of calls in another floating-point environment than the default, which
//! [`with_default`](pfront_core::environment::with_default) sets.

#![expect(
    unsafe_code,
    reason = "only machine code reaches the control register, and C knows only pointers"
)]

use crate::pfront_status_t::PFRONT_OK;
use crate::*;
use core::arch::asm;
use core::mem::zeroed;
use core::ptr::null_mut;

const LEAST: f32 = f32::from_bits(1);
/// A floor, and three blades whose tips are above it, on it and below it by the smallest number.
const POINTS: [[f32; 3]; 9] = [
    [0.0, 0.0, 0.0],
    [4.0, 0.0, 0.0],
    [0.0, 4.0, 0.0],
    [1.0, 1.0, LEAST],
    [1.0, 1.0, 0.0],
    [1.0, 1.0, -LEAST],
    [1.0, 2.0, 3.0],
    [2.0, 1.0, 3.0],
    [1.0, 2.0, -3.0],
];
const CORNERS: [[u32; 3]; 4] = [[0, 1, 2], [3, 6, 7], [4, 6, 7], [5, 6, 7]];

/// From the arrays to the pairs; each call must succeed.
fn pairs_by_way_of_c() -> ([[u32; 2]; 8], usize) {
    // SAFETY: all of these are plain data, for which zeros are a value; every pointer is null or leads to a live
    // array of the length that goes with it.
    unsafe {
        let (mut nodes, mut order) = ([zeroed::<pfront_node_t>(); 8], [0; 4]);
        let (mut mesh, mut bvh) = (zeroed(), zeroed());
        let (mut query, mut cursor) = (zeroed(), zeroed());
        let (mut page, mut count) = ([zeroed::<pfront_pair_t>(); 8], 0);
        let mut scratch = [0_u8; 256];
        let memory = pfront_bvh_memory_t {
            nodes: nodes.as_mut_ptr(),
            node_capacity: nodes.len(),
            order: order.as_mut_ptr(),
            order_capacity: order.len(),
            scratch: scratch.as_mut_ptr().cast(),
            scratch_bytes: scratch.len(),
        };
        let (points, corners) = (POINTS.as_ptr().cast(), CORNERS.as_ptr().cast());
        let (error, all) = (null_mut(), u64::MAX);
        let statuses = [
            pfront_mesh_check(points, POINTS.len(), corners, CORNERS.len(), &mut mesh, error),
            pfront_bvh_build_morton(&mesh, 1, &memory, &mut bvh, error),
            pfront_query_self(&bvh, null_mut(), 0, &mut query, error),
            pfront_cursor_start(&query, &mut cursor, error),
            pfront_query_step(&query, &mut cursor, all, page.as_mut_ptr(), 8, &mut count, error),
        ];
        assert_eq!(statuses, [PFRONT_OK; 5]);
        (page.map(|pair| [pair.a, pair.b]), count)
    }
}

fn read() -> u32 {
    let mut register = 0_u32;
    // SAFETY: writes the four bytes of `register`.
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut register) };
    register
}

fn write(register: u32) {
    // SAFETY: reads the four bytes of `register`, in which no reserved bit is set.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const register) };
}

#[test]
fn answers_are_those_of_the_default_environment() {
    let (expected, count) = pairs_by_way_of_c();
    let with_floor = expected[..count].iter().filter(|pair| pair[0] == 0).count();
    assert_eq!(with_floor, 2, "the tips on the floor and below it");
    // Flushed operands and results with the flag of a past exception, as `-ffast-math` leaves it; each rounding.
    for callers in [0x9fe0, 0x3f80, 0x5f80, 0x7f80] {
        write(callers);
        let (found, restored) = (pairs_by_way_of_c(), read());
        write(0x1f80);
        assert_eq!(found, (expected, count), "{callers:x}");
        assert_eq!(restored, callers);
    }
}
