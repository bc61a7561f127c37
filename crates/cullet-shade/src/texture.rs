//! An image and its smaller copies, ready to be sampled.
//!
//! Each level halves the one before, rounding down, to 1x1. A texel of a smaller level is
//! the average of the area it covers: two by two texels where sides are even, up to three
//! by three with fractional weights where they are odd. Averages are of linear light and
//! stay in f32 from level to level; bytes are rounded from them, never averages from
//! bytes. The image streams through row by row, so the work needs three rows per level.
//!
//! Bytes are RGBA, colour sRGB encoded, alpha linear and straight; each channel is averaged
//! by itself.
//! Source: Williams, "Pyramidal Parametrics", SIGGRAPH 1983; the weights for odd sides
//! follow from areas, see `Taps`.

use std::sync::Arc;

use cullet_scene::{Image, Sampler, Wrap};
use glam::Vec4;

use crate::select::clamp;
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
    /// textures show one image, or to give the image away instead of copying it.
    pub fn new(image: &Image, sampler: Sampler) -> Texture {
        Texture::shared(Arc::new(Mips::new(image.clone())), sampler)
    }

    /// A texture that shares its texels. The filters a sampler names are not used: the
    /// caller of [`crate::sample`] chooses.
    pub fn shared(mips: Arc<Mips>, sampler: Sampler) -> Texture {
        Texture { mips, wrap: [sampler.wrap_u, sampler.wrap_v] }
    }
}

/// An image and its smaller copies: 4/3 of the memory of the image.
#[derive(Clone, Debug)]
pub struct Mips {
    levels: Vec<Level>,
}

/// One size of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

impl Mips {
    /// Takes the image over, as level 0, and makes the smaller ones.
    ///
    /// An image without pixels, or with other than the number of bytes its size asks for, becomes one
    /// opaque white texel, which changes nothing that it multiplies.
    pub fn new(image: Image) -> Mips {
        let n_texels = u64::from(image.width) * u64::from(image.height);
        let base = if n_texels > 0 && image.rgba.len() as u64 / 4 == n_texels {
            Level { width: image.width, height: image.height, rgba: image.rgba }
        } else {
            Level { width: 1, height: 1, rgba: vec![255; 4] }
        };
        let mut smaller = Vec::new();
        let (mut width, mut height) = (base.width, base.height);
        while width > 1 || height > 1 {
            let halving = Halving::new(width, height);
            (width, height) = (halving.level.width, halving.level.height);
            smaller.push(halving);
        }
        if !smaller.is_empty() {
            let mut row = Vec::new();
            for y in 0..base.height {
                row.clear();
                row.extend(base.row(y).iter().map(|&texel| decode(texel)));
                push(&mut smaller, &row);
            }
        }
        let smaller = smaller.into_iter().map(|halving| halving.level);
        Mips { levels: std::iter::once(base).chain(smaller).collect() }
    }

    /// Largest first, the last is 1x1; never empty.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }
}

impl Level {
    /// Texels across, at least 1.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Texels down, at least 1.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The bytes of one texel; `x` and `y` count from the top left and lie inside.
    #[inline]
    pub fn texel(&self, x: u32, y: u32) -> [u8; 4] {
        debug_assert!(x < self.width && y < self.height, "texel {x}, {y} outside");
        self.texels()[y as usize * self.width as usize + x as usize]
    }

    /// Row-major, top row first, `width * height` texels.
    pub fn texels(&self) -> &[[u8; 4]] {
        self.rgba.as_chunks().0
    }

    fn row(&self, y: u32) -> &[[u8; 4]] {
        let width = self.width as usize;
        &self.texels()[y as usize * width..][..width]
    }
}

/// Linear RGBA of a texel, each channel in `[0, 1]`.
#[inline]
pub fn decode([r, g, b, a]: [u8; 4]) -> Vec4 {
    let linear = &*srgb::DECODE;
    Vec4::new(
        linear[usize::from(r)],
        linear[usize::from(g)],
        linear[usize::from(b)],
        decode_alpha(a),
    )
}

/// Alpha of a texel, in `[0, 1]`.
#[inline]
pub fn decode_alpha(alpha: u8) -> f32 {
    f32::from(alpha) / 255.0
}

fn encode(color: Vec4) -> [u8; 4] {
    let alpha = (clamp(color.w, 0.0, 1.0) * 255.0 + 0.5) as u8;
    [srgb::encode8(color.x), srgb::encode8(color.y), srgb::encode8(color.z), alpha]
}

/// A level in the making, fed one source row at a time.
struct Halving {
    level: Level,
    source_height: u32,
    n_rows_seen: u32,
    columns: Vec<Taps>,
    /// The last three source rows, already narrowed; row `y` is at `y % 3`.
    narrowed: [Vec<Vec4>; 3],
    /// The row just finished, linear.
    finished: Vec<Vec4>,
}

impl Halving {
    fn new(source_width: u32, source_height: u32) -> Halving {
        let (width, height) = (halved(source_width), halved(source_height));
        Halving {
            level: Level {
                width,
                height,
                rgba: Vec::with_capacity(4 * width as usize * height as usize),
            },
            source_height,
            n_rows_seen: 0,
            columns: (0..width).map(|x| Taps::new(source_width, x)).collect(),
            narrowed: Default::default(),
            finished: Vec::new(),
        }
    }
}

fn halved(side: u32) -> u32 {
    (side / 2).max(1)
}

/// Hands a row of linear colour to the largest of `levels`, which hands what it finishes
/// to the next.
fn push(levels: &mut [Halving], row: &[Vec4]) {
    let Some((halving, smaller)) = levels.split_first_mut() else { return };
    let Halving { level, source_height, n_rows_seen, columns, narrowed, finished } = halving;
    let y = *n_rows_seen;
    *n_rows_seen += 1;
    let into = &mut narrowed[y as usize % 3];
    into.clear();
    into.extend(columns.iter().map(|taps| taps.average(|source| row[source as usize])));

    let n_finished = (level.rgba.len() / 4 / level.width as usize) as u32;
    let rows = Taps::new(*source_height, n_finished);
    if y != rows.last() {
        return;
    }
    finished.clear();
    finished
        .extend((0..level.width as usize).map(|x| rows.average(|y| narrowed[y as usize % 3][x])));
    level.rgba.extend(finished.iter().flat_map(|&color| encode(color)));
    push(smaller, finished);
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

    fn last(&self) -> u32 {
        self.first + self.n - 1
    }

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
        mips.levels().iter().map(|level| (level.width, level.height)).collect()
    }

    #[test]
    fn sides_halve_and_round_down_to_one() {
        assert_eq!(sizes(&Mips::new(noise(1, 1, 0))), [(1, 1)]);
        assert_eq!(sizes(&Mips::new(noise(7, 3, 0))), [(7, 3), (3, 1), (1, 1)]);
        assert_eq!(sizes(&Mips::new(noise(1, 5, 0))), [(1, 5), (1, 2), (1, 1)]);
        assert_eq!(sizes(&Mips::new(noise(16384, 1, 0))).len(), 15);
    }

    #[test]
    fn every_level_is_the_rounded_average_of_its_area() {
        for (width, height) in [(1, 1), (2, 2), (8, 8), (3, 3), (7, 5), (13, 1), (1, 31), (37, 23)]
        {
            let image = noise(width, height, 5);
            let exact = reference::mips(&image);
            let mips = Mips::new(image);
            assert_eq!(mips.levels().len(), exact.len());
            for (level, exact) in mips.levels().iter().zip(&exact) {
                assert_eq!(level.texels().len(), (level.width * level.height) as usize);
                for (texel, exact) in level.texels().iter().zip(exact) {
                    for (channel, &byte) in texel.iter().enumerate() {
                        let code = match channel {
                            3 => exact[channel] * 255.0,
                            _ => srgb::encode_exact(exact[channel]) * 255.0,
                        };
                        let error = (f64::from(byte) - code).abs();
                        assert!(error < 0.5001, "{width}x{height}: {byte} for {code}");
                    }
                }
            }
        }
    }

    #[test]
    fn taps_sum_to_one_and_reach_both_ends() {
        for side in 1..200 {
            let taps: Vec<_> = (0..halved(side)).map(|i| Taps::new(side, i)).collect();
            assert!(taps.iter().all(|t| (t.weights.iter().sum::<f32>() - 1.0).abs() < 2e-7));
            assert_eq!((taps[0].first, taps.last().unwrap().last()), (0, side - 1));
        }
    }

    #[test]
    fn a_plain_image_stays_plain() {
        for code in 0..=255 {
            let mips = Mips::new(plain(7, 9, [code, 255 - code, 17, code]));
            let mut texels = mips.levels().iter().flat_map(|level| level.texels());
            assert!(texels.all(|&texel| texel == [code, 255 - code, 17, code]));
        }
    }

    #[test]
    fn an_image_without_pixels_is_white() {
        let short = Image { width: 2, height: 2, rgba: vec![0; 15], ..Image::default() };
        for image in [Image::default(), short] {
            let mips = Mips::new(image);
            assert_eq!(mips.levels(), [Level { width: 1, height: 1, rgba: vec![255; 4] }]);
        }
    }

    #[test]
    fn the_image_is_taken_not_copied() {
        let image = noise(8, 8, 0);
        let bytes = image.rgba.as_ptr();
        assert_eq!(Mips::new(image).levels()[0].rgba.as_ptr(), bytes);
    }
}
