//! How close may two planes be and still be told apart? Measured with the rasterizer, for every
//! depth format and mapping, against the width of one depth code.
//!
//! Two squares parallel to the picture fill it, the farther one drawn first, so that wherever the
//! two fall into one code the wrong one shows. The separation is narrowed down by bisection until
//! the last pixel is right. Where in its code a plane lies decides how lucky it is; of several
//! planes near each distance the unluckiest counts.

pub mod plot;
pub mod transform;

use cullet::raster::{
    DepthFormat, Facing, KeepAll, NO_TRIANGLE, Placer, ReversedF32, StandardF32, StandardU16,
    StandardU24, Tile, Triangles, cover, set_up,
};
use cullet::transform::{ClipPoint, PlaneMask};
use cullet::{Camera, Projection, View, Viewport};
use glam::DVec3;

/// Sides of the picture, px.
const SIZE: [u32; 2] = [16, 12];

/// Planes tried near each distance.
const PHASES: u32 = 24;

/// Separations beyond this share of the distance are not looked at.
pub const WIDEST: f64 = 1e3;

/// A depth format by name, as the study goes over them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// f32, 1 at the near plane.
    ReversedF32,
    /// f32, 0 at the near plane.
    StandardF32,
    /// 24 bits, 0 at the near plane.
    StandardU24,
    /// 16 bits, 0 at the near plane.
    StandardU16,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 4] =
        [Format::ReversedF32, Format::StandardF32, Format::StandardU24, Format::StandardU16];

    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Format::ReversedF32 => "reversed f32",
            Format::StandardF32 => "standard f32",
            Format::StandardU24 => "u24",
            Format::StandardU16 => "u16",
        }
    }

    /// Width of one code around reversed depth `depth`, in reversed depth: that of the coarser side
    /// where widths change.
    pub fn code(self, depth: f64) -> f64 {
        match self {
            Format::ReversedF32 => f32_step(depth),
            Format::StandardF32 => f32_step(1.0 - depth),
            Format::StandardU24 => 1.0 / f64::from(StandardU24::FARTHEST),
            Format::StandardU16 => 1.0 / f64::from(StandardU16::FARTHEST),
        }
    }
}

fn f32_step(depth: f64) -> f64 {
    let code = depth as f32;
    f64::from(code.next_up()) - f64::from(code)
}

/// Near and far distances of a perspective view.
#[derive(Clone, Copy, Debug)]
pub struct Mapping {
    /// Scene units.
    pub near: f64,
    /// Scene units; may be infinite.
    pub far: f64,
}

impl Mapping {
    /// Reversed depth of something at `distance`.
    pub fn depth(self, distance: f64) -> f64 {
        let (near, inverse_far) = (self.near, 1.0 / self.far);
        (1.0 / distance - inverse_far) / (1.0 / near - inverse_far)
    }

    /// The distance of reversed depth `depth`; infinite or negative beyond the last one.
    pub fn distance(self, depth: f64) -> f64 {
        let inverse_far = 1.0 / self.far;
        1.0 / (depth * (1.0 / self.near - inverse_far) + inverse_far)
    }

    /// How much farther than `distance`, as a share of it, `n` codes are; infinite where so many do
    /// not fit before the far plane.
    pub fn codes(self, format: Format, distance: f64, n: f64) -> f64 {
        let depth = self.depth(distance);
        let beyond = depth - n * format.code(depth);
        if beyond > 0.0 { self.distance(beyond) / distance - 1.0 } else { f64::INFINITY }
    }

    /// A camera at the origin that looks down -z.
    pub fn view(self) -> View {
        let lens = Projection::Perspective { yfov: 1.0, near: self.near, far: self.far };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens);
        let viewport = Viewport::new(SIZE[0], SIZE[1]).expect("a possible size");
        View::new(&camera.expect("a possible camera"), viewport)
    }
}

/// How many pixels of two planes show the one at `first`, which is drawn first, and how many the
/// other.
pub fn shown(format: Format, view: &View, first: f64, second: f64) -> [usize; 2] {
    match format {
        Format::ReversedF32 => draw::<ReversedF32>(view, first, second),
        Format::StandardF32 => draw::<StandardF32>(view, first, second),
        Format::StandardU24 => draw::<StandardU24>(view, first, second),
        Format::StandardU16 => draw::<StandardU16>(view, first, second),
    }
}

fn draw<D: DepthFormat>(view: &View, first: f64, second: f64) -> [usize; 2] {
    let n = SIZE[0] as usize * SIZE[1] as usize;
    let (mut ids, mut depth) = (vec![NO_TRIANGLE; n], vec![D::FARTHEST; n]);
    let mut tile = Tile::<D> { x: 0, y: 0, width: SIZE[0], ids: &mut ids, depth: &mut depth };
    tile.clear();
    let placer = Placer::<8>::new(view.viewport(), PlaneMask::ALL);
    let window = view.window();
    for (k, distance) in [first, second].into_iter().enumerate() {
        // Beyond the picture on all sides, so that no edge is in it.
        let corners = [[-0.2, -0.2], [-0.2, 1.3], [1.3, 1.3], [1.3, -0.2]];
        let vertices = corners.map(|[u, v]| {
            let point = window.at(u, v, distance);
            placer.place(ClipPoint::from_model(view.clip_from_view(), point))
        });
        let input = Triangles {
            vertices: &vertices,
            triangles: &[[0, 1, 2], [0, 2, 3]],
            first_vertex: 0,
            first_id: 2 * k as u32,
            facing: Facing::Both,
        };
        let mut triangles = Vec::new();
        set_up(&placer, &input, &mut triangles);
        for triangle in &triangles {
            cover::<D, 8, _>(&mut tile, triangle, &mut KeepAll);
        }
    }
    let of = |k: u32| ids.iter().filter(|&&id| id / 2 == k).count();
    [of(0), of(1)]
}

/// What was measured at one distance.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Scene units.
    pub distance: f64,
    /// Smallest separation with no wrong pixel, as a share of the distance; infinite where none up
    /// to [`WIDEST`] is wide enough.
    pub measured: f64,
    /// Width of one code, as a share of the distance; infinite beyond the last one.
    pub predicted: f64,
}

/// Place number `phase` near `distance`: irrational steps over a few codes, or all over the one there
/// where codes are wider than a thousandth of the distance. `None` where that code has no end.
fn place(format: Format, mapping: Mapping, distance: f64, phase: u32) -> Option<f64> {
    let step = f64::from(phase) * 0.618_033_988_749_894_9;
    let is_fine = mapping.codes(format, distance, f64::from(PHASES)) < 1e-3;
    let step = if is_fine { step } else { step.fract() };
    let depth = mapping.depth(distance);
    let near = mapping.distance(depth - step * format.code(depth));
    (near > 0.0 && near < mapping.far).then_some(near)
}

/// The smallest separation at `distance` from which on no pixel is wrong.
pub fn measure(format: Format, mapping: Mapping, distance: f64) -> Point {
    let view = mapping.view();
    let n_pixels = SIZE[0] as usize * SIZE[1] as usize;
    let mut point = Point { distance, measured: 0.0, predicted: 0.0 };
    let is_right = |near: f64, separation: f64| {
        let beyond = near * (1.0 + separation);
        beyond < mapping.far && shown(format, &view, beyond, near) == [0, n_pixels]
    };
    for phase in 0..PHASES {
        let Some(near) = place(format, mapping, distance, phase) else {
            (point.measured, point.predicted) = (f64::INFINITY, f64::INFINITY);
            continue;
        };
        point.predicted = point.predicted.max(mapping.codes(format, near, 1.0));
        let (mut low, mut high) = (1e-9, WIDEST);
        if mapping.far.is_finite() {
            high = high.min(mapping.far / near - 1.0) * (1.0 - 1e-9);
        }
        if !is_right(near, high) {
            point.measured = f64::INFINITY;
            continue;
        }
        // Narrowed to a thousandth of itself; all separations above are wide enough, since codes
        // follow depth monotonically.
        while high / low > 1.001 {
            let middle = (low * high).sqrt();
            if is_right(near, middle) { high = middle } else { low = middle }
        }
        point.measured = point.measured.max(high);
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAPPINGS: [Mapping; 4] = [
        Mapping { near: 0.1, far: 1e4 },
        Mapping { near: 0.1, far: f64::INFINITY },
        Mapping { near: 1e-6, far: 1e12 },
        Mapping { near: 1.0, far: 50.0 },
    ];

    /// Distances that the mapping and the format have codes for.
    fn distances(format: Format, mapping: Mapping) -> Vec<f64> {
        let all = (-5..=11).flat_map(|e| [1.0, 2.7, 7.3].map(|m| m * 10_f64.powi(e)));
        let inside =
            |d: &f64| *d > 1.5 * mapping.near && mapping.codes(format, *d, 4.0).is_finite();
        all.filter(inside).collect()
    }

    #[test]
    fn planes_two_codes_apart_have_no_wrong_pixel_in_any_format() {
        let mut n = 0;
        for (format, mapping) in pairs() {
            let view = mapping.view();
            for near in distances(format, mapping) {
                let far = near * (1.0 + mapping.codes(format, near, 2.0));
                let all = SIZE[0] as usize * SIZE[1] as usize;
                let case = format!("{} {mapping:?} at {near}", format.name());
                assert_eq!(shown(format, &view, near, far), [all, 0], "{case}");
                assert_eq!(shown(format, &view, far, near), [0, all], "{case}");
                n += 1;
            }
        }
        assert!(n > 200, "{n}");
    }

    #[test]
    fn planes_in_one_code_show_the_first_drawn_everywhere() {
        for (format, mapping) in pairs() {
            let view = mapping.view();
            for distance in distances(format, mapping) {
                // To the middle of a code: a tenth of it to either side rounds to it.
                let depth = mapping.depth(distance);
                let middle = match format {
                    Format::ReversedF32 => f64::from(depth as f32),
                    Format::StandardF32 => 1.0 - f64::from((1.0 - depth) as f32),
                    _ => {
                        let codes = 1.0 / format.code(depth);
                        1.0 - ((1.0 - depth) * codes).round_ties_even() / codes
                    }
                };
                let tenth = 0.1 * format.code(middle);
                // Distances themselves are rounded; where a code is no wider, there is no middle.
                let [near, far] = [middle + tenth, middle - tenth].map(|d| mapping.distance(d));
                if far <= near || middle <= tenth {
                    continue;
                }
                let all = SIZE[0] as usize * SIZE[1] as usize;
                let case = format!("{} {mapping:?} at {distance}", format.name());
                assert_eq!(shown(format, &view, near, far), [all, 0], "{case}");
                assert_eq!(shown(format, &view, far, near), [all, 0], "{case}");
            }
        }
    }

    #[test]
    fn what_is_measured_is_the_width_of_a_code() {
        for (format, mapping) in pairs() {
            for distance in distances(format, mapping).into_iter().step_by(6) {
                let point = measure(format, mapping, distance);
                let ratio = point.measured / point.predicted;
                assert!(ratio > 0.8 && ratio < 1.01, "{} {mapping:?} {point:?}", format.name());
            }
        }
    }

    fn pairs() -> impl Iterator<Item = (Format, Mapping)> {
        Format::ALL.into_iter().flat_map(|format| MAPPINGS.map(|mapping| (format, mapping)))
    }
}
