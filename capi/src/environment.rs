//! The floating-point environment of a call: IEEE 754's default, whatever that of the caller is.
//!
//! C hosts may run in another one: `-ffast-math` and audio libraries flush subnormal numbers, others set a
//! rounding mode. Rust is not defined there and signs of small determinants come out wrong, so each call
//! saves the control register, sets the default if it differs, and restores what was there.
//!
//! On other processors than those below nothing is set, and `pfront_mesh_check` refuses what
//! [`pfront_core::MeshError::FloatEnvironment`] says.

#![cfg_attr(
    all(any(target_arch = "x86_64", target_arch = "aarch64"), not(miri)),
    expect(unsafe_code, reason = "only machine code reaches the control register")
)]

use control::{read, write};

/// Runs `body` in the default environment and restores that of the caller.
///
/// The body is a call of its own between two blocks of assembly that may change any memory: its operands are
/// loaded after the first and its results stored before the second, so that no arithmetic moves out.
pub(crate) fn with_default<T>(body: impl FnOnce() -> T) -> T {
    #[inline(never)]
    fn apart<T>(body: impl FnOnce() -> T) -> T {
        body()
    }
    let callers = read();
    let differs = callers & control::SETTINGS != control::DEFAULT;
    if differs {
        write(control::DEFAULT);
    }
    let answer = apart(body);
    if differs {
        write(callers);
    }
    answer
}

/// MXCSR. Miri has no assembly.
#[cfg(all(target_arch = "x86_64", not(miri)))]
mod control {
    use core::arch::asm;

    /// Everything but the flags of past exceptions: flushing, rounding, and which exceptions trap.
    pub(super) const SETTINGS: u32 = 0xffc0;
    pub(super) const DEFAULT: u32 = 0x1f80;

    pub(super) fn read() -> u32 {
        let mut register = 0_u32;
        // SAFETY: writes the four bytes of `register`, and changes neither flags nor the stack.
        unsafe {
            asm!("stmxcsr [{}]", in(reg) &raw mut register, options(nostack, preserves_flags));
        }
        register
    }

    pub(super) fn write(register: u32) {
        // SAFETY: reads the four bytes of `register`. No reserved bit is set: the value is the default or was read.
        unsafe {
            asm!("ldmxcsr [{}]", in(reg) &raw const register, options(nostack, preserves_flags));
        }
    }
}

/// FPCR.
#[cfg(all(target_arch = "aarch64", not(miri)))]
mod control {
    use core::arch::asm;

    pub(super) const SETTINGS: u64 = u64::MAX;
    pub(super) const DEFAULT: u64 = 0;

    pub(super) fn read() -> u64 {
        let register;
        // SAFETY: reads a register that every program may read.
        unsafe { asm!("mrs {}, fpcr", out(reg) register, options(nostack, preserves_flags)) };
        register
    }

    pub(super) fn write(register: u64) {
        // SAFETY: writes a register that every program may write, the default or what was read.
        unsafe { asm!("msr fpcr, {}", in(reg) register, options(nostack, preserves_flags)) };
    }
}

#[cfg(any(miri, not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod control {
    pub(super) const SETTINGS: u32 = 0;
    pub(super) const DEFAULT: u32 = 0;

    pub(super) fn read() -> u32 {
        DEFAULT
    }

    pub(super) fn write(_: u32) {}
}

#[cfg(all(test, target_arch = "x86_64", not(miri)))]
mod tests {
    use super::*;
    use crate::pfront_accuracy_t::PFRONT_EXACT;
    use crate::pfront_status_t::PFRONT_OK;
    use crate::*;
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
            let (error, exact, all) = (null_mut(), PFRONT_EXACT as u32, u64::MAX);
            let statuses = [
                pfront_mesh_check(points, POINTS.len(), corners, CORNERS.len(), &mut mesh, error),
                pfront_bvh_build_morton(&mesh, 1, &memory, &mut bvh, error),
                pfront_query_self(&bvh, null_mut(), 0, exact, &mut query, error),
                pfront_cursor_start(&query, &mut cursor, error),
                pfront_query_step(
                    &query,
                    &mut cursor,
                    all,
                    page.as_mut_ptr(),
                    8,
                    &mut count,
                    error,
                ),
            ];
            assert_eq!(statuses, [PFRONT_OK; 5]);
            (page.map(|pair| [pair.a, pair.b]), count)
        }
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
            write(control::DEFAULT);
            assert_eq!(found, (expected, count), "{callers:x}");
            assert_eq!(restored, callers);
        }
    }
}
