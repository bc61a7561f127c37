//! How well and how to draw, as against what (`Prepared`) and from where (`View`).

use cullet_raster::{DepthKind, Precision, SubpixelBits, Transforms};
use cullet_shade::{Arithmetic, Division, Encoding, Filter, Light, PointLight, Shading};
use cullet_transform::View;
use glam::Vec4;

use crate::{Passes, Region, Resolution};
use cullet_cull::{Test as CullTest, wide::Level};

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
    /// A light at a point, besides. Objects beyond its radius are not asked about it, unless `cull`
    /// is `None`: that changes no pixel.
    pub point_light: Option<PointLight>,
    /// How textures are filtered.
    pub filter: Filter,
    /// What numbers texels are blended in.
    pub arithmetic: Arithmetic,
    /// How shading divides by `w` and normalises: exactly, or within 7e-6.
    pub division: Division,
    /// How colours become 8-bit codes: exactly, or within one.
    pub encoding: Encoding,
    /// How edges are smoothed. Data passes always take one sample at the pixel's centre.
    pub antialias: Antialias,
    /// Where triangles are shaded that share a pixel with others, with several samples per pixel.
    pub edge_shading: EdgeShading,
    /// How many pixels share a colour.
    pub shading_rate: ShadingRate,
    /// The arithmetic that puts vertices on the screen.
    pub transforms: Transforms,
    /// The grid that vertices are snapped to: how far edges move. Only the default has the fast code.
    pub subpixel_bits: SubpixelBits,
    /// What is kept of a sample's depth: how far apart things must be to be told apart. Only the
    /// default has the fast code.
    pub depth_format: DepthKind,
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
    /// Leave out what lies wholly behind large triangles, and, tile by tile, behind what has been drawn.
    /// Never changes a pixel.
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

    /// For photographs: sixteen samples per pixel, all shaded.
    pub fn reference() -> Settings {
        Settings { antialias: Antialias::Ssaa16, ..Settings::balanced() }
    }

    /// The default: smooth edges at some twice the time of a fast frame.
    pub fn balanced() -> Settings {
        Settings {
            shading: Shading::Lambert,
            passes: Passes::COLOR,
            background: Vec4::new(0.02, 0.03, 0.05, 1.0),
            light: Light::default(),
            point_light: None,
            filter: Filter::Trilinear,
            arithmetic: Arithmetic::Float,
            division: Division::Exact,
            encoding: Encoding::Exact,
            antialias: Antialias::Msaa4,
            edge_shading: EdgeShading::Covered,
            shading_rate: ShadingRate::One,
            transforms: Transforms::default(),
            subpixel_bits: SubpixelBits::default(),
            depth_format: DepthKind::default(),
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

impl Settings {
    pub(crate) fn precision(&self) -> Precision {
        let Settings { transforms, subpixel_bits, depth_format, .. } = *self;
        Precision { transforms, subpixel_bits, depth: depth_format }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Settings::balanced()
    }
}

/// How many samples of a pixel find out what is visible there, and how many are shaded.
///
/// With several samples (`Msaa`) each triangle seen in a pixel is shaded once: edges are smoothed,
/// textures and lights are not. With supersampling (`Ssaa`) every sample is shaded: the picture is
/// drawn with more pixels and averaged, which costs as much as those pixels do.
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
    /// Two by two pixels for each, averaged in linear light.
    Ssaa4,
    /// Four by four.
    Ssaa16,
}

impl Antialias {
    /// Pixels drawn for each one along a side. A picture whose sides times this exceed
    /// [`MAX_SIDE`](cullet_transform::MAX_SIDE) is drawn with half as many, or with one.
    pub const fn per_side(self) -> u32 {
        match self {
            Antialias::None | Antialias::Msaa2 | Antialias::Msaa4 | Antialias::Msaa8 => 1,
            Antialias::Ssaa4 => 2,
            Antialias::Ssaa16 => 4,
        }
    }
}

/// Where in a pixel a triangle is shaded that some of its samples see (`Msaa`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum EdgeShading {
    /// In the middle of those samples: inside the triangle. OpenGL calls it the centroid.
    #[default]
    Covered,
    /// At the pixel's centre, as OpenGL, Vulkan and Direct3D have it unless told otherwise: for pictures to be
    /// compared with theirs. It may lie outside of the triangle, whose colours are continued to there (where
    /// single precision does not serve, taken from its edge). In pixels that several share, colours are cut to
    /// `0..=1` before they are averaged, also in linear pictures, as those do that write 8 bits. Masks are asked at
    /// every sample, as otherwise.
    Centre,
}

/// How many pixels of a triangle share a colour. The ray caster shades each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShadingRate {
    /// Each has its own.
    One,
    /// Squares of two by two, shaded in the middle. Edges stay where they are; with several samples per
    /// pixel, pixels that show several triangles keep colours of their own.
    Two,
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
