//! From the numbers of a frame to the samples of a picture file.
//!
//! Floats are stored as they are. Integers hold sRGB for colours; for data, a mapping to 0..1
//! that depends on the whole picture or scene and never on the region drawn, rounded to the
//! nearest code.

use cullet::Frame;
use cullet::cull::Aabb;
use cullet::shade::srgb;
use glam::{Vec3, Vec4};

use super::passes::{Bits, PassName, Picture};
use crate::picture_file::{Pixels, Samples};

/// What integers span.
#[derive(Clone, Copy, Debug)]
pub struct Spans {
    /// Nearest and farthest distance in the whole picture; `None` when nothing is in it.
    pub depth: Option<(f32, f32)>,
    /// World-space box around the scene.
    pub bounds: Aabb,
}

/// The least and greatest number that is neither infinite nor NaN.
pub fn finite_range(depth: &[f32]) -> Option<(f32, f32)> {
    depth.iter().filter(|d| d.is_finite()).fold(None, |range, &d| match range {
        None => Some((d, d)),
        Some((least, most)) => Some((least.min(d), most.max(d))),
    })
}

/// The samples of `picture`.
pub fn pixels(picture: &Picture, frame: &Frame, spans: &Spans) -> Pixels {
    let (channels, samples) = match picture.pass {
        PassName::Color => color(frame, picture),
        PassName::Albedo => albedo(frame, picture.bits),
        PassName::Depth => {
            data(frame.depth.iter().map(|d| [*d]), picture.bits, |[d]| [shade_of(d, spans)])
        }
        PassName::Normal => data(frame.normal.iter().map(Vec3::to_array), picture.bits, |n| {
            n.map(|n| 0.5 * n + 0.5)
        }),
        PassName::Position => data(frame.position.iter().map(Vec3::to_array), picture.bits, |p| {
            place_in(p, &spans.bounds)
        }),
        PassName::Uv if picture.bits == Bits::F32 => {
            data(frame.uv.iter().map(|uv| uv.to_array()), picture.bits, |uv| uv)
        }
        PassName::Uv => data(frame.uv.iter().map(|uv| [uv.x, uv.y, 0.0]), picture.bits, |uv| {
            uv.map(|c| c - c.floor())
        }),
        PassName::Id => numbers(&frame.id, picture.bits),
        PassName::Triangle => numbers(&frame.triangle, picture.bits),
    };
    Pixels { width: frame.width, height: frame.height, channels, samples }
}

fn color(frame: &Frame, picture: &Picture) -> (usize, Samples) {
    let channels = if picture.alpha { 4 } else { 3 };
    let samples = match picture.bits {
        Bits::U8 if picture.alpha => Samples::U8(frame.rgba8.as_flattened().to_vec()),
        Bits::U8 => {
            let rgb: Vec<[u8; 3]> = frame.rgba8.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            Samples::U8(rgb.into_flattened())
        }
        Bits::U16 => Samples::U16(
            frame.linear.iter().flat_map(|c| encode16(*c).into_iter().take(channels)).collect(),
        ),
        Bits::F32 => Samples::F32(frame.linear.iter().flat_map(Vec4::to_array).collect()),
    };
    (channels, samples)
}

fn albedo(frame: &Frame, bits: Bits) -> (usize, Samples) {
    let albedo = frame.albedo.iter();
    match bits {
        Bits::U8 => {
            let rgb = albedo.flat_map(|c| c.truncate().to_array().map(srgb::encode8));
            (3, Samples::U8(rgb.collect()))
        }
        Bits::U16 => {
            let rgb = albedo.flat_map(|c| c.truncate().to_array().map(srgb::encode16));
            (3, Samples::U16(rgb.collect()))
        }
        Bits::F32 => (4, Samples::F32(albedo.flat_map(Vec4::to_array).collect())),
    }
}

fn encode16(color: Vec4) -> [u16; 4] {
    let [r, g, b] = color.truncate().to_array().map(srgb::encode16);
    [r, g, b, nearest(color.w, 65535.0) as u16]
}

/// Numbers of things, which integers hold in 24 bits.
fn numbers(numbers: &[u32], bits: Bits) -> (usize, Samples) {
    if bits == Bits::F32 {
        return (1, Samples::F32(numbers.iter().map(|n| *n as f32).collect()));
    }
    let bytes = numbers.iter().flat_map(|n| {
        let [_, high, middle, low] = n.to_be_bytes();
        [high, middle, low]
    });
    (3, Samples::U8(bytes.collect()))
}

/// Numbers as they are, or mapped to 0..1 and rounded.
fn data<const N: usize>(
    values: impl Iterator<Item = [f32; N]>,
    bits: Bits,
    to_unit: impl Fn([f32; N]) -> [f32; N],
) -> (usize, Samples) {
    let samples = match bits {
        Bits::U8 => {
            Samples::U8(values.flat_map(|v| to_unit(v).map(|v| nearest(v, 255.0) as u8)).collect())
        }
        Bits::U16 => Samples::U16(
            values.flat_map(|v| to_unit(v).map(|v| nearest(v, 65535.0) as u16)).collect(),
        ),
        Bits::F32 => Samples::F32(values.flatten().collect()),
    };
    (N, samples)
}

/// `value` in 0..1 as the nearest of `white + 1` codes; NaN is 0.
fn nearest(value: f32, white: f64) -> u32 {
    (f64::from(value).clamp(0.0, 1.0) * white + 0.5) as u32
}

/// 0 at the nearest thing, 1 at the farthest and where nothing is.
fn shade_of(distance: f32, spans: &Spans) -> f32 {
    match spans.depth {
        Some((near, far)) if distance.is_finite() && near < far => (distance - near) / (far - near),
        Some(_) if distance.is_finite() => 0.0,
        _ => 1.0,
    }
}

/// 0 at the least corner of the box, 1 at the greatest; 0 also for the zero vector, which says
/// that nothing is there.
fn place_in(position: [f32; 3], bounds: &Aabb) -> [f32; 3] {
    if position == [0.0; 3] {
        return position;
    }
    let (min, size) = (bounds.min.to_array(), (bounds.max - bounds.min).to_array());
    std::array::from_fn(|i| {
        let share = (f64::from(position[i]) - min[i]) / size[i];
        if share.is_finite() { share as f32 } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Target;
    use crate::picture_file::Format;
    use glam::{DVec3, Vec2};

    #[track_caller]
    fn check(pass: PassName, bits: Bits, alpha: bool, channels: usize, samples: Samples) {
        let frame = Frame {
            width: 2,
            height: 1,
            rgba8: vec![[1, 2, 3, 255], [4, 5, 6, 0]],
            linear: vec![Vec4::new(2.0, 1.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 0.0, 0.5)],
            depth: vec![2.0, f32::INFINITY],
            normal: vec![Vec3::new(0.0, 1.0, -1.0), Vec3::ZERO],
            albedo: vec![Vec4::new(1.0, 0.0, 0.5, 0.25), Vec4::ZERO],
            uv: vec![Vec2::new(1.25, -0.25), Vec2::ZERO],
            position: vec![Vec3::new(1.0, 5.0, 4.0), Vec3::ZERO],
            id: vec![0x010203, 0],
            triangle: vec![0, 0x0a0b0c],
        };
        let bounds = Aabb { min: DVec3::new(-1.0, 5.0, 0.0), max: DVec3::new(1.0, 5.0, 8.0) };
        let spans = Spans { depth: Some((1.0, 3.0)), bounds };
        let format = if bits == Bits::F32 { Format::F32 } else { Format::Png };
        let picture = Picture { pass, target: Target::Stdout, format, bits, alpha };
        let found = pixels(&picture, &frame, &spans);
        assert_eq!((found.channels, found.samples), (channels, samples));
    }

    #[test]
    fn integers() {
        use PassName::*;
        use Samples::{U8, U16};
        check(Color, Bits::U8, false, 3, U8(vec![1, 2, 3, 4, 5, 6]));
        check(Color, Bits::U8, true, 4, U8(vec![1, 2, 3, 255, 4, 5, 6, 0]));
        let white = 65535;
        check(Color, Bits::U16, true, 4, U16(vec![white, white, 0, white, 0, 0, 0, 32768]));
        check(Albedo, Bits::U8, false, 3, U8(vec![255, 0, 188, 0, 0, 0]));
        check(Depth, Bits::U8, false, 1, U8(vec![128, 255]));
        check(Depth, Bits::U16, false, 1, U16(vec![32768, white]));
        check(Normal, Bits::U8, false, 3, U8(vec![128, 255, 0, 128, 128, 128]));
        check(Position, Bits::U8, false, 3, U8(vec![255, 0, 128, 0, 0, 0]));
        check(Uv, Bits::U8, false, 3, U8(vec![64, 191, 0, 0, 0, 0]));
        check(Id, Bits::U16, false, 3, U8(vec![1, 2, 3, 0, 0, 0]));
        check(Triangle, Bits::U8, false, 3, U8(vec![0, 0, 0, 10, 11, 12]));
    }

    #[test]
    fn floats() {
        use Samples::F32;
        let check = |pass, channels, samples: &[f32]| {
            check(pass, Bits::F32, true, channels, F32(samples.to_vec()));
        };
        check(PassName::Color, 4, &[2.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5]);
        check(PassName::Albedo, 4, &[1.0, 0.0, 0.5, 0.25, 0.0, 0.0, 0.0, 0.0]);
        check(PassName::Depth, 1, &[2.0, f32::INFINITY]);
        check(PassName::Normal, 3, &[0.0, 1.0, -1.0, 0.0, 0.0, 0.0]);
        check(PassName::Position, 3, &[1.0, 5.0, 4.0, 0.0, 0.0, 0.0]);
        check(PassName::Uv, 2, &[1.25, -0.25, 0.0, 0.0]);
        check(PassName::Id, 1, &[66051.0, 0.0]);
        check(PassName::Triangle, 1, &[0.0, 658188.0]);
    }

    #[test]
    fn ranges_pass_over_nothing() {
        assert_eq!(finite_range(&[f32::INFINITY, 3.0, f32::NAN, 2.0]), Some((2.0, 3.0)));
        assert_eq!(finite_range(&[f32::INFINITY]), None);
    }
}
