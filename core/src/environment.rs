//! The floating-point environment that every bound in this crate relies on: IEEE 754's default, which rounds to nearest and
//! keeps subnormal numbers.
//!
//! Hosts that were built with `-ffast-math`, and audio software, change it on their threads, and a thread begins with that of the
//! thread that made it. Compilers assume the default, so signs of small determinants come out wrong in another one. Each
//! call and each job of a pool therefore saves the control register, sets the default if it differs, and restores what was
//! there: [`with_default`]. Meshes are refused where no default could be set: [`is_default`].

#![cfg_attr(
    all(any(target_arch = "x86_64", target_arch = "aarch64"), not(miri)),
    expect(unsafe_code, reason = "only machine code reaches the control register")
)]

use control::{read, write};
use core::hint::black_box;

/// Runs `body` in the default environment, and restores that of the caller, also if `body` panics.
///
/// The control register is that of SSE on x86-64, MXCSR, and FPCR on AArch64. On other processors nothing is set.
///
/// # Complexity
/// One read of the register where it holds the default; two writes more where it does not.
///
/// # Examples
/// ```
/// use pfront_core::environment::{is_default, with_default};
/// assert!(with_default(is_default));
/// ```
pub fn with_default<T>(body: impl FnOnce() -> T) -> T {
    Environment::DEFAULT.run(body)
}

/// The floating-point environment of a thread, for a body in the default one that calls back.
///
/// # Examples
/// ```
/// use pfront_core::environment::{Environment, with_default};
/// let callers = Environment::current();
/// let visit = |number: f32| assert!(number < 1.0); // as the caller rounds and flushes
/// with_default(|| callers.run(|| visit(0.5)));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Environment(control::Register);

impl Environment {
    /// IEEE 754's default.
    pub const DEFAULT: Self = Self(control::DEFAULT);

    /// The environment of the calling thread.
    #[inline]
    #[must_use]
    pub fn current() -> Self {
        Self(read())
    }

    /// Runs `body` in this environment, as [`with_default`] does in the default one.
    #[inline]
    pub fn run<T>(self, body: impl FnOnce() -> T) -> T {
        /// A call of its own between two blocks of assembly that may change any memory: its operands are loaded after the first
        /// and its results stored before the second, so that no arithmetic moves out.
        #[inline(never)]
        fn apart<T>(body: impl FnOnce() -> T) -> T {
            body()
        }
        let callers = read();
        let _restore = ((callers ^ self.0) & control::SETTINGS != 0).then(|| {
            write(self.0);
            Restore(callers)
        });
        apart(body)
    }
}

/// Restores the control register of the caller when it is dropped.
struct Restore(control::Register);

impl Drop for Restore {
    fn drop(&mut self) {
        write(self.0);
    }
}

/// Whether this thread rounds to nearest and keeps subnormal operands and results.
///
/// # Examples
/// ```
/// assert!(pfront_core::environment::is_default(), "as in every thread of a Rust program");
/// ```
#[must_use]
pub fn is_default() -> bool {
    // The optimizer would compute all of this at compile time, in the default environment.
    let [one, least_normal, least, tiny] =
        [1.0, f32::MIN_POSITIVE, f32::from_bits(1), 1e-30].map(black_box);
    let keeps_results = (least_normal * 0.5).to_bits() == f32::MIN_POSITIVE.to_bits() >> 1;
    let keeps_operands = least * f32::MAX > 0.0;
    keeps_results && keeps_operands && one + tiny == 1.0 && one - tiny == 1.0
}

/// MXCSR. Miri has no assembly.
#[cfg(all(target_arch = "x86_64", not(miri)))]
mod control {
    use core::arch::asm;

    pub(super) type Register = u32;
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

    pub(super) type Register = u64;
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
    pub(super) type Register = u32;
    pub(super) const SETTINGS: u32 = 0;
    pub(super) const DEFAULT: u32 = 0;

    pub(super) fn read() -> u32 {
        DEFAULT
    }

    pub(super) fn write(_: u32) {}
}

#[cfg(all(target_arch = "x86_64", not(miri)))]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mesh, MeshError};

    /// Returns the result of `check` while the control register of SSE holds `mxcsr`.
    #[inline(never)]
    fn under<T>(mxcsr: u32, check: fn() -> T) -> T {
        write(mxcsr);
        let found = check();
        write(control::DEFAULT);
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
    fn the_default_is_set_and_what_was_there_is_restored() {
        for callers in [0x1f80, 0x9f80, 0x1fc0, 0x9fe0, 0x3f80, 0x5f80, 0x7f80, 0x0000] {
            write(callers);
            let seen = with_default(|| (is_default(), read()));
            let after = read();
            write(control::DEFAULT);
            assert!(seen.0 && seen.1 & control::SETTINGS == control::DEFAULT, "{callers:x}");
            assert_eq!(after & control::SETTINGS, callers & control::SETTINGS);
        }
    }

    #[test]
    fn a_body_calls_back_in_the_environment_of_its_caller() {
        for callers in [0x1f80, 0x9fc0, 0x5f80, 0x0000] {
            write(callers);
            let own = Environment::current();
            let seen = with_default(|| (own.run(read), is_default()));
            let after = read();
            write(control::DEFAULT);
            assert!(seen.1);
            assert_eq!([seen.0, after].map(|seen| seen & control::SETTINGS), [callers; 2]);
        }
    }

    #[cfg(feature = "std")]
    #[test]
    fn a_panic_leaves_the_environment_of_the_caller() {
        write(0x9fc0);
        let panicked = std::panic::catch_unwind(|| with_default(|| panic!("on purpose")));
        let after = read();
        write(control::DEFAULT);
        assert!(panicked.is_err() && after & control::SETTINGS == 0x9fc0 & control::SETTINGS);
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
