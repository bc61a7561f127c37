//! Eight boxes at a time, in f32, and never one lost.
//!
//! [`Boxes8`] holds boxes in groups of eight, one array per bound, and asks a frustum about a
//! group in a handful of vector instructions. Which instructions is the caller's choice, a
//! [`Level`], found once per process; every level gives the same bits, because the arithmetic
//! is nothing but additions, multiplications and comparisons in a fixed order, none of them
//! fused. [`mod@reference`] is the same arithmetic one box at a time, to read and to judge by.
//!
//! [`Coarse8`] asks 12 bytes a box first, where memory is slower than arithmetic, and says the same.
//!
//! # Why f32 can be trusted
//!
//! Write u for 2^-24, the unit roundoff of f32. A plane's distance to a corner `X` is
//! `nx Xx + ny Xy + nz Xz + offset`, and the computed one differs from it by
//!
//! - u of each term for rounding the coefficient `n`, u for the product, and at most 2u for
//!   the sums it passes through, together less than 4.1u of the term;
//! - at most 4u of the offset for its own rounding and sums;
//! - 2^-150 per product that underflows.
//!
//! So three allowances are made, always towards keeping (Higham, "Accuracy and Stability of
//! Numerical Algorithms", 2002, chapter 3, has the tools):
//!
//! 1. Boxes are stored relative to an origin in their midst and scaled by a power of two, and
//!    each bound moves outwards by 8u of itself, then to the next f32 outwards. That pays for all
//!    that scales with a coordinate, with no instruction in the test; also for the f64 uncertainty of
//!    the coefficient (its slack) where that is below u of it.
//! 2. The offset, rebased in f64, exists twice, as an upper and a lower end. The ends lie at least
//!    6u of the offset apart from it, and 2^-147, and the f64 uncertainty of the rebased offset.
//! 3. What remains belongs to coefficients close to zero, or to planes that were moved outwards on
//!    purpose: a slack above u of its coefficient counts in the ends, times the largest
//!    coordinate stored, and a coefficient below 2^-60 becomes 0 and counts there as well.
//!
//! A box kept by the f64 p-vertex test is therefore kept here, and one reported inside a plane
//! is inside it. What is kept too much lies within 16u of the sum of the sizes of the terms,
//! seen from the origin of the boxes, plus, for planes almost parallel to an axis, 2^-45 of the
//! largest coordinate.
//!
//! # Why a tree gives the same answer
//!
//! For a plane with `nx >= 0` the corner takes the greater x, otherwise the lesser. Rounding is
//! monotone: `a <= b` gives `fl(a c) <= fl(b c)` for `c >= 0` and `fl(a + c) <= fl(b + c)`.
//! So of two stored boxes, one within the other, the larger never has the lesser computed
//! upper end nor the greater computed lower end. A box outside a plane has all boxes
//! within it outside, one inside has all inside, in f32 as in exact arithmetic: skipping the
//! test of a child whose parent was decided changes no bit of any verdict.

mod boxes8;
mod coarse8;
mod group;
mod leaf16;
mod level;
mod planes8;
pub mod reference;
mod space;

pub use boxes8::Boxes8;
pub use coarse8::Coarse8;
pub use fearless_simd::Level;
#[cfg(feature = "std")]
pub use level::levels;

pub(crate) use boxes8::around;
pub(crate) use group::{Box32, Group, Row};
pub(crate) use leaf16::{Grid, Leaf16, errors};
pub(crate) use planes8::{Planes8, Verdict};
pub(crate) use space::{Space, Stored};
