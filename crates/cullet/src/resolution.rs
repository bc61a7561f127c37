//! Fewer pixels, then more of them: half resolution, and full resolution where it shows.
//!
//! A half frame has a quarter of the pixels to cover and shade. Its pixels are the centres of four,
//! so the nearest four are blended 9 : 3 : 3 : 1 (bilinear, in linear light with alpha counted in).
//! The adaptive frame begins the same way; then blocks of the picture in which neighbours of the half
//! frame differ are drawn again, whole. What is missed is what falls between all pixels of the half
//! frame.
//!
//! Data is never blended: it is always drawn in full. Everything hangs on the whole picture's grid of
//! blocks, so no region, tile or thread shows.

use std::time::Instant;

use cullet_shade::Encoding;
use cullet_transform::{View, Viewport};
use glam::{Vec3, Vec4};

use crate::bins::Grid;
use crate::frame::Target;
use crate::renderer::visible_region;
use crate::schedule::{for_each, thread_count};
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
    /// One of four, and each in blocks of 32 x 32 where those differ.
    Adaptive,
}

/// Pixels along a side of the blocks that adaptive frames draw again.
const BLOCK: u32 = 32;

/// Neighbours in the half frame differ if any of their codes differ by more: what shading changes
/// over two pixels without an edge stays below.
const CODES: u8 = 20;

/// Rows of a job.
const ROWS: u32 = 16;

/// Memory for the half frame.
#[derive(Debug, Default)]
pub(crate) struct HalfScratch {
    frame: Frame,
    /// By block of the region: whether it is to be drawn in full.
    differ: Vec<bool>,
}

impl HalfScratch {
    /// Memory held.
    pub fn bytes(&self) -> usize {
        let Frame { linear, rgba8, .. } = &self.frame;
        linear.capacity() * size_of::<Vec4>() + rgba8.capacity() * 4 + self.differ.capacity()
    }
}

impl Renderer {
    /// Draws the colours of a frame by [`Settings::resolution`], and its data in full. Counters are
    /// those of the half frame.
    pub(crate) fn reduced(
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
        let of_half = Settings {
            passes: Passes::NONE.with(Pass::Linear).with(Pass::Color),
            region: Some(part),
            ..full
        };
        let mut stats = self.render(prepared, &half_view, &of_half, &mut scratch.frame);

        let data = settings.passes.data();
        if data != Passes::NONE {
            self.render(prepared, view, &Settings { passes: data, ..full }, frame);
        } else {
            frame.reset(region.width, region.height, Passes::NONE);
        }
        let resolve = Instant::now();
        frame.make_room(settings.passes.colors());
        let half = Half { frame: &scratch.frame, part, viewport: half_view.viewport() };
        shade_bands(threads, region, frame, ROWS, |rect, out| {
            half.enlarge(settings.encoding, rect, out);
            encode_linear(settings.encoding, rect, out);
            0
        });
        stats.stages.resolve += resolve.elapsed();

        if settings.resolution == Resolution::Adaptive {
            let differ = &mut scratch.differ;
            half.find_differences(region, threads, differ);
            let passes = settings.passes.colors();
            let full = Settings { passes, tile_px: BLOCK, ..full };
            let again = self.blocks(prepared, view, &full, (region, &scratch.differ), frame);
            stats.stages = stats.stages.plus(&again.stages);
            stats.pixels_shaded += again.pixels_shaded;
        }
        self.half = scratch;
        stats.scratch_bytes = self.scratch_bytes();
        stats.total = start.elapsed();
        stats
    }
}

/// The part of the half picture that `region` hangs on: its whole blocks and one pixel around them.
fn half_region(region: Region, half: Viewport) -> Region {
    let span = |start: u32, len: u32, side: u32| {
        let first = (start / BLOCK * (BLOCK / 2)).saturating_sub(1);
        let end = (start + len).div_ceil(BLOCK) * (BLOCK / 2) + 1;
        (first, end.min(side) - first)
    };
    let (x, width) = span(region.x, region.width, half.width());
    let (y, height) = span(region.y, region.height, half.height());
    Region { x, y, width, height }
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

    /// Says of each block of `region`, row by row, whether neighbours in or around it differ.
    fn find_differences(&self, region: Region, threads: usize, differ: &mut Vec<bool>) {
        let grid = Grid::new(region, BLOCK);
        differ.clear();
        differ.resize(grid.len(), false);
        let rows = differ.chunks_mut(grid.size[0] as usize).enumerate();
        for_each(threads, rows, |(row, differ)| {
            let row = grid.first[1] + row as u32;
            for (differ, column) in differ.iter_mut().zip(grid.first[0]..) {
                *differ = self.differs(column, row);
            }
        });
    }

    fn differs(&self, column: u32, row: u32) -> bool {
        let span = |block: u32, side: u32, origin: u32| {
            let first = (block * (BLOCK / 2)).saturating_sub(1);
            let end = ((block + 1) * (BLOCK / 2) + 1).min(side);
            (first - origin) as usize..(end - origin) as usize
        };
        let columns = span(column, self.viewport.width(), self.part.x);
        let mut above: Option<&[[u8; 4]]> = None;
        for row in span(row, self.viewport.height(), self.part.y) {
            let start = row * self.frame.width as usize;
            let row = &self.frame.rgba8[start + columns.start..start + columns.end];
            let below = above.is_some_and(|above| above.iter().zip(row).any(far_apart));
            if below || row.iter().zip(&row[1..]).any(far_apart) {
                return true;
            }
            above = Some(row);
        }
        false
    }
}

fn far_apart((a, b): (&[u8; 4], &[u8; 4])) -> bool {
    let mut largest = 0;
    for channel in 0..4 {
        largest = a[channel].abs_diff(b[channel]).max(largest);
    }
    largest > CODES
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
    fn adaptive_is_nearer_to_full_and_shades_less() {
        let [full, half, adaptive] = [Resolution::Full, Resolution::Half, Resolution::Adaptive]
            .map(|resolution| draw(&with(resolution), "sphere:64"));
        assert!(half.1.pixels_shaded * 7 < full.1.pixels_shaded * 2);
        assert!(adaptive.1.pixels_shaded < full.1.pixels_shaded);
        let (coarse, fine) = (error(&full.0, &half.0), error(&full.0, &adaptive.0));
        assert!(0.0 < fine && fine < 0.05 * coarse, "{fine} {coarse}");
        assert_eq!((&half.0.id, &adaptive.0.id), (&full.0.id, &full.0.id));
    }

    #[test]
    fn blocks_drawn_again_are_those_of_the_full_frame() {
        let [full, adaptive] =
            [Resolution::Full, Resolution::Adaptive].map(|r| draw(&with(r), "masks").0);
        let same = full.linear.iter().zip(&adaptive.linear).filter(|(a, b)| a == b).count();
        assert!(same > full.len() / 2, "{same}");
    }

    #[test]
    fn regions_tiles_and_threads_do_not_show() {
        let region = Region { x: 37, y: 5, width: 59, height: 41 };
        for resolution in [Resolution::Half, Resolution::Adaptive] {
            for antialias in [Antialias::None, Antialias::Msaa4] {
                let whole = Settings { antialias, background: Vec4::ZERO, ..with(resolution) };
                let part = Settings { region: Some(region), threads: 3, tile_px: 24, ..whole };
                let (whole, part) = (draw(&whole, "masks").0, draw(&part, "masks").0);
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
