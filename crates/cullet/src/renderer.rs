//! One frame: cull, set up, cover, shade.

use std::time::Instant;

use cullet_raster::{DepthFormat, NO_TRIANGLE, Tile};
use cullet_transform::{PlaneMask, View};

use crate::chunks::{Chunk, Depth, fill_chunks, segments};
use crate::culling::cull;
use crate::raycast::Raycaster;
use crate::schedule::{for_each, thread_count};
use crate::shading::{Shaded, shade};
use crate::visibility::VisibilityBuffer;
use crate::{Frame, FrameStats, Prepared, Region, RendererKind, Settings};

/// Scratch memory; it carries nothing from one frame to the next.
#[derive(Debug, Default)]
pub struct Renderer {
    ids: Vec<u32>,
    depth: Vec<<Depth as DepthFormat>::Code>,
    /// Per item: the planes that cut it, or `None` when it was thrown out.
    planes: Vec<Option<PlaneMask>>,
    chunks: Vec<Chunk>,
}

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
                let visible = VisibilityBuffer {
                    prepared,
                    view,
                    planes: &self.planes,
                    region,
                    ids: &self.ids,
                };
                shade(&visible, view, settings, threads, region, frame)
            }
            RendererKind::Raycast { snapped } => {
                let start = Instant::now();
                let caster = Raycaster::new(prepared, view, settings, &self.planes, snapped);
                stats.stages.geometry = start.elapsed();
                shade(&caster, view, settings, threads, region, frame)
            }
        };
        let Shaded { n_pixels, shade, resolve } = shaded;
        (stats.pixels_shaded, stats.stages.shade, stats.stages.resolve) =
            (n_pixels, shade, resolve);
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
        self.depth.clear();
        self.depth.resize(n_pixels, Depth::FARTHEST);

        let drawn = self.planes.iter().enumerate().filter(|(_, planes)| planes.is_some());
        let mut pending = drawn.flat_map(|(i, _)| segments(i, &prepared.items()[i])).peekable();
        while pending.peek().is_some() {
            let start = Instant::now();
            let n_chunks = fill_chunks(&mut self.chunks, &mut pending);
            let chunks = &mut self.chunks[..n_chunks];
            let planes = &self.planes;
            for_each(threads, chunks.iter_mut(), |chunk| chunk.set_up(prepared, view, planes));
            let middle = Instant::now();
            stats.stages.geometry += middle - start;

            // Every band looks at every triangle: no more bands than keep the cores busy.
            let n_bands = if threads == 1 { 1 } else { 4 * threads };
            let rows = (region.height as usize).div_ceil(n_bands).max(8);
            let stride = rows * region.width as usize;
            let (ids, depth) = (self.ids.chunks_mut(stride), self.depth.chunks_mut(stride));
            let bands: Vec<_> = ids.zip(depth).enumerate().collect();
            let written = std::sync::atomic::AtomicU64::new(0);
            for_each(threads, bands.into_iter(), |(i, (ids, depth))| {
                let y = region.y + (i * rows) as u32;
                let mut tile = Tile::<Depth> { x: region.x, y, width: region.width, ids, depth };
                let mut n = 0;
                for chunk in &*chunks {
                    n += chunk.cover(prepared, view, settings, planes, &mut tile);
                }
                written.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
            });
            stats.samples_written += written.into_inner();
            for chunk in &*chunks {
                stats.triangles += chunk.counters;
            }
            stats.stages.raster += middle.elapsed();
        }
    }

    fn scratch_bytes(&self) -> u64 {
        let chunks: usize = self.chunks.iter().map(Chunk::bytes).sum();
        let pixels = size_of_val(&self.ids[..]) + size_of_val(&self.depth[..]);
        (pixels + size_of_val(&self.planes[..]) + chunks) as u64
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
