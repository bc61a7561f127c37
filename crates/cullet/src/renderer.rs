//! One frame: cull, sort and deal out clusters, then tile after tile: cover, shade.

use std::cmp::Reverse;
use std::time::{Duration, Instant};

use cullet_raster::Samples;
use cullet_transform::{PlaneMask, View};

use crate::accumulate::AccumulateScratch;
use crate::bins::{Bins, Grid};
use crate::culling::cull;
use crate::frame::Band;
use crate::raycast::Raycaster;
use crate::resolution::{HalfScratch, is_whole_cells};
use crate::schedule::{for_each_with, thread_count};
use crate::shading::{Scene, Shaded, encode_linear, fill_background, shade_bands, shade_run};
use crate::supersample::{Supersampling, fine};
use crate::tile_shader::TileShader;
use crate::tiles::{TileDrawer, TileScratch};
use crate::visible_clusters::VisibleClusters;
use crate::{
    Antialias, Frame, FrameStats, Passes, Prepared, Region, RendererKind, Resolution, Settings,
};

/// Scratch memory; it carries nothing from one frame to the next.
#[derive(Debug, Default)]
pub struct Renderer {
    /// Per item: the planes that cut it, or `None` when it was thrown out.
    planes: Vec<Option<PlaneMask>>,
    clusters: VisibleClusters,
    bins: Bins,
    /// By thread.
    threads: Vec<TileScratch>,
    pub(crate) accumulation: AccumulateScratch,
    pub(crate) half: HalfScratch,
}

/// What to draw, from where, how, and with how many pixels for each one of the frame along a side.
#[derive(Clone, Copy)]
struct Drawn<'a> {
    prepared: &'a Prepared,
    view: &'a View,
    settings: &'a Settings,
    per_side: u32,
}

/// Rows per job of the ray caster.
const CAST_ROWS: u32 = 16;

impl Renderer {
    /// Draws `prepared` as `view` sees it into `frame`. Cannot fail.
    pub fn render(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        frame: &mut Frame,
    ) -> FrameStats {
        if settings.passes.needs_color() {
            if settings.accumulate > 1 {
                return self.accumulate(prepared, view, settings, frame);
            }
            let is_raster = settings.renderer == RendererKind::Raster;
            match settings.resolution {
                Resolution::Half if is_raster => {
                    return self.halved(prepared, view, settings, frame);
                }
                Resolution::Adaptive if is_raster && !is_whole_cells(view, settings) => {
                    return self.in_whole_cells(prepared, view, settings, frame);
                }
                _ => {}
            }
        }
        let start = Instant::now();
        let threads = thread_count(settings.threads);
        let region = visible_region(view, settings);
        let mut stats = FrameStats::default();
        cull(prepared, view, settings, &mut self.planes, &mut stats);
        stats.stages.cull = start.elapsed();
        frame.reset(region.width, region.height, settings.passes);
        match settings.renderer {
            RendererKind::Raster => match Supersampling::new(view, settings.antialias) {
                None => {
                    let scene = Drawn { prepared, view, settings, per_side: 1 };
                    self.raster(scene, threads, region, frame, &mut stats);
                }
                Some(fine) => {
                    let (passes, after_cull) = (settings.passes, stats);
                    let antialias = Antialias::None;
                    let colors = Settings { passes: passes.colors(), antialias, ..*settings };
                    let data = Settings { passes: passes.data(), antialias, ..*settings };
                    if data.passes != Passes::NONE || !passes.needs_color() {
                        let scene = Drawn { prepared, view, settings: &data, per_side: 1 };
                        self.raster(scene, threads, region, frame, &mut stats);
                    }
                    if passes.needs_color() {
                        // Of both pictures the times, of the finer one the counters.
                        stats = FrameStats { stages: stats.stages, ..after_cull };
                        let Supersampling { per_side, view } = &fine;
                        let scene =
                            Drawn { prepared, view, settings: &colors, per_side: *per_side };
                        self.raster(scene, threads, region, frame, &mut stats);
                    }
                }
            },
            RendererKind::Raycast { snapped } => {
                let start = Instant::now();
                let scene = Scene { prepared, view, settings, planes: &self.planes };
                let caster = Raycaster::new(prepared, view, settings, &self.planes, snapped);
                stats.stages.geometry = start.elapsed();
                let shaded = shade_bands(threads, region, frame, CAST_ROWS, |rect, out| {
                    let mut n_pixels = 0;
                    fill_background(settings, rect, out);
                    out.clear_data([rect.width, rect.height], settings.passes);
                    caster.scan(rect, &mut |run, triangle| {
                        n_pixels += run.len as u64;
                        let (row, column) = ((run.y - rect.y) as usize, (run.x - rect.x) as usize);
                        let start = row * out.stride + column;
                        shade_run(&scene, out, start, triangle, &run);
                    });
                    encode_linear(settings, rect, out);
                    n_pixels
                });
                let Shaded { n_pixels, shade } = shaded;
                (stats.pixels_shaded, stats.stages.shade) = (n_pixels, shade);
            }
        }
        stats.scratch_bytes = self.scratch_bytes();
        stats.total = start.elapsed();
        stats
    }

    /// Draws a part of the picture into `frame`, tile by tile.
    fn raster(
        &mut self,
        Drawn { prepared, view, settings, per_side }: Drawn<'_>,
        threads: usize,
        region: Region,
        frame: &mut Frame,
        stats: &mut FrameStats,
    ) {
        let start = Instant::now();
        let region = fine(region, per_side);
        let samples = match settings.antialias {
            Antialias::None | Antialias::Ssaa4 | Antialias::Ssaa16 => Samples::One,
            Antialias::Msaa2 => Samples::Two,
            Antialias::Msaa4 => Samples::Four,
            Antialias::Msaa8 => Samples::Eight,
        };
        let side = settings.tile_px.clamp(8, 256).next_multiple_of(8);
        self.clusters.find(prepared, view, settings, samples, &self.planes, threads);
        let grid = Grid::new(region, side);
        let rectangles =
            self.clusters.sorted.iter().map(|cluster| (cluster.shown.x, cluster.shown.y));
        self.bins.fill(&grid, rectangles);
        let middle = Instant::now();
        stats.stages.geometry += middle - start;

        if self.threads.len() < threads {
            self.threads.resize_with(threads, TileScratch::default);
        }
        let scratches = &mut self.threads[..threads];
        for scratch in &mut *scratches {
            scratch.begin(self.clusters.sorted.len());
        }
        let drawer = TileDrawer {
            scene: Scene { prepared, view, settings, planes: &self.planes },
            grid,
            bins: &self.bins,
            clusters: &self.clusters,
            samples,
            per_side,
        };
        let first_rows = (side - region.y % side) / per_side;
        let bands = frame.bands(first_rows, side / per_side);
        let draw = |scratch: &mut TileScratch, (row, band): (usize, Band<'_>)| {
            row_of_tiles(&drawer, region, scratch, row as u32, band);
        };
        if threads == 1 {
            // No list is made: a frame allocates nothing.
            for_each_with(scratches, bands.enumerate(), draw);
        } else {
            // The most to draw first, lest one thread begins it when the others are done.
            let mut bands: Vec<_> = bands.enumerate().collect();
            let columns = grid.size[0] as usize;
            bands.sort_by_key(|(row, _)| {
                Reverse(self.bins.count(row * columns..(row + 1) * columns))
            });
            for_each_with(scratches, bands.into_iter(), draw);
        }
        self.clusters.count(prepared);
        stats.clusters = self.clusters.counters;
        stats.n_triangles_of_culled_clusters = self.clusters.n_triangles_culled;
        let drawn = self.planes.iter().enumerate().filter(|(_, planes)| planes.is_some());
        for (i, _) in drawn {
            let n = prepared.clusters(i).n_not_finite;
            stats.triangles.n_in += n;
            stats.triangles.n_not_finite += n;
        }
        let (mut raster, mut shade) = (Duration::ZERO, Duration::ZERO);
        for TileScratch { done, .. } in &self.threads[..threads] {
            stats.triangles += done.triangles;
            stats.samples_written += done.n_samples_written;
            stats.pixels_shaded += done.n_pixels;
            (raster, shade) = (raster + done.raster, shade + done.shade);
        }
        // Threads share the wall time in the proportion of their work.
        let wall = middle.elapsed();
        let share = raster.as_secs_f64() / (raster + shade).as_secs_f64().max(1e-9);
        let raster = wall.mul_f64(share);
        stats.stages.raster += raster;
        stats.stages.shade += wall - raster;
    }

    pub(crate) fn scratch_bytes(&self) -> u64 {
        let threads: usize = self.threads.iter().map(TileScratch::bytes).sum();
        let lists = self.clusters.bytes() + self.bins.bytes();
        let pictures = self.accumulation.bytes() + self.half.bytes();
        (size_of_val(&self.planes[..]) + lists + threads + pictures) as u64
    }
}

/// Draws and shades the tiles of a row.
fn row_of_tiles(
    drawer: &TileDrawer<'_>,
    region: Region,
    scratch: &mut TileScratch,
    row: u32,
    mut band: Band<'_>,
) {
    let Grid { side, first, size } = drawer.grid;
    let TileScratch { raster, shade, fine, done } = scratch;
    let n = drawer.per_side;
    let y = region.y + n * band.first_row as u32;
    let mut shader = TileShader::new(drawer.scene, shade);
    let mut column = 0;
    while column < size[0] {
        // Where nothing shows, rows of many tiles are emptied at once: memory is quicker along its lines.
        let n_empty = if n == 1 { drawer.n_empty([column, row]) } else { 0 };
        let (left, column_end) = ((first[0] + column) * side, column + n_empty.max(1));
        let x = left.max(region.x);
        let width = ((first[0] + column_end) * side).min(region.x + region.width) - x;
        let rect = Region { x, y, width, height: n * band.rows as u32 };
        let mut target = band.target.right_of(((x - region.x) / n) as usize);
        let place = [x - left, y - (first[1] + row) * side];
        let passes = drawer.scene.settings.passes;
        let parts = match drawer.samples {
            Samples::One => [Some((passes, Samples::One)), None],
            samples => {
                // Data takes one sample at the centre, whatever colours take.
                let (colors, data) = (passes.colors(), passes.data());
                let without_color = data != Passes::NONE || !passes.needs_color();
                [
                    passes.needs_color().then_some((colors, samples)),
                    without_color.then_some((data, Samples::One)),
                ]
            }
        };
        for (i, (passes, samples)) in parts.into_iter().flatten().enumerate() {
            let start = Instant::now();
            drawer.tile(raster, done, [column, row], samples);
            let drawn = Instant::now();
            let n_pixels = if n == 1 {
                shader.tile(rect, raster, place, passes, &mut target)
            } else {
                let n_pixels = shader.tile(rect, raster, place, passes, &mut fine.target(rect));
                fine.average(n, drawer.scene.settings.encoding, &mut target);
                n_pixels
            };
            done.n_pixels += if i == 0 { n_pixels } else { 0 };
            done.raster += drawn - start;
            done.shade += drawn.elapsed();
        }
        column = column_end;
    }
}

/// The part of the picture to draw, cut to the picture.
pub(crate) fn visible_region(view: &View, settings: &Settings) -> Region {
    let (width, height) = (view.viewport().width(), view.viewport().height());
    let all = Region { x: 0, y: 0, width, height };
    let Some(region) = settings.region else { return all };
    let (x, y) = (region.x.min(width - 1), region.y.min(height - 1));
    let (right, bottom) =
        (region.x.saturating_add(region.width), region.y.saturating_add(region.height));
    Region {
        x,
        y,
        width: right.min(width).saturating_sub(x).max(1),
        height: bottom.min(height).saturating_sub(y).max(1),
    }
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;
    use cullet_transform::{Camera, Projection, Viewport};
    use glam::DVec3;

    use super::*;
    use crate::culling::Culler;
    use crate::{CullTest, Item, Pass, frame_direction};

    #[test]
    fn another_view_takes_away_just_what_it_does_not_see() {
        let prepared = Prepared::new(synth("box-grid:6").unwrap()).unwrap();
        let viewport = Viewport::new(96, 64).unwrap();
        let around =
            View::new(&frame_direction(&prepared, 1.5, DVec3::new(1.0, 0.8, 0.6)), viewport);
        let lens = Projection::Perspective { yfov: 0.5, near: 0.01, far: f64::INFINITY };
        let middle = prepared.bounds().center();
        let inside = Camera::look_at(middle, middle + DVec3::X, DVec3::Y, lens).unwrap();
        let inside = View::new(&inside, viewport);
        let draw = |cull_view, cull| {
            let mut frame = Frame::default();
            let passes = Passes::COLOR.with(Pass::Id);
            let settings = Settings { cull, cull_view, passes, ..Settings::default() };
            let stats = Renderer::default().render(&prepared, &around, &settings, &mut frame);
            (frame.id, stats.objects.n_drawn)
        };

        let (ids, n_drawn) = draw(Some(inside), CullTest::PVertex);
        let kept = |item: &Item| {
            Culler::new(&inside, CullTest::PVertex)
                .planes(item, &mut FrameStats::default())
                .is_some()
        };
        let n_kept = prepared.items().iter().filter(|item| kept(item)).count();
        assert!(0 < n_kept && n_kept < prepared.items().len() / 2);
        assert_eq!(n_drawn, n_kept as u64);
        let mut seen: Vec<_> = ids.into_iter().filter(|&id| id != 0).collect();
        seen.dedup();
        assert!(!seen.is_empty());
        assert!(seen.iter().all(|&id| kept(&prepared.items()[id as usize - 1])));

        let everything = draw(None, CullTest::PVertex);
        assert_eq!(draw(Some(around), CullTest::PVertex), everything);
        assert_eq!(draw(Some(inside), CullTest::None).0, everything.0);
    }

    #[test]
    fn only_what_is_small_is_left_out_and_only_when_asked() {
        let prepared = Prepared::new(synth("box-grid:5").unwrap()).unwrap();
        let viewport = Viewport::new(96, 64).unwrap();
        let view = View::new(&frame_direction(&prepared, 1.5, DVec3::new(0.2, 0.2, 1.0)), viewport);
        let mut sizes: Vec<f64> = prepared
            .items()
            .iter()
            .map(|item| cullet_cull::projected_size_px(&view, &item.bounds))
            .collect();
        sizes.sort_by(f64::total_cmp);
        let median = sizes[sizes.len() / 2];
        let draw = |min_size_px| {
            let settings = Settings { min_size_px, ..Settings::default() };
            let stats =
                Renderer::default().render(&prepared, &view, &settings, &mut Frame::default());
            stats.objects
        };
        assert_eq!(draw(0.0).n_small, 0);
        let some = draw(median);
        assert_eq!(some.n_small, sizes.iter().filter(|size| **size < median).count() as u64);
        assert_eq!(some.n_in, some.n_small + some.n_outside + some.n_empty + some.n_drawn);
        assert_eq!(draw(1e9).n_drawn, 0);
    }
}
