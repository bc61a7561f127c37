//! Fewer pixels: half resolution, and what adaptive resolution asks of regions.
//!
//! A half frame has a quarter of the pixels to cover and shade. Its pixels are the centres of four,
//! so the nearest four are blended 9 : 3 : 3 : 1 (bilinear, in linear light with alpha counted in).
//! Adaptive frames spare shading alone, cell by cell ([`crate::adaptive`]); a region of one is drawn in
//! whole cells and cut out.
//!
//! Data is never blended: it is always drawn in full.

use std::time::Instant;

use cullet_shade::Encoding;
use cullet_transform::{View, Viewport};
use glam::{Vec3, Vec4};

use crate::adaptive::whole_cells;
use crate::frame::Target;
use crate::renderer::visible_region;
use crate::schedule::thread_count;
use crate::shading::{encode, encode_linear, shade_bands};
use crate::{Frame, FrameStats, Pass, Passes, Prepared, Region, Renderer, Settings};

/// How many pixels are coloured. The ray caster, which is for checking, colours each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Resolution {
    /// Each.
    #[default]
    Full,
    /// One of four; the others are blended from those around them.
    Half,
    /// Each, but one of four in cells of 8 x 8 pixels that show one triangle whose colours change little;
    /// there the others are blended. No edge moves. [`ShadingRate::Two`](crate::ShadingRate::Two) goes
    /// before it.
    Adaptive,
}

/// Rows of a job.
const ROWS: u32 = 16;

/// Memory for another frame.
#[derive(Debug, Default)]
pub(crate) struct HalfScratch {
    frame: Frame,
}

impl HalfScratch {
    /// Memory held.
    pub fn bytes(&self) -> usize {
        let Frame { linear, rgba8, .. } = &self.frame;
        linear.capacity() * size_of::<Vec4>() + rgba8.capacity() * 4
    }
}

/// Whether adaptive cells of what is to be drawn are whole.
pub(crate) fn is_whole_cells(view: &View, settings: &Settings) -> bool {
    let region = visible_region(view, settings);
    region == whole_cells(region, view.viewport().width(), view.viewport().height())
}

impl Renderer {
    /// Draws the colours of a frame at half resolution, and its data in full. Counters are
    /// those of the half frame.
    pub(crate) fn halved(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        frame: &mut Frame,
    ) -> FrameStats {
        let start = Instant::now();
        let threads = thread_count(settings.threads);
        let region = visible_region(view, settings);
        let mut scratch = std::mem::take(&mut self.half);
        let full = Settings { resolution: Resolution::Full, ..*settings };

        let half_view = view.halved();
        let part = half_region(region, half_view.viewport());
        let passes = Passes::NONE.with(Pass::Linear);
        let of_half = Settings { passes, region: Some(part), ..full };
        let mut stats = self.render(prepared, &half_view, &of_half, &mut scratch.frame);

        self.data_of(prepared, view, &full, frame);
        let resolve = Instant::now();
        frame.make_room(settings.passes.colors());
        let half = Half { frame: &scratch.frame, part, viewport: half_view.viewport() };
        shade_bands(threads, region, frame, ROWS, |rect, out| {
            half.enlarge(settings.encoding, rect, out);
            encode_linear(settings, rect, out);
            0
        });
        stats.stages.resolve += resolve.elapsed();
        self.half = scratch;
        stats.scratch_bytes = self.scratch_bytes();
        stats.total = start.elapsed();
        stats
    }

    /// Draws the colours of an adaptive frame in whole cells and cuts the region out; data is drawn as it
    /// is. Counters are those of the colours.
    pub(crate) fn in_whole_cells(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        frame: &mut Frame,
    ) -> FrameStats {
        let start = Instant::now();
        let region = visible_region(view, settings);
        let larger = whole_cells(region, view.viewport().width(), view.viewport().height());
        let mut scratch = std::mem::take(&mut self.half);
        let passes = settings.passes.colors();
        let colors = Settings { passes, region: Some(larger), ..*settings };
        let mut stats = self.render(prepared, view, &colors, &mut scratch.frame);
        self.data_of(prepared, view, settings, frame);
        frame.make_room(passes);
        let cut = |y: u32| {
            let first = (region.y - larger.y + y) * larger.width + region.x - larger.x;
            first as usize..(first + region.width) as usize
        };
        let rows = (0..region.height).map(cut);
        if passes.contains(Pass::Color) {
            frame.rgba8.clear();
            frame.rgba8.extend(rows.clone().flat_map(|row| &scratch.frame.rgba8[row]));
        }
        if passes.contains(Pass::Linear) {
            frame.linear.clear();
            frame.linear.extend(rows.flat_map(|row| &scratch.frame.linear[row]));
        }
        self.half = scratch;
        stats.scratch_bytes = self.scratch_bytes();
        stats.total = start.elapsed();
        stats
    }

    /// Gives a frame its size, and draws its data.
    fn data_of(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        frame: &mut Frame,
    ) {
        let passes = settings.passes.data();
        if passes == Passes::NONE {
            let region = visible_region(view, settings);
            frame.reset(region.width, region.height, Passes::NONE);
        } else {
            self.render(prepared, view, &Settings { passes, ..*settings }, frame);
        }
    }
}

/// The part of the half picture that `region` hangs on: what lies over it, and one pixel around that.
fn half_region(region: Region, half: Viewport) -> Region {
    let span = |start: u32, len: u32, side: u32| {
        let first = (start / 2).saturating_sub(1);
        ((start + len).div_ceil(2) + 1).min(side) - first
    };
    let (x, y) = ((region.x / 2).saturating_sub(1), (region.y / 2).saturating_sub(1));
    Region {
        x,
        y,
        width: span(region.x, region.width, half.width()),
        height: span(region.y, region.height, half.height()),
    }
}

/// A part of the half picture.
struct Half<'a> {
    frame: &'a Frame,
    part: Region,
    /// Of the whole half picture.
    viewport: Viewport,
}

impl Half<'_> {
    /// Fills the colours of a rectangle of the whole picture, linear ones if there is room for them.
    fn enlarge(&self, encoding: Encoding, rect: Region, out: &mut Target<'_>) {
        let columns: Vec<[usize; 2]> = (rect.x..rect.x + rect.width)
            .map(|x| nearest_two(x, self.viewport.width()).map(|x| (x - self.part.x) as usize))
            .collect();
        for y in 0..rect.height {
            let rows = nearest_two(rect.y + y, self.viewport.height());
            let [near, far] = rows.map(|row| {
                let start = (row - self.part.y) as usize * self.frame.width as usize;
                &self.frame.linear[start..start + self.frame.width as usize]
            });
            for (i, &[column, next]) in columns.iter().enumerate() {
                let color = blend([near[column], near[next], far[column], far[next]]);
                let at = y as usize * out.stride + i;
                match out.linear.get_mut(at) {
                    Some(linear) => *linear = color,
                    None => out.rgba8[at] = encode(encoding, color),
                }
            }
        }
    }
}

/// The pixel of the half picture over a pixel of the whole one, and the next nearest.
fn nearest_two(x: u32, side: u32) -> [u32; 2] {
    let over = x / 2;
    let beside = if x.is_multiple_of(2) { over.saturating_sub(1) } else { over + 1 };
    [over, beside.min(side - 1)]
}

/// Of the nearest, its neighbours across and down, and the farthest.
fn blend(colors: [Vec4; 4]) -> Vec4 {
    const WEIGHTS: [f32; 4] = [9.0 / 16.0, 3.0 / 16.0, 3.0 / 16.0, 1.0 / 16.0];
    let mut sum = Vec4::ZERO;
    for (color, weight) in colors.into_iter().zip(WEIGHTS) {
        sum += (color.truncate() * color.w).extend(color.w) * weight;
    }
    let rgb = if sum.w > 0.0 { sum.truncate() / sum.w } else { Vec3::ZERO };
    rgb.extend(sum.w)
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;

    use super::*;
    use crate::{Antialias, frame_scene};

    const SIDES: [u32; 2] = [203, 135];

    fn draw(settings: &Settings, scene: &str) -> (Frame, FrameStats) {
        let prepared = Prepared::new(synth(scene).unwrap()).unwrap();
        let viewport = Viewport::new(SIDES[0], SIDES[1]).unwrap();
        let view = View::new(&frame_scene(&prepared, viewport.aspect()), viewport);
        let mut frame = Frame::default();
        let stats = Renderer::default().render(&prepared, &view, settings, &mut frame);
        (frame, stats)
    }

    fn with(resolution: Resolution) -> Settings {
        let passes = Passes::COLOR.with(Pass::Linear).with(Pass::Id);
        Settings { resolution, passes, ..Settings::default() }
    }

    fn error(a: &Frame, b: &Frame) -> f32 {
        a.linear.iter().zip(&b.linear).map(|(a, b)| (a - b).length_squared()).sum()
    }

    #[test]
    fn pixels_blend_with_those_on_their_side() {
        assert_eq!(
            [0, 1, 2, 5, 6].map(|x| nearest_two(x, 4)),
            [[0, 0], [0, 1], [1, 0], [2, 3], [3, 2]]
        );
        assert_eq!(nearest_two(7, 4), [3, 3]);
        let even = Vec4::new(0.3, 0.7, 0.1, 1.0);
        assert_eq!(blend([even; 4]), even);
        assert_eq!(blend([Vec4::ZERO; 4]), Vec4::ZERO);
        let ahead = blend([even, Vec4::ZERO, even, Vec4::ZERO]);
        assert!((ahead - even.truncate().extend(0.75)).abs().max_element() < 1e-6);
    }

    #[test]
    fn half_shades_a_quarter_and_draws_data_in_full() {
        let [full, half] =
            [Resolution::Full, Resolution::Half].map(|r| draw(&with(r), "sphere:64"));
        assert!(half.1.pixels_shaded * 7 < full.1.pixels_shaded * 2);
        assert_eq!(half.0.id, full.0.id);
    }

    #[test]
    fn adaptive_is_full_but_for_small_changes_inside_triangles() {
        for (scene, antialias) in [("interior", Antialias::None), ("box-grid:2", Antialias::Msaa4)]
        {
            let passes = Passes::COLOR.with(Pass::Linear).with(Pass::Triangle);
            let [full, adaptive] = [Resolution::Full, Resolution::Adaptive]
                .map(|resolution| Settings { resolution, antialias, passes, ..Settings::default() })
                .map(|settings| draw(&settings, scene).0);
            assert_eq!(adaptive.triangle, full.triangle);
            let (mut n_blended, mut n_cells) = (0, 0);
            for y in (0..SIDES[1] - 8).step_by(8) {
                for x in (0..SIDES[0] - 8).step_by(8) {
                    let at = |i: u32| ((y + i / 8) * SIDES[0] + x + i % 8) as usize;
                    let differs = |i: &u32| adaptive.linear[at(*i)] != full.linear[at(*i)];
                    let n = (0..64).filter(differs).count();
                    n_blended += n;
                    n_cells += usize::from(n > 0);
                    let triangle = full.triangle[at(0)];
                    assert!(n == 0 || (0..64).all(|i| full.triangle[at(i)] == triangle), "{x} {y}");
                }
            }
            assert!(n_cells > 3 && n_blended > 8 * n_cells, "{scene}: {n_blended} in {n_cells}");
            let (half, _) = draw(
                &Settings {
                    resolution: Resolution::Half,
                    antialias,
                    passes,
                    ..Settings::default()
                },
                scene,
            );
            assert!(error(&full, &adaptive) < 0.02 * error(&full, &half), "{scene}");
        }
    }

    #[test]
    fn regions_tiles_and_threads_do_not_show() {
        let region = Region { x: 37, y: 5, width: 59, height: 41 };
        for resolution in [Resolution::Half, Resolution::Adaptive] {
            for antialias in [Antialias::None, Antialias::Msaa4] {
                let whole = Settings { antialias, background: Vec4::ZERO, ..with(resolution) };
                let part = Settings { region: Some(region), threads: 3, tile_px: 24, ..whole };
                let (whole, part) = (draw(&whole, "interior").0, draw(&part, "interior").0);
                for y in 0..region.height as usize {
                    let from = (y + region.y as usize) * SIDES[0] as usize + region.x as usize;
                    let width = region.width as usize;
                    let (a, b) = (from..from + width, y * width..(y + 1) * width);
                    assert_eq!(whole.rgba8[a.clone()], part.rgba8[b.clone()], "row {y}");
                    assert_eq!(whole.linear[a.clone()], part.linear[b.clone()], "row {y}");
                    assert_eq!(whole.id[a], part.id[b], "row {y}");
                }
            }
        }
    }
}
