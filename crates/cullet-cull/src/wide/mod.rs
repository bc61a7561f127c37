//! Eight boxes at a time.

pub use fearless_simd::Level;
