//! Which instruction sets this machine has.

#[cfg(feature = "std")]
use alloc::vec::Vec;

#[cfg(feature = "std")]
use super::Level;

/// Every level this machine can run, best first, plain scalar code last, each with its name.
///
/// For tests and benches that hold the levels against each other; everybody else wants
/// `Level::new()`.
#[cfg(feature = "std")]
pub fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_avx512().map(|token| ("avx512", Level::Avx512(token))));
        levels.extend(best.as_avx2().map(|token| ("avx2", Level::Avx2(token))));
        levels.extend(best.as_sse4_2().map(|token| ("sse4.2", Level::Sse4_2(token))));
        levels.extend(best.as_sse2().map(|token| ("sse2", Level::Sse2(token))));
    }
    #[cfg(target_arch = "aarch64")]
    levels.extend(best.as_neon().map(|token| ("neon", Level::Neon(token))));
    let _ = best;
    levels.push(("scalar", Level::Fallback(fearless_simd::Fallback::new())));
    levels
}
