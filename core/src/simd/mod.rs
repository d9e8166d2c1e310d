//! Boxes and triangles side by side in vector registers.
//!
//! A traversal consists of tests that are too small for a vector unit: one pair of boxes is six comparisons, one
//! corner against a plane is three products. So it descends two levels of both trees in one step and tests all pairs of
//! up to four nodes on either side (`bvtt::wide_node`), and it tests the triangles of a leaf eight at
//! a time, for overlap and for separation by a plane (`bvtt::cull`). Both load the standard arrays into lanes. A wide
//! layout in memory would save the loading, but take twice the memory and a pass after every refit, and a traversal
//! could not start from any node of a front.
//!
//! The code is written once over [`Simd`] (`lanes`), and compiled twice where AVX2 is detected at run time: over one
//! register of eight floats (`avx2`), and over two of four (`portable`). Processors without vector registers have one
//! lane.

#[cfg(all(target_arch = "x86_64", any(feature = "std", target_feature = "avx2")))]
mod avx2;
mod box4;
mod lanes;
pub(crate) mod point8;
mod portable;

pub(crate) use box4::Box4;
pub(crate) use lanes::{LANES, Simd, Task, VECTORS};
pub(crate) use portable::Portable;

/// Does a task in the widest vectors that this processor has, all of [`LANES`] floats.
#[inline]
pub(crate) fn widest<T: Task>(task: T) -> T::Output {
    #[cfg(all(target_arch = "x86_64", any(feature = "std", target_feature = "avx2")))]
    if avx2::is_here() {
        return avx2::run(task);
    }
    run_portable(task)
}

/// A function of its own, so that its stack frame does not add to that of wider registers.
#[inline(never)]
fn run_portable<T: Task>(task: T) -> T::Output {
    task.run::<Portable>()
}
