//! Which code serves an instruction set.

/// [`fearless_simd::dispatch`] without a copy for machines that have no wide registers: for those there is the plain
/// code, which is several times as fast as wide code taken lane by lane, and compiled in a fraction of the
/// time. Unlike there, sets below what the build asks for as a whole keep their copies.
///
/// # Panics
///
/// If the level is the fallback.
macro_rules! dispatch_wide {
    ($level:expr, $simd:ident => $op:expr) => {
        match $level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Avx512($simd) => dispatch_wide!(@run $simd => $op),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Avx2($simd) => dispatch_wide!(@run $simd => $op),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Sse4_2($simd) => dispatch_wide!(@run $simd => $op),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Sse2($simd) => dispatch_wide!(@run $simd => $op),
            #[cfg(target_arch = "aarch64")]
            fearless_simd::Level::Neon($simd) => dispatch_wide!(@run $simd => $op),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            fearless_simd::Level::WasmSimd128($simd) => dispatch_wide!(@run $simd => $op),
            _ => unreachable!("the plain code serves machines without wide registers"),
        }
    };
    (@run $simd:ident => $op:expr) => {
        fearless_simd::Simd::vectorize(
            $simd,
            #[inline(always)]
            || $op,
        )
    };
}

pub(crate) use dispatch_wide;
