//! An image and its smaller copies, ready to be sampled.
//!
//! Each level halves the one before, rounding down, to 1x1. A texel of a smaller level is
//! the average of the area it covers: two by two texels where sides are even, up to three
//! by three with fractional weights where they are odd.
//!
//! Texels are linear light, RGBA, 16 bits a channel, alpha straight: so they blend as they are,
//! and two neighbours are one load of 16 bytes. Level 0 is the image within half a step
//! (1 / 131070, a fortieth of an 8-bit code where codes are closest), and each level adds at most
//! half a step by rounding its averages. After the last texel of a row and after the last row come
//! the first ones again: the right and lower neighbours where the picture repeats. Rows are an
//! odd number of cache lines apart, so that those above each other do not compete for the same
//! places in a cache.
//!
//! Source: Williams, "Pyramidal Parametrics", SIGGRAPH 1983; the weights for odd sides
//! follow from areas, see `Taps`.

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

/// An image and its smaller copies: 8/3 of the memory of the image.
#[derive(Clone, Debug)]
pub struct Mips {
    texels: Vec<u16>,
    sizes: Vec<Size>,
}

/// Where a level lies among the texels of all.
#[derive(Clone, Copy, Debug)]
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
        let mut rest = &mut texels[..];
        let mut larger: Option<(Size, &[u16])> = None;
        for size in &sizes {
            let (level, smaller) = rest.split_at_mut(size.len());
            match larger {
                None => decode_image(rgba.as_chunks().0, *size, level),
                Some((source, texels)) => halve(source, texels, *size, level),
            }
            repeat_ends(*size, level);
            (rest, larger) = (smaller, Some((*size, &*level)));
        }
        Mips { texels, sizes }
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
        self.texels.as_chunks().0[y as usize * row_len(self.width) + x as usize]
    }
}

impl Size {
    /// Channels in a row, its first texel twice.
    fn row_len(&self) -> usize {
        4 * row_len(self.width)
    }

    /// Channels of all rows, the first one twice.
    fn len(&self) -> usize {
        self.row_len() * (self.height as usize + 1)
    }
}

/// Texels from a row to the next, of a level `width` texels wide.
fn row_len(width: u32) -> usize {
    let lines = (width as usize + 1).div_ceil(8); // of 64 bytes
    8 * (lines | 1)
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
    let rows = image.chunks_exact(size.width as usize);
    for (row, out) in rows.zip(level.chunks_exact_mut(size.row_len())) {
        for (&[r, g, b, a], out) in row.iter().zip(out.as_chunks_mut().0) {
            let (r, g, b) = (linear[r as usize], linear[g as usize], linear[b as usize]);
            *out = [r, g, b, u16::from(a) * 257];
        }
    }
}

/// Fills the last column and the last row.
fn repeat_ends(size: Size, level: &mut [u16]) {
    let len = size.row_len();
    let rows = size.height as usize;
    for row in level[..rows * len].chunks_exact_mut(len) {
        row.copy_within(..4, 4 * size.width as usize);
    }
    level.copy_within(..len, rows * len);
}

/// Averages the level `source` into the next.
fn halve(source: Size, texels: &[u16], size: Size, level: &mut [u16]) {
    let sides = [source.width, source.height];
    let (from, to) = (source.row_len(), size.row_len());
    if sides.iter().all(|side| side.is_multiple_of(2)) {
        return dispatch!(SimdLevel::new(), simd => quarter_all(simd, source, texels, size, level));
    }
    let columns: Vec<Taps> = (0..size.width).map(|x| Taps::new(source.width, x)).collect();
    let mut blended = vec![Vec4::ZERO; source.width as usize];
    for (y, out) in (0..size.height).zip(level.chunks_exact_mut(to)) {
        let rows = Taps::new(source.height, y);
        for (x, blended) in blended.iter_mut().enumerate() {
            let texel = |y| texels.as_chunks::<4>().0[y as usize * (from / 4) + x];
            *blended = rows.average(|y| Vec4::from_array(texel(y).map(f32::from)));
        }
        for (taps, out) in columns.iter().zip(out.as_chunks_mut().0) {
            let average = taps.average(|x| blended[x as usize]);
            *out = average.to_array().map(|channel| (channel + 0.5) as u16);
        }
    }
}

/// [`halve`] of a level with even sides: averages of two by two texels.
#[inline(always)]
fn quarter_all<S: Simd>(simd: S, source: Size, texels: &[u16], size: Size, level: &mut [u16]) {
    let (from, to) = (source.row_len(), size.row_len());
    let pairs = texels[..source.height as usize * from].chunks_exact(2 * from);
    for (pair, out) in pairs.zip(level.chunks_exact_mut(to)) {
        let (upper, lower) = pair.split_at(from);
        let (twos, rest) = out[..4 * size.width as usize].as_chunks_mut::<8>();
        let fours = upper.as_chunks::<16>().0.iter().zip(lower.as_chunks::<16>().0);
        for ((upper, lower), out) in fours.zip(twos) {
            let first = quarter(simd, &upper[..8], &lower[..8]);
            let second = quarter(simd, &upper[8..], &lower[8..]);
            *out = first.narrow(second).into();
        }
        if let [r, g, b, a] = rest {
            let last = 8 * (size.width as usize - 1);
            let one = quarter(simd, &upper[last..last + 8], &lower[last..last + 8]);
            let one: [u16; 8] = one.narrow(one).into();
            [*r, *g, *b, *a] = [one[0], one[1], one[2], one[3]];
        }
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
    fn rows_and_columns_begin_again_at_their_ends() {
        let mips = Mips::new(noise(6, 5, 1));
        for level in mips.levels() {
            let rows: Vec<&[u16]> = level.texels.chunks_exact(4 * row_len(level.width)).collect();
            assert_eq!(rows.len(), level.height as usize + 1);
            assert_eq!(rows[0], rows[rows.len() - 1]);
            let end = 4 * level.width as usize;
            assert!(rows.iter().all(|row| row[..4] == row[end..end + 4]));
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
