//! Photograph mode: one picture from many, each sampled elsewhere within its pixels.
//!
//! A frame takes one sample per pixel, or shades once per triangle in it; here the whole frame is
//! drawn again for every sample, with the picture shifted under the pixels, and colours are
//! averaged. So textures, lights and masks are smoothed as well as edges, at the price of as many
//! frames. A sample stands for a part of the pixel only, so trilinear filtering looks into finer
//! levels ([`Filter::Oversampled`]): textures get sharper where one frame has to blur them. Other filters
//! see a whole pixel in each frame. Averages are of linear light with alpha counted in (Porter & Duff
//! 1984), in f64, over the area of each pixel (a box filter).
//!
//! Places within a pixel are Hammersley's points, moved to the middles of their cells: of `n` points
//! one in each of `n` columns, and, for powers of two, one in each of `n` rows.
//! Source: Haeberli & Akeley, "The Accumulation Buffer", 1990; Hammersley 1960; van der Corput 1935.

use std::time::Instant;

use cullet_shade::Filter;
use cullet_transform::View;
use glam::{DVec3, DVec4, Vec4};

use crate::schedule::{for_each, thread_count};
use crate::shading::encode;
use crate::{Frame, FrameStats, Pass, Passes, Prepared, Renderer, Settings};

/// Place `i` of `n` within a pixel, both coordinates in (0, 1); the middle for `n` = 1.
pub fn sample_place(i: u32, n: u32) -> [f64; 2] {
    let half_cell = 0.5 / f64::from(n);
    let mirrored = f64::from(i.reverse_bits()) / (1_u64 << 32) as f64;
    [f64::from(i) / f64::from(n) + half_cell, mirrored + half_cell.min(0.5 * (1.0 - mirrored))]
}

/// A sum of pictures of one size.
#[derive(Clone, Debug, Default)]
pub struct Accumulation {
    /// RGB times alpha, and alpha.
    sums: Vec<DVec4>,
    n: u32,
}

impl Accumulation {
    /// Forgets all pictures; the next one decides the size.
    pub fn clear(&mut self) {
        self.sums.clear();
        self.n = 0;
    }

    /// Pictures so far.
    pub fn n_pictures(&self) -> u32 {
        self.n
    }

    /// Adds a picture: linear RGB and straight alpha, as many pixels as before.
    pub fn add(&mut self, linear: &[Vec4], threads: usize) {
        if self.n == 0 {
            self.sums.resize(linear.len(), DVec4::ZERO);
        }
        debug_assert_eq!(self.sums.len(), linear.len(), "pictures of one size");
        self.n += 1;
        let bands = self.sums.chunks_mut(BAND).zip(linear.chunks(BAND));
        for_each(threads, bands, |(sums, colors)| {
            for (sum, color) in sums.iter_mut().zip(colors) {
                let color = color.as_dvec4();
                *sum += (color.truncate() * color.w).extend(color.w);
            }
        });
    }

    /// The mean so far at pixel `i`: linear RGB and straight alpha.
    pub fn mean(&self, i: usize) -> Vec4 {
        let sum = self.sums[i];
        let rgb = if sum.w > 0.0 { sum.truncate() / sum.w } else { DVec3::ZERO };
        rgb.extend(sum.w / f64::from(self.n.max(1))).as_vec4()
    }

    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        self.sums.capacity() * size_of::<DVec4>()
    }
}

/// Pixels per job.
const BAND: usize = 1 << 14;

/// Memory for pictures that become part of others.
#[derive(Debug, Default)]
pub(crate) struct AccumulateScratch {
    frame: Frame,
    sum: Accumulation,
}

impl AccumulateScratch {
    /// Memory held.
    pub fn bytes(&self) -> usize {
        self.sum.bytes() + self.frame.linear.capacity() * size_of::<Vec4>()
    }
}

impl Renderer {
    /// Draws the colours of a frame [`Settings::accumulate`] times, and its data once. Counters are
    /// those of one picture, times those of all.
    pub(crate) fn accumulate(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        frame: &mut Frame,
    ) -> FrameStats {
        let start = Instant::now();
        let threads = thread_count(settings.threads);
        let mut scratch = std::mem::take(&mut self.accumulation);
        scratch.sum.clear();
        let one = Settings { accumulate: 1, ..*settings };
        // Takes the frame's size, and fills its data.
        let data = Settings { passes: settings.passes.data(), ..one };
        let mut stats = self.render(prepared, view, &data, frame);

        let n = settings.accumulate;
        let filter = match settings.filter {
            Filter::Trilinear => Filter::Oversampled(n.ilog2() as u8),
            other => other,
        };
        let colors = Settings { passes: Passes::NONE.with(Pass::Linear), filter, ..one };
        for i in 0..n {
            let [x, y] = sample_place(i, n);
            let shifted = view.shifted(x - 0.5, y - 0.5);
            let of_one = self.render(prepared, &shifted, &colors, &mut scratch.frame);
            scratch.sum.add(&scratch.frame.linear, threads);
            let stages = stats.stages.plus(&of_one.stages);
            stats = if i == 0 { of_one } else { stats };
            stats.stages = stages;
        }

        let resolve = Instant::now();
        let (linear, rgba8) = (&mut frame.linear, &mut frame.rgba8);
        let n_pixels = frame.width as usize * frame.height as usize;
        if settings.passes.contains(Pass::Linear) {
            linear.clear();
            linear.extend((0..n_pixels).map(|i| scratch.sum.mean(i)));
        }
        if settings.passes.contains(Pass::Color) {
            rgba8.clear();
            rgba8.resize(n_pixels, [0; 4]);
            let jobs = rgba8.chunks_mut(BAND).enumerate();
            for_each(threads, jobs, |(band, codes)| {
                for (i, code) in codes.iter_mut().enumerate() {
                    *code = encode(settings.encoding, scratch.sum.mean(band * BAND + i));
                }
            });
        }
        self.accumulation = scratch;
        stats.stages.resolve += resolve.elapsed();
        stats.scratch_bytes = self.scratch_bytes();
        stats.total = start.elapsed();
        stats
    }
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;
    use cullet_transform::Viewport;

    use super::*;
    use crate::{Antialias, Region, frame_scene};

    fn draw(settings: &Settings, scene: &str) -> Frame {
        let prepared = Prepared::new(synth(scene).unwrap()).unwrap();
        let viewport = Viewport::new(48, 32).unwrap();
        let view = View::new(&frame_scene(&prepared, 1.5), viewport);
        let mut frame = Frame::default();
        Renderer::default().render(&prepared, &view, settings, &mut frame);
        frame
    }

    #[test]
    fn places_are_one_per_row_and_column() {
        assert_eq!(sample_place(0, 1), [0.5, 0.5]);
        for n in [2, 4, 16, 256] {
            let mut seen = vec![[false; 2]; n as usize];
            for i in 0..n {
                let place = sample_place(i, n);
                for axis in 0..2 {
                    let cell = &mut seen[(place[axis] * f64::from(n)) as usize][axis];
                    assert!(!std::mem::replace(cell, true));
                }
            }
        }
        for n in [3, 7, 100] {
            assert!((0..n).flat_map(|i| sample_place(i, n)).all(|x| 0.0 < x && x < 1.0));
        }
    }

    #[test]
    fn edges_are_the_mean_of_samples_and_flats_stay() {
        let passes = Passes::COLOR.with(Pass::Linear).with(Pass::Id);
        let plain = Settings { antialias: Antialias::None, passes, ..Settings::default() };
        let unlit = Settings { shading: crate::Shading::Unlit, ..plain };
        let one = draw(&unlit, "box-grid:1");
        let many = draw(&Settings { accumulate: 16, ..unlit }, "box-grid:1");
        assert_eq!(one.id, many.id);
        let background = unlit.background;
        let colors: Vec<Vec4> = one.linear.iter().copied().filter(|c| *c != background).collect();
        let mut n_edge = 0;
        for (a, b) in one.linear.iter().zip(&many.linear) {
            // Between the background and the box, in sixteenths.
            let share = (b.x - background.x) / (colors[0].x - background.x) * 16.0;
            assert!((share - share.round()).abs() < 1e-4, "{share}");
            n_edge += usize::from(a != b);
        }
        assert!(n_edge > 10);
        assert_ne!(one.rgba8, many.rgba8);
    }

    #[test]
    fn more_samples_come_closer_to_many() {
        let settings = Settings {
            antialias: Antialias::None,
            passes: Passes::NONE.with(Pass::Linear),
            ..Settings::default()
        };
        let of = |accumulate| draw(&Settings { accumulate, ..settings }, "knots").linear;
        let truth = of(256);
        let error = |n| {
            let picture = of(n);
            let squares = truth.iter().zip(&picture).map(|(a, b)| (a - b).length_squared());
            squares.sum::<f32>()
        };
        let errors = [1, 4, 16, 64].map(error);
        assert!(errors.is_sorted_by(|a, b| *a > 2.0 * b), "{errors:?}");
    }

    #[test]
    fn regions_and_threads_do_not_show() {
        let whole = Settings { accumulate: 5, background: Vec4::ZERO, ..Settings::default() };
        let region = Region { x: 13, y: 6, width: 21, height: 17 };
        let part = Settings { region: Some(region), threads: 3, ..whole };
        let (whole, part) = (draw(&whole, "masks"), draw(&part, "masks"));
        for y in 0..region.height as usize {
            let from = (y + region.y as usize) * 48 + region.x as usize;
            let (a, b) = (&whole.rgba8[from..from + 21], &part.rgba8[y * 21..(y + 1) * 21]);
            assert_eq!(a, b, "row {y}");
        }
    }
}
