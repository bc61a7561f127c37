//! What tests share: seeded random numbers and small pictures.

use cullet_scene::Image;
use fearless_simd::{Fallback, Level};
use proptest::test_runner::{Config, RngSeed};

/// SplitMix64 (Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }

    /// In `[0, 1)`, on a grid of 2^-24.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
}

/// Every instruction set this machine has, plain scalar code last.
pub fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = vec![("best", best)];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_avx2().map(|token| ("avx2", Level::Avx2(token))));
        levels.extend(best.as_sse4_2().map(|token| ("sse4.2", Level::Sse4_2(token))));
        levels.extend(best.as_sse2().map(|token| ("sse2", Level::Sse2(token))));
    }
    levels.push(("fallback", Level::Fallback(Fallback::new())));
    levels
}

/// Random bytes: the hardest picture to filter.
pub fn noise(width: u32, height: u32, seed: u64) -> Image {
    let mut random = Random::new(seed);
    let rgba = (0..width * height * 4).map(|_| random.bits() as u8).collect();
    Image { width, height, rgba, ..Image::default() }
}

/// One colour all over.
pub fn plain(width: u32, height: u32, texel: [u8; 4]) -> Image {
    let rgba = texel.repeat(width as usize * height as usize);
    Image { width, height, rgba, ..Image::default() }
}

/// Properties are tried on the same cases in every run.
pub fn config(cases: u32) -> Config {
    Config { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Config::default() }
}
