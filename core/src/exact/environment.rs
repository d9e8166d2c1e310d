//! The floating-point environment that every bound in this crate relies on: IEEE 754's default, which
//! rounds to nearest and keeps subnormal numbers.
//!
//! Compilers assume this environment, so Rust cannot be made right in another one. Hosts that were
//! built with `-ffast-math`, audio software above all, change it on their threads all the same, and
//! signs of small determinants then come out wrong without notice. One look at the start of a frame
//! turns that into an error.

use core::hint::black_box;

/// Whether this thread rounds to nearest and keeps subnormal operands and results.
pub(crate) fn is_default() -> bool {
    // The optimizer would compute all of this at compile time, in the default environment.
    let [one, least_normal, least, tiny] =
        [1.0, f32::MIN_POSITIVE, f32::from_bits(1), 1e-30].map(black_box);
    let keeps_results = (least_normal * 0.5).to_bits() == f32::MIN_POSITIVE.to_bits() >> 1;
    let keeps_operands = least * f32::MAX > 0.0;
    keeps_results && keeps_operands && one + tiny == 1.0 && one - tiny == 1.0
}

#[cfg(all(test, target_arch = "x86_64"))]
#[expect(unsafe_code, reason = "only machine code can leave the default environment")]
mod tests {
    use super::*;
    use crate::{Mesh, MeshError};
    use core::arch::asm;

    /// Returns the result of `check` while the control register of SSE holds `mxcsr`.
    #[inline(never)]
    fn under<T>(mxcsr: u32, check: fn() -> T) -> T {
        const DEFAULT: u32 = 0x1f80;
        // SAFETY: both instructions only read memory that is there.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &mxcsr) };
        let found = check();
        // SAFETY: as above.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &DEFAULT) };
        found
    }

    #[test]
    fn every_other_environment_is_noticed() {
        assert!(under(0x1f80, is_default));
        assert!(under(0x1f80 | 0x3f, is_default), "flags of earlier exceptions change nothing");
        // Flushed results, flushed operands, both, rounded down, up and towards zero.
        for other in [0x8000, 0x0040, 0x8040, 0x2000, 0x4000, 0x6000] {
            assert!(!under(0x1f80 | other, is_default), "{other:x}");
        }
    }

    #[test]
    fn meshes_are_refused_in_another_environment() {
        const POINTS: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        const TRIANGLES: [[u32; 3]; 1] = [[0, 1, 2]];
        let made = || Mesh::new(&POINTS, &TRIANGLES).err();
        let moved = || Mesh::new_unchecked(&POINTS, &TRIANGLES).with_positions(&POINTS).err();
        assert_eq!([under(0x1f80, made), under(0x1f80, moved)], [None; 2]);
        let refused = Some(MeshError::FloatEnvironment);
        assert_eq!([under(0x9fc0, made), under(0x9fc0, moved)], [refused; 2]);
    }
}
