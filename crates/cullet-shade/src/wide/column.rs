//! What a stage leaves to the next: a number for each pixel of a chunk, side by side.
//!
//! Pixels go through a stage in groups of so many as suit the instruction set ([`Lanes`]): a group's
//! numbers are one vector.

use fearless_simd::{
    Simd, SimdCvtFloat, SimdCvtTruncate, f32x8, f32x16, i32x8, i32x16, prelude::*, u32x8, u32x16,
};

/// Pixels of a chunk: they all go through a stage before the next begins. At the end of each stage its long
/// chains of arithmetic are waited for, so chunks are large; what a stage leaves has to stay in the nearest cache,
/// so they are no larger. Half as many take 1.02 of the time, a quarter 1.08.
pub(super) const ROOM: usize = 256;

/// Pixels of the largest group; a multiple of every other's.
pub(crate) const WIDEST: usize = 16;

/// The most groups of a chunk: of the smallest.
pub(super) const MOST_GROUPS: usize = ROOM / 8;

/// Of the lanes.
pub(super) const NUMBERS: [u32; WIDEST] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// A number for each pixel of a group.
pub(crate) trait Lanes<S: Simd>:
    SimdFloat<S, Element = f32> + SimdCvtFloat<Self::Ints>
{
    /// As many whole numbers.
    type Ints: SimdInt<S, Element = i32, Mask = Self::Mask, ByteVector = Self::ByteVector>
        + SimdCvtTruncate<Self>;
    /// The same, without sign.
    type Uints: SimdInt<S, Element = u32, Mask = Self::Mask, ByteVector = Self::ByteVector>
        + SimdCvtTruncate<Self>;

    /// Rows of eight numbers, as many as there is room for: the first, or both.
    fn of_rows(simd: S, rows: [&[f32; 8]; 2]) -> Self;
}

/// Calls a function of an instruction set `S` and of [`Lanes`] with as many as serve it best: the widest
/// vectors as they are, shorter ones two by two.
macro_rules! wide {
    ($S:ident, $function:ident $(::<$($parameter:ident),+>)? ($($argument:expr),+ $(,)?)) => {
        match <$S::f32s as fearless_simd::SimdBase<$S>>::LEN {
            8.. => $function::<$S, fearless_simd::f32x16<$S> $($(, $parameter)+)?>($($argument),+),
            _ => $function::<$S, fearless_simd::f32x8<$S> $($(, $parameter)+)?>($($argument),+),
        }
    };
}
pub(crate) use wide;

impl<S: Simd> Lanes<S> for f32x8<S> {
    type Ints = i32x8<S>;
    type Uints = u32x8<S>;

    #[inline(always)]
    fn of_rows(simd: S, [row, _]: [&[f32; 8]; 2]) -> Self {
        Self::simd_from(simd, *row)
    }
}

impl<S: Simd> Lanes<S> for f32x16<S> {
    type Ints = i32x16<S>;
    type Uints = u32x16<S>;

    #[inline(always)]
    fn of_rows(simd: S, [first, second]: [&[f32; 8]; 2]) -> Self {
        f32x8::simd_from(simd, *first).combine(f32x8::simd_from(simd, *second))
    }
}

/// One number of each pixel of a chunk.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Column<T>(pub [T; ROOM]);

impl<T: Copy + Default> Default for Column<T> {
    fn default() -> Self {
        Column([T::default(); ROOM])
    }
}

impl<T: Copy> Column<T> {
    /// The numbers of a group.
    #[inline(always)]
    pub fn get<S: Simd, V: SimdBase<S, Element = T>>(&self, simd: S, group: usize) -> V {
        V::from_slice(simd, &self.0[group * V::LEN..][..V::LEN])
    }

    /// Sets the numbers of a group.
    #[inline(always)]
    pub fn set<S: Simd, V: SimdBase<S, Element = T>>(&mut self, group: usize, values: V) {
        values.store_slice(&mut self.0[group * V::LEN..][..V::LEN]);
    }

    /// The numbers of a group of so many pixels, one by one.
    #[inline(always)]
    pub fn of(&self, group: usize, lanes: usize) -> &[T] {
        &self.0[group * lanes..][..lanes]
    }

    /// [`Column::of`], to be written.
    #[inline(always)]
    pub fn of_mut(&mut self, group: usize, lanes: usize) -> &mut [T] {
        &mut self.0[group * lanes..][..lanes]
    }
}
