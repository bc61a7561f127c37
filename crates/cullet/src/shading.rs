//! From visible triangles to pixels, one after the other: what passes other than colours take,
//! and all that the ray caster shows. [`crate::tile_shader`] colours what the rasterizer shows.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use cullet_cull::Aabb;
use cullet_raster::{Fragment, Interpolator, prefetch_all};
use cullet_scene::AlphaMode;
use cullet_shade::wide::encode_all;
use cullet_shade::{Encoding, Look, Needs, PointLight, Surface, Triangle, alpha, base_color, uv};
use cullet_shade::{world_normal, world_position};
use cullet_transform::PlaneMask;
use glam::{DMat4, DVec3, Vec4};

use crate::frame::{ROWS_AHEAD, Target};
use crate::schedule::for_each;
use crate::{CullTest, Frame, Item, Pass, Passes, Prepared, Region, Settings, View};

/// What is drawn, from where and how: all that shading reads.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub prepared: &'a Prepared,
    pub view: &'a View,
    pub settings: &'a Settings,
    /// Per item, the planes that cut it.
    pub planes: &'a [Option<PlaneMask>],
}

impl Scene<'_> {
    pub(crate) fn look(&self) -> Look {
        let Settings { light, point_light, filter, arithmetic, division, encoding, simd, .. } =
            *self.settings;
        Look { light, point_light, filter, arithmetic, division, encoding, simd }
    }

    /// What the colours of an item need in this frame.
    pub(crate) fn needs(&self, item: &Item) -> Needs {
        let needs = item.needs(self.settings.shading);
        let light = self.settings.point_light.filter(|_| needs.contains(Needs::LIT));
        let reached = light.is_some_and(|light| {
            self.settings.cull == CullTest::None || reaches(&light, &item.bounds)
        });
        if reached { needs.with(Needs::POINT_LIGHT) } else { needs }
    }
}

/// Whether a light may add something in a box. Shading measures distances in f32, from planes: the box
/// is taken for larger by more than that is off.
fn reaches(light: &PointLight, bounds: &Aabb) -> bool {
    let radius = f64::from(light.radius());
    let from_light = bounds.relative_to(light.position());
    let nearest = DVec3::ZERO.clamp(from_light.min, from_light.max);
    let margin = 1e-3 * (radius + (bounds.max - bounds.min).length());
    nearest.length() < radius + margin || !nearest.is_finite()
}

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

    /// Model-space corners.
    pub(crate) fn positions(&self) -> [DVec3; 3] {
        self.corners.map(|i| self.surface.mesh.positions[i as usize].as_dvec3())
    }

    /// Distances of the corners along the view axis, scene units.
    pub(crate) fn distances(&self, view: &View) -> DVec3 {
        let view_from_model = view.view_from_model(&self.item.world_from_model);
        let row = DMat4::from(view_from_model).row(2);
        DVec3::from_array(self.positions().map(|p| -row.dot(p.extend(1.0))))
    }

    /// Linear colour of a fragment.
    pub(crate) fn color(&self, scene: &Scene<'_>, fragment: &Fragment) -> Vec4 {
        let VisibleTriangle { surface, corners, front, .. } = *self;
        let needs = scene.needs(self.item);
        let triangle = Triangle { surface, corners, front };
        cullet_shade::shade(needs, &triangle, &scene.look(), fragment)
    }
}

/// Whether a material has matter at a fragment of a triangle: always, unless it is alpha-masked.
pub(crate) fn keeps(
    surface: &Surface<'_>,
    corners: [u32; 3],
    fragment: &Fragment,
    settings: &Settings,
) -> bool {
    match surface.material.alpha {
        AlphaMode::Mask { cutoff } => alpha(surface, corners, fragment, settings.filter) >= cutoff,
        AlphaMode::Opaque | AlphaMode::Blend => true,
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
    pub places: Places<'r>,
}

/// Where the pixels of a run lie on their triangle.
#[derive(Clone, Copy)]
pub(crate) enum Places<'r> {
    Planes(&'r Interpolator),
    /// A run of one.
    One(&'r Fragment),
}

impl Run<'_> {
    /// Pixel `i` of the run.
    fn fragment(&self, i: usize) -> Fragment {
        match self.places {
            Places::Planes(interpolator) => interpolator.fragment(self.x + i as u32, self.y),
            Places::One(fragment) => *fragment,
        }
    }
}

/// Takes a run and the triangle it shows.
pub(crate) type Emit<'e, 'a> = dyn FnMut(Run<'_>, &VisibleTriangle<'a>) + 'e;

/// What shading did.
#[derive(Default)]
pub(crate) struct Shaded {
    pub n_pixels: u64,
    pub shade: Duration,
}

/// Fills every pass of `frame` band by band, by `shade`: it gets a part of the picture and where
/// its passes go, and returns how many pixels show something.
pub(crate) fn shade_bands(
    threads: usize,
    region: Region,
    frame: &mut Frame,
    band_rows: u32,
    shade: impl Fn(Region, &mut Target<'_>) -> u64 + Sync,
) -> Shaded {
    let start = Instant::now();
    let n_pixels = AtomicU64::new(0);
    // Bands end at whole multiples of their rows in the whole picture.
    let first_rows = band_rows - region.y % band_rows;
    for_each(threads, frame.bands(first_rows, band_rows), |mut band| {
        let (y, height) = (region.y + band.first_row as u32, band.rows as u32);
        let n = shade(Region { y, height, ..region }, &mut band.target);
        n_pixels.fetch_add(n, Ordering::Relaxed);
    });
    Shaded { n_pixels: n_pixels.into_inner(), shade: start.elapsed() }
}

/// Fills the colours of a rectangle with background; `out` begins at its upper left pixel.
pub(crate) fn fill_background(settings: &Settings, rect: Region, out: &mut Target<'_>) {
    fill_background_from(settings, [rect.width, rect.height], 0, out);
}

/// Fills `width` by `height` colours from pixel `first` of `out` on with background.
pub(crate) fn fill_background_from(
    settings: &Settings,
    [width, height]: [u32; 2],
    first: usize,
    out: &mut Target<'_>,
) {
    let code = encode(settings.encoding, settings.background);
    for y in 0..height as usize {
        let start = first + y * out.stride;
        let row = start..start + width as usize;
        if let Some(row) = out.linear.get_mut(row.clone()) {
            row.fill(settings.background);
        } else if let Some(row) = out.rgba8.get_mut(row) {
            row.fill(code);
            let later = start + ROWS_AHEAD * out.stride;
            prefetch_all(out.rgba8, later..later + width as usize);
        }
    }
}

/// Encodes the linear picture of a rectangle, where there is one, into bytes, where they are
/// wanted.
pub(crate) fn encode_linear(settings: &Settings, rect: Region, out: &mut Target<'_>) {
    for y in 0..rect.height as usize {
        let row = y * out.stride..y * out.stride + rect.width as usize;
        if let (Some(linear), Some(bytes)) = (out.linear.get(row.clone()), out.rgba8.get_mut(row)) {
            encode_all(settings.simd, settings.encoding, linear, bytes);
        }
    }
}

/// Fills all passes of a run. `start` is its place in `out`.
pub(crate) fn shade_run(
    scene: &Scene<'_>,
    out: &mut Target<'_>,
    start: usize,
    triangle: &VisibleTriangle<'_>,
    run: &Run<'_>,
) {
    let range = start..start + run.len;
    if scene.settings.passes.needs_color() {
        if out.linear.is_empty() {
            let encoding = scene.settings.encoding;
            fill(out.rgba8, &range, run, |f| encode(encoding, triangle.color(scene, f)));
        } else {
            fill(out.linear, &range, run, |f| triangle.color(scene, f));
        }
    }
    fill_run(scene, out, start, triangle, run, scene.settings.passes);
}

/// Fills the data among `passes` of a run.
pub(crate) fn fill_run(
    scene: &Scene<'_>,
    out: &mut Target<'_>,
    start: usize,
    triangle: &VisibleTriangle<'_>,
    run: &Run<'_>,
    passes: Passes,
) {
    let range = start..start + run.len;
    let VisibleTriangle { surface, corners, front, .. } = *triangle;
    let filter = scene.settings.filter;
    if passes.contains(Pass::Depth) {
        let distances = triangle.distances(scene.view);
        match run.places {
            Places::Planes(planes) => {
                let (level, out) = (scene.settings.simd, &mut out.depth[range.clone()]);
                planes.fill_row(level, distances, [run.x, run.y], out);
            }
            Places::One(fragment) => {
                out.depth[range.clone()].fill(fragment.weights.dot(distances) as f32);
            }
        }
    }
    if passes.contains(Pass::Normal) {
        fill(out.normal, &range, run, |f| world_normal(&surface, corners, front, f));
    }
    if passes.contains(Pass::Albedo) {
        fill(out.albedo, &range, run, |f| base_color(&surface, corners, f, filter));
    }
    if passes.contains(Pass::Uv) {
        fill(out.uv, &range, run, |f| uv(&surface, corners, f));
    }
    if passes.contains(Pass::Position) {
        fill(out.position, &range, run, |f| world_position(&surface, corners, f));
    }
    if passes.contains(Pass::Id) {
        fill(out.id, &range, run, |_| triangle.item_idx as u32 + 1);
    }
    if passes.contains(Pass::Triangle) {
        fill(out.triangle, &range, run, |_| triangle.id + 1);
    }
}

fn fill<T>(
    pass: &mut [T],
    range: &std::ops::Range<usize>,
    run: &Run<'_>,
    mut value: impl FnMut(&Fragment) -> T,
) {
    for (i, out) in pass[range.clone()].iter_mut().enumerate() {
        *out = value(&run.fragment(i));
    }
}

/// Linear RGBA to 8-bit sRGB with linear alpha.
pub(crate) fn encode(encoding: Encoding, color: Vec4) -> [u8; 4] {
    // Most pixels are opaque, and rounding is a call where there is no instruction for it.
    let opaque = color.w == 1.0;
    let alpha = if opaque { 255 } else { (color.w * 255.0).round_ties_even() as u8 }; // NaN is 0
    let [r, g, b, _] = color.to_array();
    [encoding.encode8(r), encoding.encode8(g), encoding.encode8(b), alpha]
}
