//! Random numbers: ChaCha with eight rounds, the same from the same seed on every machine.

pub use rand::{Rng, RngExt, seq};
pub use rand_chacha::ChaCha8Rng;

/// The generator with a seed.
pub fn seeded(seed: u64) -> ChaCha8Rng {
    rand::SeedableRng::seed_from_u64(seed)
}

/// Any finite bit pattern.
pub fn finite(rng: &mut impl Rng) -> f32 {
    loop {
        let x = f32::from_bits(rng.random());
        if x.is_finite() {
            return x;
        }
    }
}
