//! Boxes and triangles side by side in vector registers.
//!
//! A walk spends its time on tests that are too small for a vector unit: one pair of boxes is six
//! comparisons, one corner against a plane is three products. So it goes down two levels of both trees
//! in one step, with up to four nodes on either side, and tests all pairs of them ([`Family`]); and it
//! tests the triangles of a leaf eight at a time, for overlap and for lying on one side of another's
//! plane ([`Block`]). Both read the canonical arrays, which are put into lanes as they are loaded. A
//! wide layout would save that work, a tenth of the time, cost twice the memory of the nodes and a
//! pass after every refit, and could not start from any node of a front.
//!
//! The code is written once over [`Simd`], and compiled twice where a processor may turn out to have
//! AVX2 (`avx`).

#[cfg(all(target_arch = "x86_64", any(feature = "std", target_feature = "avx2")))]
mod avx2;
mod box4;
mod lanes;
pub(crate) mod point8;

pub(crate) use box4::Box4;
#[cfg(test)]
pub(crate) use lanes::Halves;
pub(crate) use lanes::{Eight, LANES, Simd, Task, VECTORS, widest};
