//! One frame: cull, set up, cover, shade.

use std::time::Instant;

use cullet_raster::{BLOCK, NO_TRIANGLE, Samples, TileBuffer};
use cullet_transform::{PlaneMask, View};

use crate::bins::{Bins, Grid};
use crate::culling::cull;
use crate::raycast::Raycaster;
use crate::schedule::{for_each_with, thread_count};
use crate::shading::{Scene, Shaded, encode_linear, fill_background, shade_bands, shade_run};
use crate::tile_shader::{ShadeScratch, TileShader};
use crate::tiles::{TileDrawer, TileScratch};
use crate::visible_clusters::VisibleClusters;
use crate::{Frame, FrameStats, Prepared, Region, RendererKind, Settings};

/// Scratch memory; it carries nothing from one frame to the next.
#[derive(Debug, Default)]
pub struct Renderer {
    ids: Vec<u32>,
    /// Per item: the planes that cut it, or `None` when it was thrown out.
    planes: Vec<Option<PlaneMask>>,
    clusters: VisibleClusters,
    bins: Bins,
    /// By thread.
    tiles: Vec<TileScratch>,
    shading: Vec<ShadeScratch>,
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
        let start = Instant::now();
        let threads = thread_count(settings.threads);
        let region = visible_region(view, settings);
        let mut stats = FrameStats::default();
        cull(prepared, view, settings, &mut self.planes, &mut stats);
        stats.stages.cull = start.elapsed();
        frame.reset(region.width, region.height, settings.passes);

        let shaded = match settings.renderer {
            RendererKind::Raster => {
                self.raster(prepared, view, settings, threads, region, &mut stats);
                if self.shading.len() < threads {
                    self.shading.resize_with(threads, ShadeScratch::default);
                }
                let scene = Scene { prepared, view, settings, planes: &self.planes };
                let (ids, stride) = (&self.ids, region.width as usize);
                let scratch = &mut self.shading[..threads];
                scratch.iter_mut().for_each(ShadeScratch::begin);
                shade_bands(scratch, region, frame, BLOCK, |scratch, rect, out| {
                    let ids = &ids[(rect.y - region.y) as usize * stride..];
                    TileShader::new(scene, scratch).tile(rect, ids, stride, out)
                })
            }
            RendererKind::Raycast { snapped } => {
                let start = Instant::now();
                let scene = Scene { prepared, view, settings, planes: &self.planes };
                let caster = Raycaster::new(prepared, view, settings, &self.planes, snapped);
                stats.stages.geometry = start.elapsed();
                let mut threads = vec![(); threads];
                shade_bands(&mut threads, region, frame, CAST_ROWS, |(), rect, out| {
                    let mut n_pixels = 0;
                    fill_background(settings, rect, out);
                    caster.scan(rect, &mut |run, triangle| {
                        n_pixels += run.len as u64;
                        let (row, column) = ((run.y - rect.y) as usize, (run.x - rect.x) as usize);
                        let start = row * out.stride + column;
                        shade_run(&scene, out, start, triangle, &run, true);
                    });
                    encode_linear(rect, out);
                    n_pixels
                })
            }
        };
        let Shaded { n_pixels, shade } = shaded;
        (stats.pixels_shaded, stats.stages.shade) = (n_pixels, shade);
        stats.scratch_bytes = self.scratch_bytes();
        stats.total = start.elapsed();
        stats
    }

    /// Fills the id and depth buffers of `region`.
    fn raster(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        threads: usize,
        region: Region,
        stats: &mut FrameStats,
    ) {
        let n_pixels = region.width as usize * region.height as usize;
        self.ids.clear();
        self.ids.resize(n_pixels, NO_TRIANGLE);
        let start = Instant::now();
        let samples = Samples::One;
        let side = settings.tile_px.clamp(8, 256).next_multiple_of(8);
        self.clusters.find(prepared, view, settings, samples, &self.planes, threads);
        let grid = Grid::new(region, side);
        let rectangles = self.clusters.sorted().map(|cluster| (cluster.shown.x, cluster.shown.y));
        self.bins.fill(&grid, rectangles);
        let middle = Instant::now();
        stats.stages.geometry = middle - start;

        if self.tiles.len() < threads {
            self.tiles.resize_with(threads, TileScratch::default);
        }
        let tiles = &mut self.tiles[..threads];
        for tile in &mut *tiles {
            (tile.counters, tile.n_samples_written) = Default::default();
        }
        let drawer = TileDrawer {
            prepared,
            view,
            settings,
            planes: &self.planes,
            grid,
            bins: &self.bins,
            clusters: &self.clusters,
            samples,
        };
        let rows = TileRows::new(&grid, region, &mut self.ids);
        for_each_with(tiles, rows, |scratch, mut row| {
            for column in 0..grid.size[0] {
                drawer.tile(scratch, [column, row.number]);
                row.take(&grid, region, column, &scratch.buffer);
            }
        });
        self.clusters.count(prepared);
        stats.clusters = self.clusters.counters;
        stats.n_triangles_of_culled_clusters = self.clusters.n_triangles_culled;
        let drawn = prepared.items().iter().zip(&self.planes).enumerate();
        for (i, (item, _)) in drawn.filter(|(_, (_, planes))| planes.is_some()) {
            let n = prepared.clusters(i).n_not_finite;
            stats.triangles.n_in += n;
            stats.triangles.n_not_finite += n;
            debug_assert!(n <= u64::from(item.n_triangles));
        }
        for tile in &self.tiles[..threads] {
            stats.triangles += tile.counters;
            stats.samples_written += tile.n_samples_written;
        }
        stats.stages.raster = middle.elapsed();
    }

    fn scratch_bytes(&self) -> u64 {
        let tiles: usize = self.tiles.iter().map(TileScratch::bytes).sum();
        let lists = self.clusters.bytes() + self.bins.bytes();
        let shading: usize = self.shading.iter().map(ShadeScratch::bytes).sum();
        let pixels = size_of_val(&self.ids[..]) + size_of_val(&self.planes[..]);
        (pixels + lists + tiles + shading) as u64
    }
}

/// The rows of tiles of a grid, each with its part of a picture.
struct TileRows<'a> {
    ids: &'a mut [u32],
    region: Region,
    side: u32,
    first_row: u32,
    next: u32,
    end: u32,
}

/// One of them.
struct TileRow<'a> {
    /// In the grid.
    number: u32,
    /// First row of pixels in the picture.
    y: u32,
    ids: &'a mut [u32],
}

impl<'a> TileRows<'a> {
    fn new(grid: &Grid, region: Region, ids: &'a mut [u32]) -> Self {
        TileRows {
            ids,
            region,
            side: grid.side,
            first_row: grid.first[1],
            next: 0,
            end: grid.size[1],
        }
    }
}

impl<'a> Iterator for TileRows<'a> {
    type Item = TileRow<'a>;

    fn next(&mut self) -> Option<TileRow<'a>> {
        if self.next == self.end {
            return None;
        }
        let number = self.next;
        self.next += 1;
        let top = (self.first_row + number) * self.side;
        let y = top.max(self.region.y);
        let bottom = (top + self.side).min(self.region.y + self.region.height);
        let n = (bottom - y) as usize * self.region.width as usize;
        let (ids, rest) = std::mem::take(&mut self.ids).split_at_mut(n);
        self.ids = rest;
        Some(TileRow { number, y, ids })
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let n = (self.end - self.next) as usize;
        (n, Some(n))
    }
}

impl ExactSizeIterator for TileRows<'_> {}

impl TileRow<'_> {
    /// Copies the part of a tile that lies in the region.
    fn take(&mut self, grid: &Grid, region: Region, column: u32, tile: &TileBuffer) {
        let left = (grid.first[0] + column) * grid.side;
        let x = left.max(region.x);
        let right = (left + grid.side).min(region.x + region.width);
        let top = (grid.first[1] + self.number) * grid.side;
        let width = region.width as usize;
        for (i, row) in self.ids.chunks_mut(width).enumerate() {
            let from = tile.ids(0, (self.y - top) as usize + i);
            row[(x - region.x) as usize..(right - region.x) as usize]
                .copy_from_slice(&from[(x - left) as usize..(right - left) as usize]);
        }
    }
}

/// The part of the picture to draw, cut to the picture.
fn visible_region(view: &View, settings: &Settings) -> Region {
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
    use crate::{CullTest, Item, Pass, Passes, frame_direction};

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
