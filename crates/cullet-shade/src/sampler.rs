//! The colour of a texture at a place: footprint, level, texels, blend.
//!
//! Texel `i` of `n` has its centre at `(i + 1/2) / n`. Coordinates are folded by the wrap
//! mode in f64, where the product with a texture size is exact, so a texel choice never
//! suffers from rounding. Texels are linear light, so they are blended as they are.
//!
//! Texture space: u to the right, v down, 0..1 across the image. Any coordinate has a
//! colour: NaN counts as 0, and so does an infinity that repeats or mirrors.
//! Source: OpenGL 4.6 core specification, 8.14 and 8.15 (the isotropic scale factor as the
//! longer footprint axis, nearest level, wrap modes); Vulkan 1.3, "Image Operations"; Williams,
//! "Pyramidal Parametrics", 1983 (mipmaps); for [`Filter::Anisotropic`]
//! EXT_texture_filter_anisotropic, with a rounded number of samples.
//!
//! **The blend of two levels** is linear in the size of the footprint, where those specifications
//! have its logarithm: a footprint of 3 texels is halfway between the levels of 2 and of 4. The
//! coarser level gets up to .086 less, which is nearer to the mean of what a pixel covers (as
//! measured, ARCHITECTURE.md), and takes a square root instead of a logarithm. OpenImageIO's texture
//! system, which film renderers use, blends by the filter's width as well. Who has to match what OpenGL
//! draws takes [`Filter::TrilinearLog`].

use std::ops::{Add, Mul, Sub};

use cullet_scene::Wrap;
use glam::{DVec2, Vec2, Vec4};

use crate::select::{clamp, max};
use crate::texture::{Level, Texture, decode, decode_alpha};

/// How texels are blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Filter {
    /// The nearest texel of the nearest level.
    Nearest,
    /// The four texels around the place, in the nearest level.
    Bilinear,
    /// Bilinear in the two levels around the footprint's size, blended.
    #[default]
    Trilinear,
    /// The same with levels blended by the logarithm of the footprint's size (within 3e-7), as OpenGL, Vulkan and
    /// Direct3D have it: for pictures to be compared with theirs. A little more blurred.
    TrilinearLog,
    /// The mean of up to 16 trilinear samples along the longer axis of the footprint, in levels by the
    /// shorter axis: what is seen at a slant stays sharp across.
    Anisotropic,
    /// Trilinear for pictures that are the mean of 2^n others, each sampled elsewhere within the
    /// pixel: every sample stands for that much less of the footprint, so levels are finer by n / 2.
    Oversampled(u8),
}

impl Filter {
    /// The part of a pixel's area that a sample stands for: 1, or a power of two below.
    pub(crate) fn area(self) -> f32 {
        if let Filter::Oversampled(n) = self { libm::ldexpf(1.0, -i32::from(n)) } else { 1.0 }
    }
}

/// What numbers texels are blended in.
///
/// It is the business of the wide code, and of filters that blend: [`sample`], the few pixels that are
/// left to it, and [`Filter::Anisotropic`] always take floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Arithmetic {
    /// 32-bit floats.
    #[default]
    Float,
    /// 16-bit whole numbers: 15 bits of linear light, weights of 16.
    Sixteen,
    /// 8 bits of linear light, weights of 7, as of old.
    Eight,
}
/// The most samples of [`Filter::Anisotropic`].
pub(crate) const MOST_SAMPLES: f32 = 16.0;

/// Linear RGBA, straight alpha, each in `[0, 1]`, at `uv`.
///
/// `duvdx` and `duvdy` are the changes of `uv` per pixel to the right and down. Where they
/// span a texel or less, level 0 answers; where either is NaN or infinite, the coarsest.
pub fn sample(texture: &Texture, uv: Vec2, duvdx: Vec2, duvdy: Vec2, filter: Filter) -> Vec4 {
    over_footprint(texture, uv, [duvdx, duvdy], filter, decode)
}

/// The alpha of [`sample`], bit for bit, without the colour.
pub fn sample_alpha(texture: &Texture, uv: Vec2, duvdx: Vec2, duvdy: Vec2, filter: Filter) -> f32 {
    let alpha = |[.., alpha]: [u16; 4]| decode_alpha(alpha);
    over_footprint(texture, uv, [duvdx, duvdy], filter, alpha)
}

fn over_footprint<T>(
    texture: &Texture,
    uv: Vec2,
    [duvdx, duvdy]: [Vec2; 2],
    filter: Filter,
    decode: impl Fn([u16; 4]) -> T + Copy,
) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    let place = uv.as_dvec2();
    if filter != Filter::Anisotropic {
        return filtered(texture, place, lod(texture, duvdx, duvdy, filter), filter, decode);
    }
    let Stretch { n, axis, lod } = stretch(texture, duvdx, duvdy);
    let piece = |i: u32| {
        let along = (f64::from(i) + 0.5) / f64::from(n) - 0.5;
        filtered(texture, place + axis * along, lod, filter, decode)
    };
    // In this form the mean of equal colours is exactly theirs.
    (1..n).fold(piece(0), |mean, i| mix(mean, piece(i), 1.0 / (i + 1) as f32))
}

/// A footprint, cut into pieces along its longer axis.
struct Stretch {
    /// Pieces, 1 to 16.
    n: u32,
    /// The longer axis, texture coordinates.
    axis: DVec2,
    /// Level of detail of a piece.
    lod: f32,
}

/// Cuts a footprint into as many pieces as it is longer than wide, rounded. It counts as wide as a texel
/// at least: finer pieces would show nothing new.
fn stretch(texture: &Texture, duvdx: Vec2, duvdy: Vec2) -> Stretch {
    let base = texture.mips.level(0);
    let size = Vec2::new(base.width() as f32, base.height() as f32);
    let (x, y) = (duvdx * size, duvdy * size);
    let (x2, y2) = (x.x * x.x + x.y * x.y, y.x * y.x + y.y * y.y);
    let is_finite = x2 + y2 < f32::INFINITY; // false for NaN
    if !is_finite {
        let lod = lod(texture, duvdx, duvdy, Filter::Trilinear);
        return Stretch { n: 1, axis: DVec2::ZERO, lod };
    }
    let (longer2, shorter2, axis) = if x2 > y2 { (x2, y2, duvdx) } else { (y2, x2, duvdy) };
    let ratio = (longer2 / max(shorter2, 1.0)).sqrt();
    let n = clamp(ratio + 0.5, 1.0, MOST_SAMPLES) as u32;
    let piece = (n as f32).recip();
    let lod = lod(texture, duvdx * piece, duvdy * piece, Filter::Trilinear);
    Stretch { n, axis: axis.as_dvec2(), lod }
}

/// Level of detail, in `0..=n_levels - 1`: the whole part is the coarsest level with texels no longer than
/// the footprint's longer axis (or the finest, of shorter ones), the fraction the share of the next. For
/// filters that ask one level it is the nearer of the two, whole; [`Filter::Oversampled`] has less of a footprint.
pub(crate) fn lod(texture: &Texture, duvdx: Vec2, duvdy: Vec2, filter: Filter) -> f32 {
    let base = texture.mips.level(0);
    let size = Vec2::new(base.width() as f32, base.height() as f32);
    let (x, y) = (duvdx * size, duvdy * size);
    let (x2, y2) = (x.x * x.x + x.y * x.y, y.x * y.x + y.y * y.y);
    let coarsest = (texture.mips.n_levels() - 1) as f32;
    let longer2 = if (x2 + y2).is_nan() { f32::INFINITY } else { max(x2, y2) };
    let longer2 = longer2 * filter.area();
    if longer2 <= 1.0 {
        return 0.0;
    }
    // Four times the area is a level, and two binary exponents.
    let level = (longer2.to_bits() - 1.0_f32.to_bits()) >> 24;
    let rest2 = f32::from_bits(longer2.to_bits() - (level << 24)); // of 1..4
    let share = match filter {
        // Halfway goes to the finer level, as OpenGL has it.
        Filter::Nearest | Filter::Bilinear => f32::from(rest2 > 2.0),
        Filter::Trilinear | Filter::Anisotropic | Filter::Oversampled(_) => rest2.sqrt() - 1.0,
        Filter::TrilinearLog => log2_of_1_to_2(rest2.sqrt()),
    };
    clamp(level as f32 + share, 0.0, coarsest)
}

/// [`log2_of_1_to_2`] is `s (c0 + c1 s^2 + c2 s^4 + c3 s^6)` with `s = (x - 1) / (x + 1)`, the best such odd
/// polynomial (by Lawson's iteration), whose beginning is the series `2 / ln 2 (s + s^3 / 3 + ...)`.
/// Source: Abramowitz & Stegun, "Handbook of Mathematical Functions", 1964, 4.1.27.
pub(crate) const LOG2: [f32; 4] = [2.885_388, 0.962_056, 0.568_914_2, 0.505_295_3];

/// Base 2 logarithm of numbers in 1..=2, within 3e-7; 0 of 1, and below 1.
fn log2_of_1_to_2(x: f32) -> f32 {
    let s = (x - 1.0) / (x + 1.0);
    let s2 = s * s;
    (((LOG2[3] * s2 + LOG2[2]) * s2 + LOG2[1]) * s2 + LOG2[0]) * s
}

fn filtered<T>(
    texture: &Texture,
    uv: DVec2,
    lod: f32,
    filter: Filter,
    decode: impl Fn([u16; 4]) -> T + Copy,
) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    let mips = &texture.mips;
    let place = [fold(uv.x, texture.wrap[0]), fold(uv.y, texture.wrap[1])];
    let finer = lod as usize; // within 0..n_levels
    match filter {
        Filter::Nearest => nearest(&mips.level(finer), texture.wrap, place, decode),
        Filter::Bilinear => bilinear(&mips.level(finer), texture.wrap, place, decode),
        _ => {
            let blend = lod - finer as f32;
            let color = bilinear(&mips.level(finer), texture.wrap, place, decode);
            if blend == 0.0 {
                return color;
            }
            let coarser = bilinear(&mips.level(finer + 1), texture.wrap, place, decode);
            mix(color, coarser, blend)
        }
    }
}

/// A coordinate brought into one period: 0..=1, or 0..=2 where every other tile mirrors.
fn fold(u: f64, wrap: Wrap) -> f64 {
    let folded = match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::Mirror => u - 2.0 * (0.5 * u).floor(),
        Wrap::Clamp => clamp(u, 0.0, 1.0),
    };
    if folded >= 0.0 { folded } else { 0.0 } // NaN, also from an infinity
}

fn nearest<T>(
    level: &Level<'_>,
    wrap: [Wrap; 2],
    place: [f64; 2],
    decode: impl Fn([u16; 4]) -> T,
) -> T {
    let column = nearest_texel(place[0], level.width(), wrap[0]);
    let row = nearest_texel(place[1], level.height(), wrap[1]);
    decode(level.texel(column, row))
}

fn nearest_texel(folded: f64, n: u32, wrap: Wrap) -> u32 {
    let n_period = if wrap == Wrap::Mirror { 2 * i64::from(n) } else { i64::from(n) };
    let i = (folded * f64::from(n)) as i64; // within 0..=n_period
    // The end of a period is reached from inside only: by rounding up, or by a clamped 1.
    wrapped(if i < n_period { i } else { n_period - 1 }, n, wrap)
}

fn bilinear<T>(
    level: &Level<'_>,
    wrap: [Wrap; 2],
    place: [f64; 2],
    decode: impl Fn([u16; 4]) -> T,
) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    let ([left, right], x) = neighbours(place[0], level.width(), wrap[0]);
    let ([above, below], y) = neighbours(place[1], level.height(), wrap[1]);
    let texel = |column, row| decode(level.texel(column, row));
    let upper = mix(texel(left, above), texel(right, above), x);
    let lower = mix(texel(left, below), texel(right, below), x);
    mix(upper, lower, y)
}

/// From `a` at 0 towards `b` at 1. In this form equal ends blend to exactly themselves, so
/// an even alpha never slips below its cutoff.
fn mix<T>(a: T, b: T, blend: f32) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    a + (b - a) * blend
}

/// The texels whose centres enclose the place, and how far it is towards the second.
fn neighbours(folded: f64, n: u32, wrap: Wrap) -> ([u32; 2], f32) {
    let x = folded * f64::from(n) - 0.5;
    let floor = x.floor();
    let i = floor as i64; // within -1..2 n
    ([wrapped(i, n, wrap), wrapped(i + 1, n, wrap)], (x - floor) as f32)
}

/// The texel that stands for texel `i` of the endless plane, for `i` at most one texel
/// outside the period.
fn wrapped(i: i64, n: u32, wrap: Wrap) -> u32 {
    let n = i64::from(n);
    let inside = match wrap {
        Wrap::Repeat if i < 0 => i + n,
        Wrap::Repeat if i >= n => i - n,
        Wrap::Repeat => i,
        Wrap::Mirror => {
            let turned = if i >= n { 2 * n - 1 - i } else { i };
            if turned < 0 { -1 - turned } else { turned }
        }
        Wrap::Clamp => clamp(i, 0, n - 1),
    };
    debug_assert!((0..n).contains(&inside), "{wrap:?} takes {i} to {inside} of {n}");
    inside as u32
}

#[cfg(test)]
mod tests {
    use cullet_scene::Sampler;
    use glam::{DVec2, DVec4};
    use proptest::prelude::*;

    use super::*;
    use crate::reference;
    use crate::testing::{config, noise, plain};

    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    const EVERY: [Filter; 5] = [
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Trilinear,
        Filter::TrilinearLog,
        Filter::Anisotropic,
    ];

    fn texture(width: u32, height: u32, wrap_u: Wrap, wrap_v: Wrap) -> Texture {
        Texture::new(&noise(width, height, 3), Sampler { wrap_u, wrap_v, ..Sampler::default() })
    }

    fn magnified(texture: &Texture, u: f32, v: f32, filter: Filter) -> Vec4 {
        sample(texture, Vec2::new(u, v), Vec2::ZERO, Vec2::ZERO, filter)
    }

    #[track_caller]
    fn check_texel(wrap: Wrap, u: f32, expected: u32) {
        let texture = texture(4, 1, wrap, wrap);
        let expected = decode(texture.mips.level(0).texel(expected, 0));
        assert_eq!(magnified(&texture, u, 0.5, Filter::Nearest), expected, "{wrap:?} at {u}");
    }

    #[test]
    fn repeat_tiles() {
        let cases = [(0.0, 0), (0.25, 1), (0.999, 3), (1.0, 0), (-0.1, 3), (-1e-30, 3), (5.3, 1)];
        cases.iter().for_each(|&(u, texel)| check_texel(Wrap::Repeat, u, texel));
    }

    #[test]
    fn mirror_turns_every_other_tile() {
        let above = [(0.1, 0), (0.99, 3), (1.0, 3), (1.3, 2), (1.9, 0), (2.0, 0)];
        let below = [(-1e-30, 0), (-0.1, 0), (-0.3, 1), (-1.0, 3), (-1.3, 2)];
        let cases = above.iter().chain(&below);
        cases.for_each(|&(u, texel)| check_texel(Wrap::Mirror, u, texel));
    }

    #[test]
    fn clamp_stays_at_the_edge() {
        let cases = [(-5.0, 0), (0.3, 1), (1.0, 3), (1e30, 3), (f32::NEG_INFINITY, 0)];
        cases.iter().for_each(|&(u, texel)| check_texel(Wrap::Clamp, u, texel));
        check_texel(Wrap::Clamp, f32::INFINITY, 3);
    }

    #[test]
    fn not_a_place_is_the_first_texel() {
        WRAPS.iter().for_each(|&wrap| check_texel(wrap, f32::NAN, 0));
        check_texel(Wrap::Repeat, f32::INFINITY, 0);
        check_texel(Wrap::Mirror, f32::NEG_INFINITY, 0);
        check_texel(Wrap::Repeat, 1e30, 0);
    }

    #[test]
    fn a_texel_centre_is_that_texel() {
        for wrap in WRAPS {
            let texture = texture(8, 4, wrap, wrap);
            for (x, y) in (0..32).map(|i| (i % 8, i / 8)) {
                let (u, v) = ((x as f32 + 0.5) / 8.0, (y as f32 + 0.5) / 4.0);
                let expected = decode(texture.mips.level(0).texel(x, y));
                for filter in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear] {
                    assert_eq!(magnified(&texture, u, v, filter), expected);
                }
            }
        }
    }

    #[test]
    fn the_longer_axis_sets_the_level() {
        let texture = texture(16, 4, Wrap::Repeat, Wrap::Repeat);
        let (x, y) = (Vec2::X / 16.0, Vec2::Y / 4.0);
        assert_eq!(lod(&texture, Vec2::ZERO, Vec2::ZERO, Filter::Trilinear), 0.0);
        assert_eq!(lod(&texture, x, y, Filter::Trilinear), 0.0);
        assert_eq!(lod(&texture, x * 2.0, y, Filter::Trilinear), 1.0);
        assert_eq!(lod(&texture, x, y * 4.0, Filter::Trilinear), 2.0);
        assert_eq!(lod(&texture, x * 1e6, y, Filter::Trilinear), 4.0);
        assert_eq!(lod(&texture, x, y * 4.0, Filter::Oversampled(2)), 1.0);
        assert_eq!(lod(&texture, x, y * 4.0, Filter::Oversampled(9)), 0.0);
        for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30] {
            assert_eq!(lod(&texture, x * bad, y, Filter::Trilinear), 4.0);
            assert_eq!(lod(&texture, x, y * bad, Filter::Trilinear), 4.0);
        }
    }

    #[test]
    fn a_slanted_footprint_is_cut_along_its_longer_axis() {
        let texture = texture(16, 4, Wrap::Repeat, Wrap::Repeat);
        let (x, y) = (Vec2::X / 16.0, Vec2::Y / 4.0);
        let cut = |ddx: Vec2, ddy: Vec2| {
            let Stretch { n, axis, lod } = stretch(&texture, ddx, ddy);
            (n, axis.as_vec2(), lod)
        };
        assert_eq!(cut(x, y), (1, y, 0.0));
        assert_eq!(cut(x * 8.0, y * 2.0), (4, x * 8.0, 1.0));
        assert_eq!(cut(x, y * 3.0), (3, y * 3.0, 0.0));
        // Less than a texel wide, and longer than sixteen pieces reach.
        assert_eq!(cut(x * 0.01, y * 2.0), (2, y * 2.0, 0.0));
        assert_eq!(cut(x * 64.0, y), (16, x * 64.0, 2.0));
        for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30] {
            let (n, axis, lod) = cut(x * bad, y);
            assert_eq!((n, lod), (1, 4.0));
            assert!(axis.is_finite());
        }
    }

    /// Columns of black and white, seen so that a pixel spans many rows: only what follows the longer axis
    /// still tells them apart.
    #[test]
    fn what_is_seen_at_a_slant_stays_sharp_across() {
        let stripes = [0, 255].map(|grey| [grey, grey, grey, 255]).as_flattened().repeat(8 * 16);
        let image =
            cullet_scene::Image { width: 16, height: 16, rgba: stripes, ..Default::default() };
        let texture = Texture::new(&image, Sampler::default());
        let (ddx, ddy) = (Vec2::X / 16.0, Vec2::Y / 2.0);
        let at =
            |texel: f32, filter| sample(&texture, Vec2::new(texel / 16.0, 0.5), ddx, ddy, filter);
        assert_eq!(at(2.5, Filter::Anisotropic), Vec4::new(0.0, 0.0, 0.0, 1.0));
        assert_eq!(at(3.5, Filter::Anisotropic), Vec4::ONE);
        let [dark, light] = [2.5, 3.5].map(|texel| at(texel, Filter::Trilinear).x);
        assert!((dark - light).abs() < 1e-3, "{dark} {light}");
    }

    #[test]
    fn levels_blend_in_proportion_to_the_length() {
        let texture = texture(64, 64, Wrap::Repeat, Wrap::Repeat);
        let of =
            |texels: f32| lod(&texture, Vec2::X * (texels / 64.0), Vec2::ZERO, Filter::Trilinear);
        let lengths = [0.5, 1.0, 1.25, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 8.0, 63.5, 64.0, 100.0];
        let lods = [0.0, 0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 2.25, 2.75, 3.0, 5.984_375, 6.0, 6.0];
        assert_eq!(lengths.map(of), lods);
    }

    #[test]
    fn logarithms_are_within_their_stated_error() {
        for x in (0..=1 << 23).step_by(7).map(|i| f32::from_bits(1.0_f32.to_bits() + i)) {
            let log2 = log2_of_1_to_2(x);
            let error = (f64::from(log2) - libm::log2(f64::from(x))).abs();
            assert!((0.0..1.0).contains(&log2) && error <= 3e-7, "{log2} of {x}: {error:e}");
        }
        assert_eq!(log2_of_1_to_2(1.0), 0.0);
        assert!(log2_of_1_to_2(2.0) < 1.0);
    }

    #[test]
    fn levels_blend_by_the_logarithm_where_asked_for() {
        let texture = texture(64, 64, Wrap::Repeat, Wrap::Repeat);
        let side = Vec2::X / 64.0;
        for i in -20..200 {
            let exact = 0.05 * f64::from(i);
            let ddx = side * libm::exp2(exact) as f32;
            let lod = lod(&texture, ddx, Vec2::ZERO, Filter::TrilinearLog);
            let error = f64::from(lod) - exact.clamp(0.0, 6.0);
            assert!(error.abs() < 1e-6, "{lod} for {exact}");
        }
    }

    #[test]
    fn halfway_between_levels_is_the_finer() {
        let texture = texture(64, 64, Wrap::Repeat, Wrap::Repeat);
        for filter in [Filter::Nearest, Filter::Bilinear] {
            // The diagonal of a texel is halfway, exactly.
            for (texels, level) in [(1.0, 0.0), (2.0, 1.0), (16.0, 4.0)] {
                let of =
                    |texels: f32| lod(&texture, Vec2::splat(texels / 64.0), Vec2::ZERO, filter);
                assert_eq!([of(texels), of(texels * 1.001)], [level, level + 1.0]);
            }
        }
    }

    #[test]
    fn extreme_places_and_sizes_stay_inside() {
        let extremes = [0.0, -0.0, 1.0, -1.0, 1e-45, -1e-45, 0.1, 1e9, -1e9, 1e30, -1e30]
            .into_iter()
            .chain([f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN]);
        let extremes: Vec<f32> = extremes.collect();
        for (width, height) in [(1, 1), (1, 5), (5, 1), (16384, 1), (3, 7)] {
            for wrap in WRAPS {
                let mut texture = texture(width, height, wrap, wrap);
                texture.mips = crate::Mips::new(plain(width, height, [255; 4])).into();
                for (&u, &d) in extremes.iter().flat_map(|u| extremes.iter().map(move |d| (u, d))) {
                    for filter in EVERY {
                        let (uv, ddx) = (Vec2::new(u, d), Vec2::new(d, u));
                        let color = sample(&texture, uv, ddx, Vec2::splat(d), filter);
                        assert_eq!(color, Vec4::ONE);
                    }
                }
            }
        }
    }

    proptest! {
        #![proptest_config(config(4000))]

        #[test]
        fn agrees_with_the_reference(
            size in (1..40_u32, 1..40_u32),
            uv in (-9.0..9.0_f32, -9.0..9.0_f32),
            derivatives in prop::array::uniform4(-0.3..0.3_f32),
            scale in 0..12,
            wraps in (0..3_usize, 0..3_usize),
        ) {
            let texture = texture(size.0, size.1, WRAPS[wraps.0], WRAPS[wraps.1]);
            let uv = Vec2::from(uv);
            let [a, b, c, d] = derivatives.map(|d| d / (1 << scale) as f32);
            let (ddx, ddy) = (Vec2::new(a, b), Vec2::new(c, d));
            let (ddx64, ddy64) = (ddx.as_dvec2(), ddy.as_dvec2());
            let lod = reference::lod(&texture, ddx64, ddy64, Filter::Trilinear);
            let level_is_clear = (lod.fract() - 0.5).abs() > 1e-5;
            for filter in EVERY {
                let is_clear = match filter {
                    Filter::Nearest | Filter::Bilinear => level_is_clear,
                    Filter::Anisotropic => reference::pieces_are_clear(&texture, ddx64, ddy64),
                    _ => true,
                };
                if is_clear {
                    let color = sample(&texture, uv, ddx, ddy, filter);
                    let exact = reference::sample(&texture, uv.as_dvec2(), ddx64, ddy64, filter);
                    let error = (color.as_dvec4() - exact).abs().max_element();
                    prop_assert!(error < 2e-6, "{filter:?} {color} {exact} {error:e}");
                    let alpha = sample_alpha(&texture, uv, ddx, ddy, filter);
                    prop_assert_eq!(alpha.to_bits(), color.w.to_bits());
                }
            }
        }
    }

    #[test]
    fn the_reference_knows_a_checker() {
        let image = cullet_scene::Image {
            width: 2,
            height: 1,
            rgba: vec![0, 0, 0, 255, 255, 255, 255, 255],
            ..Default::default()
        };
        let texture = Texture::new(&image, Sampler::default());
        let middle = reference::sample(
            &texture,
            DVec2::new(0.5, 0.5),
            DVec2::ZERO,
            DVec2::ZERO,
            Filter::Trilinear,
        );
        assert_eq!(middle, DVec4::new(0.5, 0.5, 0.5, 1.0));
    }
}
