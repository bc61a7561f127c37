//! How well and how to draw, as against what (`Prepared`) and from where (`View`).

use cullet_shade::{Filter, Light, Shading};
use cullet_transform::View;
use glam::Vec4;

use crate::{Passes, Region, Resolution};
use cullet_cull::{Test as CullTest, wide::Level};

/// Subpixel positions: 24.8 fixed point.
pub(crate) const SUBPIXEL_BITS: u32 = 8;

/// The knobs of a frame. `cull`, `hierarchy`, `simd` and `threads` change only how
/// long a frame takes, never what is in it.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How surfaces answer to light.
    pub shading: Shading,
    /// Which pictures to make.
    pub passes: Passes,
    /// Linear RGBA where nothing is; alpha is straight.
    pub background: Vec4,
    /// The sun and the even light around it.
    pub light: Light,
    /// How textures are filtered.
    pub filter: Filter,
    /// How edges are smoothed. Data passes always take one sample at the pixel's centre.
    pub antialias: Antialias,
    /// Pictures that a frame is the mean of, each shifted by a part of a pixel; 0 and 1 mean one. `n`
    /// of them take `n` times as long and smooth everything, not edges alone. See
    /// [`sample_place`](crate::sample_place).
    pub accumulate: u32,
    /// How many pixels are coloured.
    pub resolution: Resolution,
    /// The test that throws out objects before any vertex work. Never changes a pixel.
    pub cull: CullTest,
    /// Ask the tree over all objects first, where it serves the test (`PVertex`, `Both`, `Sat`).
    pub hierarchy: bool,
    /// Leave out, tile by tile, what lies wholly behind what has been drawn there. Never changes a
    /// pixel.
    pub occlusion: bool,
    /// Pixels along a side of the tiles that the picture is drawn in: a multiple of 8 from 8 to 256, others
    /// are rounded to one. Never changes a pixel.
    pub tile_px: u32,
    /// The instruction set of wide code. Never changes a pixel.
    pub simd: Level,
    /// Leave out objects whose boxes are smaller than this on the picture, the longer side in
    /// pixels. 0 leaves out nothing; more **changes pixels**: see
    /// [`projected_size_px`](cullet_cull::projected_size_px).
    pub min_size_px: f64,
    /// Also throw out what `cull` finds outside this other view, so that one can look from
    /// outside at what that view keeps. The one thing about culling that is meant to be seen:
    /// it takes objects away from the picture.
    pub cull_view: Option<View>,
    /// Worker threads; 0 means one per core.
    pub threads: usize,
    /// Who finds what is visible.
    pub renderer: RendererKind,
    /// The part of the picture to draw; `None` means all of it. Cut to the picture; of a region
    /// wholly outside, the nearest pixel is drawn.
    pub region: Option<Region>,
}

impl Settings {
    /// For looking around: one sample per pixel.
    pub fn fast() -> Settings {
        Settings { antialias: Antialias::None, ..Settings::balanced() }
    }

    /// For photographs: the mean of sixteen frames of one sample per pixel.
    pub fn reference() -> Settings {
        Settings { antialias: Antialias::None, accumulate: 16, ..Settings::balanced() }
    }

    /// The default: smooth edges and textures at twice the time of a fast frame.
    pub fn balanced() -> Settings {
        Settings {
            shading: Shading::Lambert,
            passes: Passes::COLOR,
            background: Vec4::new(0.02, 0.03, 0.05, 1.0),
            light: Light::default(),
            filter: Filter::Trilinear,
            antialias: Antialias::Msaa4,
            accumulate: 1,
            resolution: Resolution::Full,
            cull: CullTest::Both,
            hierarchy: true,
            occlusion: true,
            tile_px: 64,
            simd: Level::new(),
            min_size_px: 0.0,
            cull_view: None,
            threads: 0,
            renderer: RendererKind::Raster,
            region: None,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Settings::balanced()
    }
}

/// How many samples of a pixel find out what is visible there. Each triangle seen in a pixel is
/// shaded once: edges are smoothed, textures and lights are not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Antialias {
    /// One, at the centre.
    None,
    /// Two, in the standard pattern of Direct3D and Vulkan, as the following.
    Msaa2,
    /// Four.
    Msaa4,
    /// Eight.
    Msaa8,
}

/// Who finds what is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RendererKind {
    /// The rasterizer.
    Raster,
    /// The plain ray caster, in f64; slow, for checking.
    Raycast {
        /// Cast against triangles moved to their snapped screen positions, as the rasterizer
        /// sees them, or against the true ones.
        snapped: bool,
    },
}
