//! An image and its smaller copies, ready to be sampled.
//!
//! Each level halves the one before, rounding down, to 1x1. A texel of a smaller level is
//! the average of the area it covers: two by two texels where sides are even, up to three
//! by three with fractional weights where they are odd.
//!
//! Texels are linear light, RGBA, 16 bits a channel, alpha straight: so they blend as they are,
//! and two neighbours are one load of 16 bytes. Level 0 is the image within half a step
//! (1 / 131070, a fortieth of an 8-bit code where codes are closest), and each level adds at most
//! half a step by rounding its averages.
//!
//! Levels lie in memory as strips, 32 texels wide, one after the other, so that what a small part of
//! a picture shows, turned any way, lies on few pages of memory. After the last texel of each row of
//! a strip comes the first of the next strip, and after the last row, and after the last strip, the
//! first ones again: the right and lower neighbours where the picture repeats.
//!
//! Source: Williams, "Pyramidal Parametrics", SIGGRAPH 1983; the weights for odd sides
//! follow from areas, see `Taps`.

use std::ops::Range;
use std::sync::{Arc, LazyLock};

use cullet_scene::{Image, Sampler, Wrap};
use fearless_simd::{Level as SimdLevel, Simd, dispatch, prelude::*, u16x8, u32x4};
use glam::Vec4;

use crate::srgb;

/// An image with its wrap modes. Cheap to clone: the texels are shared.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The image and its smaller copies.
    pub mips: Arc<Mips>,
    /// What happens outside 0..1, along u and v.
    pub wrap: [Wrap; 2],
}

impl Texture {
    /// A texture of its own from a copy of `image`. Use [`Texture::shared`] where several
    /// textures show one image.
    pub fn new(image: &Image, sampler: Sampler) -> Texture {
        Texture::shared(Arc::new(Mips::new(image.clone())), sampler)
    }

    /// A texture that shares its texels. The filters a sampler names are not used: the
    /// caller of [`crate::sample`] chooses.
    pub fn shared(mips: Arc<Mips>, sampler: Sampler) -> Texture {
        Texture { mips, wrap: [sampler.wrap_u, sampler.wrap_v] }
    }
}

/// An image and its smaller copies: 8/3 of the memory of the image, and the ends of rows twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mips {
    texels: Vec<u16>,
    sizes: Vec<Size>,
}

/// Where a level lies among the texels of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Size {
    width: u32,
    height: u32,
    first: usize,
}

/// One size of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level<'a> {
    width: u32,
    height: u32,
    texels: &'a [u16],
}

impl Mips {
    /// Decodes the image into level 0 and makes the smaller ones.
    ///
    /// An image without pixels, or with other than the number of bytes its size asks for, becomes one
    /// opaque white texel, which changes nothing that it multiplies.
    pub fn new(image: Image) -> Mips {
        let n_texels = u64::from(image.width) * u64::from(image.height);
        let (width, height, rgba) = if n_texels > 0 && image.rgba.len() as u64 / 4 == n_texels {
            (image.width, image.height, image.rgba)
        } else {
            (1, 1, vec![255; 4])
        };
        let sizes = sizes(width, height);
        let mut texels = vec![0; sizes.iter().map(Size::len).sum()];
        let pixels = rgba.as_chunks().0;
        let (mut level, mut rest) = texels.split_at_mut(sizes[0].len());
        let n_made = if sizes[0].is_even() {
            let half = sizes[1];
            decode_and_halve(pixels, [sizes[0], half], [level, &mut rest[..half.len()]]);
            2
        } else {
            decode_image(pixels, sizes[0], level);
            1
        };
        repeat_ends(sizes[0], level);
        for i in 1..sizes.len() {
            let (smaller, others) = rest.split_at_mut(sizes[i].len());
            if i >= n_made {
                halve(sizes[i - 1], level, sizes[i], smaller);
            }
            repeat_ends(sizes[i], smaller);
            (level, rest) = (smaller, others);
        }
        Mips { texels, sizes }
    }

    /// The texels of the levels of at most 16 by 16: the same for equal images, and for few others.
    pub fn gist(&self) -> &[u16] {
        let is_small = |size: &Size| size.width <= 16 && size.height <= 16;
        let first = self.sizes.iter().position(is_small).expect("the last is 1x1");
        &self.texels[self.sizes[first].first..]
    }

    /// How many levels there are, at least 1.
    pub fn n_levels(&self) -> usize {
        self.sizes.len()
    }

    /// Level `i`, the largest is 0, the last is 1x1.
    pub fn level(&self, i: usize) -> Level<'_> {
        let size = &self.sizes[i];
        let texels = &self.texels[size.first..size.first + size.len()];
        Level { width: size.width, height: size.height, texels }
    }

    /// All levels, largest first.
    pub fn levels(&self) -> impl ExactSizeIterator<Item = Level<'_>> {
        (0..self.n_levels()).map(|i| self.level(i))
    }

    /// The channels of all levels in one row.
    pub(crate) fn all_texels(&self) -> &[u16] {
        &self.texels
    }

    /// Where the texels of level `i` begin in [`Mips::all_texels`], counted in texels.
    pub(crate) fn first_texel(&self, i: usize) -> usize {
        self.sizes[i].first / 4
    }
}

impl Level<'_> {
    /// Texels across, at least 1.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Texels down, at least 1.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The channels of one texel; `x` and `y` count from the top left and lie inside.
    #[inline]
    pub fn texel(&self, x: u32, y: u32) -> [u16; 4] {
        debug_assert!(x < self.width && y < self.height, "texel {x}, {y} outside");
        let size = Size { width: self.width, height: self.height, first: 0 };
        self.texels.as_chunks().0[size.place(x, y)]
    }
}

/// Columns of a strip, a power of two; the first of the next follows.
pub(crate) const STRIP: u32 = 32;

impl Size {
    /// Whether both sides are.
    fn is_even(&self) -> bool {
        self.width.is_multiple_of(2) && self.height.is_multiple_of(2)
    }

    /// Texels from a row to the next.
    fn stride(&self) -> usize {
        self.width.min(STRIP) as usize + 1
    }

    /// Texels of a strip: all rows, and the first one twice.
    fn strip_len(&self) -> usize {
        self.stride() * (self.height as usize + 1)
    }

    /// The texel in column `x` and row `y`, from the first one on.
    fn place(&self, x: u32, y: u32) -> usize {
        (x / STRIP) as usize * self.strip_len() + y as usize * self.stride() + (x % STRIP) as usize
    }

    /// Channels of all strips.
    fn len(&self) -> usize {
        4 * self.width.div_ceil(STRIP) as usize * self.strip_len()
    }

    /// Its strips: the first column and how many there are.
    fn strips(&self) -> impl Iterator<Item = (u32, u32)> {
        let width = self.width;
        (0..width).step_by(STRIP as usize).map(move |x| (x, (width - x).min(STRIP)))
    }

    /// The channels of `n` texels in a row of a strip.
    fn range(&self, x: u32, y: u32, n: u32) -> Range<usize> {
        let start = 4 * self.place(x, y);
        start..start + 4 * n as usize
    }
}

/// Linear RGBA of a texel, each channel in `[0, 1]`; exactly 1 for 65535.
#[inline]
pub fn decode(texel: [u16; 4]) -> Vec4 {
    Vec4::from_array(texel.map(f32::from)) * STEP
}

/// Alpha of a texel, in `[0, 1]`.
#[inline]
pub fn decode_alpha(alpha: u16) -> f32 {
    f32::from(alpha) * STEP
}

/// One step of a channel.
pub(crate) const STEP: f32 = 1.0 / 65535.0;

/// Linear light of each 8-bit code, in steps.
static LINEAR: LazyLock<[u16; 256]> = LazyLock::new(|| {
    std::array::from_fn(|code| (srgb::decode_exact(code as f64 / 255.0) * 65535.0 + 0.5) as u16)
});

fn sizes(width: u32, height: u32) -> Vec<Size> {
    let mut sizes = vec![Size { width, height, first: 0 }];
    loop {
        let last = sizes[sizes.len() - 1];
        if last.width == 1 && last.height == 1 {
            return sizes;
        }
        let (width, height) = (halved(last.width), halved(last.height));
        sizes.push(Size { width, height, first: last.first + last.len() });
    }
}

fn halved(side: u32) -> u32 {
    (side / 2).max(1)
}

fn decode_image(image: &[[u8; 4]], size: Size, level: &mut [u16]) {
    let linear = &*LINEAR;
    for (y, mut row) in (0..).zip(image.chunks_exact(size.width as usize)) {
        for (x, n) in size.strips() {
            let (part, others) = row.split_at(n as usize);
            row = others;
            decode_row(linear, part, &mut level[size.range(x, y, n)]);
        }
    }
}

#[inline(always)]
fn decode_row(linear: &[u16; 256], pixels: &[[u8; 4]], out: &mut [u16]) {
    for (&[r, g, b, a], out) in pixels.iter().zip(out.as_chunks_mut().0) {
        let (r, g, b) = (linear[r as usize], linear[g as usize], linear[b as usize]);
        *out = [r, g, b, u16::from(a) * 257];
    }
}

/// [`decode_image`] and [`halve`] at once, for even sides: texels are averaged while they are at hand.
fn decode_and_halve(image: &[[u8; 4]], [size, half]: [Size; 2], [level, smaller]: [&mut [u16]; 2]) {
    let linear = &*LINEAR;
    for (y, two) in (0..).zip(image.chunks_exact(2 * size.width as usize)) {
        let (upper, lower) = two.split_at(size.width as usize);
        for (x, n) in size.strips() {
            let part = x as usize..(x + n) as usize;
            let [above, below] = [2 * y, 2 * y + 1].map(|y| size.range(x, y, n));
            decode_row(linear, &upper[part.clone()], &mut level[above.clone()]);
            decode_row(linear, &lower[part], &mut level[below.clone()]);
            let rows = [&level[above], &level[below]];
            let out = &mut smaller[half.range(x / 2, y, n / 2)];
            dispatch!(SimdLevel::new(), simd => quarter_rows(simd, rows, out));
        }
    }
}

/// Fills the last column and the last row of each strip.
fn repeat_ends(size: Size, level: &mut [u16]) {
    for (x, n) in size.strips() {
        let next = if x + n < size.width { x + n } else { 0 };
        for y in 0..size.height {
            let end = size.range(x, y, n).end;
            level.copy_within(size.range(next, y, 1), end);
        }
        let first_row = size.range(x, 0, n + 1);
        level.copy_within(first_row, 4 * size.place(x, size.height));
    }
}

/// Averages the level `source` into the next.
fn halve(source: Size, texels: &[u16], size: Size, level: &mut [u16]) {
    if source.is_even() {
        return dispatch!(SimdLevel::new(), simd => quarter_all(simd, source, texels, size, level));
    }
    let columns: Vec<Taps> = (0..size.width).map(|x| Taps::new(source.width, x)).collect();
    let mut blended = vec![Vec4::ZERO; source.width as usize];
    for y in 0..size.height {
        let rows = Taps::new(source.height, y);
        for (x, blended) in (0..).zip(&mut blended) {
            let texel = |y| texels.as_chunks::<4>().0[source.place(x, y)];
            *blended = rows.average(|y| Vec4::from_array(texel(y).map(f32::from)));
        }
        for (x, taps) in (0..).zip(&columns) {
            let average = taps.average(|x| blended[x as usize]);
            level.as_chunks_mut().0[size.place(x, y)] =
                average.to_array().map(|channel| (channel + 0.5) as u16);
        }
    }
}

/// [`halve`] of a level with even sides: averages of two by two texels.
#[inline(always)]
fn quarter_all<S: Simd>(simd: S, source: Size, texels: &[u16], size: Size, level: &mut [u16]) {
    for (x, n) in source.strips() {
        for y in 0..size.height {
            let upper = &texels[source.range(x, 2 * y, n)];
            let lower = &texels[source.range(x, 2 * y + 1, n)];
            quarter_rows(simd, [upper, lower], &mut level[size.range(x / 2, y, n / 2)]);
        }
    }
}

/// The averages of two by two texels in two rows of a strip.
#[inline(always)]
fn quarter_rows<S: Simd>(simd: S, [upper, lower]: [&[u16]; 2], out: &mut [u16]) {
    let n = upper.len();
    let (twos, rest) = out.as_chunks_mut::<8>();
    let fours = upper.as_chunks::<16>().0.iter().zip(lower.as_chunks::<16>().0);
    for ((upper, lower), out) in fours.zip(twos) {
        let first = quarter(simd, &upper[..8], &lower[..8]);
        let second = quarter(simd, &upper[8..], &lower[8..]);
        *out = first.narrow(second).into();
    }
    if let [r, g, b, a] = rest {
        let one = quarter(simd, &upper[n - 8..], &lower[n - 8..]);
        let one: [u16; 8] = one.narrow(one).into();
        [*r, *g, *b, *a] = [one[0], one[1], one[2], one[3]];
    }
}

/// The average of four texels, halves up.
#[inline(always)]
fn quarter<S: Simd>(simd: S, upper: &[u16], lower: &[u16]) -> u32x4<S> {
    let (a, b) = u16x8::from_slice(simd, upper).widen();
    let (c, d) = u16x8::from_slice(simd, lower).widen();
    (a + b + c + d + 2) >> 2
}

/// The source texels, along one axis, that a texel of the next level covers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Taps {
    first: u32,
    n: u32,
    weights: [f32; 3],
}

impl Taps {
    /// The texels under texel `i` of the halved axis. Of `2 m + 1` texels each of the `m`
    /// halved ones covers `2 + 1/m`: a part `m - i` of the first, the second whole, a part
    /// `i + 1` of the third, in units of `1/m`.
    fn new(source_side: u32, i: u32) -> Taps {
        let first = 2 * i;
        if source_side == 1 {
            return Taps { first, n: 1, weights: [1.0, 0.0, 0.0] };
        }
        if source_side.is_multiple_of(2) {
            return Taps { first, n: 2, weights: [0.5, 0.5, 0.0] };
        }
        let m = source_side / 2;
        let part = |n: u32| n as f32 / source_side as f32;
        Taps { first, n: 3, weights: [part(m - i), part(m), part(i + 1)] }
    }

    #[inline(always)]
    fn average(&self, color: impl Fn(u32) -> Vec4) -> Vec4 {
        (1..self.n).fold(color(self.first) * self.weights[0], |sum, k| {
            sum + color(self.first + k) * self.weights[k as usize]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference;
    use crate::testing::{noise, plain};

    fn sizes(mips: &Mips) -> Vec<(u32, u32)> {
        mips.levels().map(|level| (level.width, level.height)).collect()
    }

    #[test]
    fn sides_halve_and_round_down_to_one() {
        assert_eq!(sizes(&Mips::new(noise(1, 1, 0))), [(1, 1)]);
        assert_eq!(sizes(&Mips::new(noise(7, 3, 0))), [(7, 3), (3, 1), (1, 1)]);
        assert_eq!(sizes(&Mips::new(noise(1, 5, 0))), [(1, 5), (1, 2), (1, 1)]);
        assert_eq!(sizes(&Mips::new(noise(16384, 1, 0))).len(), 15);
    }

    fn texels<'a>(level: &'a Level<'_>) -> impl Iterator<Item = [u16; 4]> + 'a {
        (0..level.height).flat_map(move |y| (0..level.width).map(move |x| level.texel(x, y)))
    }

    #[test]
    fn every_level_is_the_average_of_its_area_within_half_a_step_a_level() {
        for (width, height) in [(1, 1), (2, 2), (8, 8), (3, 3), (7, 5), (13, 1), (1, 31), (37, 23)]
        {
            let image = noise(width, height, 5);
            let exact = reference::mips(&image);
            let mips = Mips::new(image);
            assert_eq!(mips.n_levels(), exact.len());
            for (i, (level, exact)) in mips.levels().zip(&exact).enumerate() {
                assert_eq!(exact.len(), (level.width * level.height) as usize);
                for (texel, exact) in texels(&level).zip(exact) {
                    for (&steps, exact) in texel.iter().zip(exact) {
                        let error = (f64::from(steps) - exact * 65535.0).abs();
                        let bound = 0.5001 * (i + 1) as f64;
                        assert!(error < bound, "{width}x{height}, level {i}: {error} steps");
                    }
                }
            }
        }
    }

    #[test]
    fn the_first_two_levels_at_once_are_one_after_the_other() {
        for (width, height) in [(2, 2), (2, 8), (30, 2), (64, 6), (66, 34), (100, 10)] {
            let image = noise(width, height, 9);
            let sizes = super::sizes(width, height);
            let mut level = vec![0; sizes[0].len()];
            decode_image(image.rgba.as_chunks().0, sizes[0], &mut level);
            let mut half = vec![0; sizes[1].len()];
            halve(sizes[0], &level, sizes[1], &mut half);
            repeat_ends(sizes[0], &mut level);
            repeat_ends(sizes[1], &mut half);
            let mips = Mips::new(image);
            assert!(mips.level(0).texels == level, "{width}x{height}");
            assert!(mips.level(1).texels == half, "{width}x{height}");
        }
    }

    #[test]
    fn the_neighbours_right_and_below_follow_and_begin_again_at_the_ends() {
        for (width, height) in [(6, 5), (1, 1), (32, 3), (33, 2), (64, 64), (100, 7)] {
            let mips = Mips::new(noise(width, height, 1));
            for level in mips.levels() {
                let size = Size { width: level.width, height: level.height, first: 0 };
                let stored = level.texels.as_chunks::<4>().0;
                for (x, y) in (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y)))
                {
                    let (right, below) = ((x + 1) % level.width, (y + 1) % level.height);
                    let place = size.place(x, y);
                    let square = [
                        [stored[place], stored[place + 1]],
                        [stored[place + size.stride()], stored[place + size.stride() + 1]],
                    ];
                    let expected = [y, below].map(|y| [x, right].map(|x| level.texel(x, y)));
                    assert_eq!(square, expected, "{x} {y} of {width} x {height}");
                }
            }
        }
    }

    #[test]
    fn taps_sum_to_one_and_reach_both_ends() {
        for side in 1..200 {
            let taps: Vec<_> = (0..halved(side)).map(|i| Taps::new(side, i)).collect();
            assert!(taps.iter().all(|t| (t.weights.iter().sum::<f32>() - 1.0).abs() < 2e-7));
            let last = taps.last().unwrap();
            assert_eq!((taps[0].first, last.first + last.n - 1), (0, side - 1));
        }
    }

    #[test]
    fn a_plain_image_stays_plain() {
        for code in 0..=255 {
            let mips = Mips::new(plain(7, 9, [code, 255 - code, 17, code]));
            let first = mips.level(0).texel(0, 0);
            assert_eq!(
                first.map(|steps| srgb::encode8(decode_alpha(steps)))[..3],
                [code, 255 - code, 17]
            );
            assert_eq!(first[3], u16::from(code) * 257);
            assert!(mips.levels().all(|level| texels(&level).all(|texel| texel == first)));
        }
    }

    #[test]
    fn an_image_without_pixels_is_white() {
        let short = Image { width: 2, height: 2, rgba: vec![0; 15], ..Image::default() };
        for image in [Image::default(), short] {
            let mips = Mips::new(image);
            assert_eq!(sizes(&mips), [(1, 1)]);
            assert_eq!(decode(mips.level(0).texel(0, 0)), Vec4::ONE);
        }
    }
}
