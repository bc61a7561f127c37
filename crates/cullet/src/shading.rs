//! From visible triangles to pixels: the second half of a frame.
//!
//! The rasterizer and the ray caster both end here, so they differ in what they find visible
//! and nowhere else.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use cullet_raster::{Fragment, Pixels};
use cullet_scene::AlphaMode;
use cullet_shade::{Look, Surface, Triangle, alpha, base_color, srgb, uv};
use cullet_shade::{world_normal, world_position};
use glam::{DMat4, DVec3, Vec4};

use crate::frame::Band;
use crate::schedule::for_each;
use crate::{Frame, Item, Pass, Prepared, Region, Settings, View};

/// Rows per job: small enough to keep every core busy, large enough not to be noticed.
const BAND_ROWS: usize = 16;

/// The triangle that some pixels of a row show.
pub(crate) struct VisibleTriangle<'a> {
    pub item: &'a Item,
    pub item_idx: usize,
    pub id: u32,
    pub surface: Surface<'a>,
    pub corners: [u32; 3],
    pub front: bool,
}

impl<'a> VisibleTriangle<'a> {
    /// Triangle `id` of the whole scene, one of the item's, seen from its front or not.
    pub(crate) fn new(prepared: &'a Prepared, item_idx: usize, id: u32, front: bool) -> Self {
        let item = &prepared.items()[item_idx];
        let surface = prepared.surface(item);
        let corners = surface.mesh.triangles[(id - item.first_triangle) as usize];
        VisibleTriangle { item, item_idx, id, surface, corners, front }
    }

    /// Whether the material has matter at a fragment: always, unless it is alpha-masked.
    pub(crate) fn keeps(&self, fragment: &Fragment, settings: &Settings) -> bool {
        match self.surface.material.alpha {
            AlphaMode::Mask { cutoff } => {
                alpha(&self.surface, self.corners, fragment, settings.filter) >= cutoff
            }
            AlphaMode::Opaque | AlphaMode::Blend => true,
        }
    }

    /// Model-space corners.
    pub(crate) fn positions(&self) -> [DVec3; 3] {
        self.corners.map(|i| self.surface.mesh.positions[i as usize].as_dvec3())
    }
}

/// A run of pixels of one row that show one triangle.
#[derive(Clone, Copy)]
pub(crate) struct Run<'r> {
    /// Column of the first.
    pub x: u32,
    /// Row of all.
    pub y: u32,
    /// How many.
    pub len: usize,
    /// Where they lie on the triangle.
    pub pixels: Pixels<'r>,
}

/// Takes a run and the triangle it shows.
pub(crate) type Emit<'e, 'a> = dyn FnMut(Run<'_>, &VisibleTriangle<'a>) + 'e;

/// Something that knows what pixels show. Coordinates are those of the whole picture; pixels never
/// emitted show the background.
pub(crate) trait Visible: Sync {
    /// Finds what the pixels of `region` show, row by row.
    fn scan<'a>(&'a self, region: Region, emit: &mut Emit<'_, 'a>);
}

/// What shading did.
pub(crate) struct Shaded {
    pub n_pixels: u64,
    pub shade: Duration,
    pub resolve: Duration,
}

/// Fills every pass of `frame` from what `visible` finds.
pub(crate) fn shade(
    visible: &impl Visible,
    view: &View,
    settings: &Settings,
    threads: usize,
    region: Region,
    frame: &mut Frame,
) -> Shaded {
    let start = Instant::now();
    let (n_pixels, shade_ns, resolve_ns) =
        (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
    let shader = Shader { view, settings };
    for_each(threads, frame.bands(BAND_ROWS).into_iter(), |mut band| {
        let start = Instant::now();
        let mut colors = Colors::new(settings, &mut band);
        let filled = Instant::now();
        n_pixels.fetch_add(
            shader.shade_band(visible, region, &mut band, &mut colors),
            Ordering::Relaxed,
        );
        let middle = Instant::now();
        resolve(&mut band);
        let resolve = (filled - start) + middle.elapsed();
        shade_ns.fetch_add((middle - filled).as_nanos() as u64, Ordering::Relaxed);
        resolve_ns.fetch_add(resolve.as_nanos() as u64, Ordering::Relaxed);
    });
    // Threads share the wall time in the proportion of their work.
    let (shade_ns, resolve_ns) = (shade_ns.into_inner() as f64, resolve_ns.into_inner() as f64);
    let wall = start.elapsed();
    let resolve = wall.mul_f64(resolve_ns / (shade_ns + resolve_ns).max(1.0));
    Shaded { n_pixels: n_pixels.into_inner(), shade: wall - resolve, resolve }
}

struct Shader<'a> {
    view: &'a View,
    settings: &'a Settings,
}

impl Shader<'_> {
    fn shade_band(
        &self,
        visible: &impl Visible,
        region: Region,
        band: &mut Band<'_>,
        colors: &mut Colors,
    ) -> u64 {
        let mut n_pixels = 0;
        let (y, height) = (region.y + band.first_row as u32, band.rows as u32);
        visible.scan(Region { y, height, ..region }, &mut |run, triangle| {
            n_pixels += run.len as u64;
            let row = (run.y - region.y) as usize - band.first_row;
            let start = row * band.width + (run.x - region.x) as usize;
            self.shade_run(band, colors, start, triangle, run);
        });
        n_pixels
    }

    fn shade_run(
        &self,
        band: &mut Band<'_>,
        colors: &mut Colors,
        start: usize,
        triangle: &VisibleTriangle<'_>,
        run: Run<'_>,
    ) {
        let range = start..start + run.len;
        let VisibleTriangle { item, surface, corners, front, .. } = *triangle;
        let (settings, passes) = (self.settings, self.settings.passes);
        let filter = settings.filter;
        if passes.needs_color() {
            let kernel = item.kernel(settings.shading);
            let look = Look { light: settings.light, filter, simd: settings.simd };
            let seen = Triangle { surface, corners, front };
            if band.linear.is_empty() {
                let linear = colors.of(run.len);
                kernel(&seen, &look, run.pixels, linear);
                for (out, color) in band.rgba8[range.clone()].iter_mut().zip(linear) {
                    *out = encode(*color);
                }
            } else {
                kernel(&seen, &look, run.pixels, &mut band.linear[range.clone()]);
            }
        }
        if passes.contains(Pass::Depth) {
            let distances = self.distances(triangle);
            fill(band.depth, &range, run.pixels, |f| f.weights.dot(distances) as f32);
        }
        if passes.contains(Pass::Normal) {
            fill(band.normal, &range, run.pixels, |f| world_normal(&surface, corners, front, f));
        }
        if passes.contains(Pass::Albedo) {
            fill(band.albedo, &range, run.pixels, |f| base_color(&surface, corners, f, filter));
        }
        if passes.contains(Pass::Uv) {
            fill(band.uv, &range, run.pixels, |f| uv(&surface, corners, f));
        }
        if passes.contains(Pass::Position) {
            fill(band.position, &range, run.pixels, |f| world_position(&surface, corners, f));
        }
        if passes.contains(Pass::Id) {
            fill(band.id, &range, run.pixels, |_| triangle.item_idx as u32 + 1);
        }
        if passes.contains(Pass::Triangle) {
            fill(band.triangle, &range, run.pixels, |_| triangle.id + 1);
        }
    }

    /// Distance of the corners along the view axis, scene units.
    fn distances(&self, triangle: &VisibleTriangle<'_>) -> DVec3 {
        let view_from_model = self.view.view_from_model(&triangle.item.world_from_model);
        let row = DMat4::from(view_from_model).row(2);
        DVec3::from_array(triangle.positions().map(|p| -row.dot(p.extend(1.0))))
    }
}

fn fill<T>(
    pass: &mut [T],
    range: &std::ops::Range<usize>,
    pixels: Pixels<'_>,
    mut value: impl FnMut(&Fragment) -> T,
) {
    for (i, out) in pass[range.clone()].iter_mut().enumerate() {
        *out = value(&pixels.at(i));
    }
}

/// The linear colours of a run, on their way to bytes while they are still in the nearest cache.
/// A picture of them is kept only where one is asked for.
struct Colors {
    linear: Vec<Vec4>,
}

impl Colors {
    /// Fills the band with background, encoded once.
    fn new(settings: &Settings, band: &mut Band<'_>) -> Self {
        band.linear.fill(settings.background);
        if band.linear.is_empty() {
            band.rgba8.fill(encode(settings.background));
        }
        Colors { linear: Vec::new() }
    }

    fn of(&mut self, len: usize) -> &mut [Vec4] {
        if self.linear.len() < len {
            self.linear.resize(len, Vec4::ZERO);
        }
        &mut self.linear[..len]
    }
}

/// Encodes the linear picture, where there is one.
fn resolve(band: &mut Band<'_>) {
    for (out, color) in band.rgba8.iter_mut().zip(&*band.linear) {
        *out = encode(*color);
    }
}

/// Linear RGBA to 8-bit sRGB with linear alpha.
fn encode(color: Vec4) -> [u8; 4] {
    // Most pixels are opaque, and rounding is a call where there is no instruction for it.
    let opaque = color.w == 1.0;
    let alpha = if opaque { 255 } else { (color.w * 255.0).round_ties_even() as u8 }; // NaN is 0
    [srgb::encode8(color.x), srgb::encode8(color.y), srgb::encode8(color.z), alpha]
}
