//! Which pixels? Clipping, fixed-point set-up, coverage and depth.

mod fragment;

pub use fragment::Fragment;
