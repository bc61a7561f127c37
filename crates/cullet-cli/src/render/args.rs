//! The options of `cullet render`.

use std::num::NonZeroU32;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use cullet::{
    Antialias, Arithmetic, CullTest, DepthKind, Division, EdgeShading, Encoding, Filter, Level,
    Light, PointLight, Region, RendererKind, Resolution, Settings, Shading, ShadingRate,
    SubpixelBits, Transforms,
};
use glam::{DVec3, Vec3, Vec4};

use super::passes::PassName;
use crate::exit::Failure;
use crate::picture_file::PngCompression;
use crate::source::Source;

/// Draw a scene.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    #[command(flatten)]
    pub source: Source,
    /// The picture: .png, .jpg, .webp, .exr, .ppm or .f32 (raw little-endian floats); `-` writes
    /// a PNG to standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// `auto` frames everything visible; or the index or name of a camera of the scene; or a
    /// camera file
    #[arg(long, value_name = "auto|INDEX|NAME|FILE.json", default_value = "auto")]
    pub camera: String,
    /// Size of the picture in pixels [default: that of the camera file, or else 1280x720]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Draw only these pixels of the picture; the origin is at the top left. The depth pass as
    /// integers still takes the time of the whole picture, whose range its greys span
    #[arg(long, value_name = "X,Y,W,H", value_parser = region)]
    pub region: Option<Region>,
    /// How surfaces answer to light
    #[arg(long, value_enum, default_value = "lambert")]
    pub shading: ShadingName,
    /// Colour where nothing is, linear light
    #[arg(long, value_name = "r,g,b|transparent", default_value = "0.02,0.03,0.05")]
    #[arg(value_parser = background, allow_hyphen_values = true)]
    pub background: Vec4,
    /// Direction towards the sun in world space, any length but 0
    #[arg(long, value_name = "X,Y,Z", default_value = "0.4,1,0.6")]
    #[arg(value_parser = vector, allow_hyphen_values = true)]
    pub sun: Vec3,
    /// Share of light that comes from everywhere, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, allow_hyphen_values = true)]
    pub ambient: f32,
    /// A light at a point, besides: world-space place, linear colour, and the distance at which it ends,
    /// in scene units or `inf`
    #[arg(long, value_name = "X,Y,Z,R,G,B,RADIUS", value_parser = point_light)]
    #[arg(allow_hyphen_values = true)]
    pub point_light: Option<PointLight>,
    /// How well to draw: what the options that trade accuracy for speed are where they are not given
    /// (aa, accumulate, resolution). `cullet tradeoff` measures what each gains and costs
    #[arg(long, value_enum, default_value = "balanced")]
    pub quality: Quality,
    /// How textures are filtered
    #[arg(long, value_enum, default_value = "trilinear")]
    pub texture: TextureFilter,
    /// The numbers that texels are blended in: floats, or whole numbers of 16 bits (15 of colour) or 8 bits
    /// of linear light. The few pixels that single precision does not serve, and the nearest and the anisotropic filter,
    /// take floats
    #[arg(long, value_enum, default_value = "float")]
    pub texture_arithmetic: ArithmeticName,
    /// How shading divides by w and normalises. Approximate: reciprocals and inverse roots with a relative error
    /// up to 7e-6, without dividing, where eight pixels are shaded at a time. No effect on the others (those
    /// that single precision does not serve) and on the ray caster
    #[arg(long, value_enum, default_value = "exact")]
    pub division: DivisionName,
    /// How colours become 8-bit codes; table and polynomial are off by one code at most. 16-bit codes are
    /// always exact
    #[arg(long, value_enum, default_value = "exact")]
    pub srgb: SrgbName,
    /// How edges are smoothed: so many samples of each pixel find out what is visible, and each triangle
    /// seen there is shaded once (msaa), or every sample is shaded (ssaa: four or sixteen times the work).
    /// Data passes and the ray caster take one sample at the centre [default: msaa4; none with
    /// --quality fast and with --accumulate, ssaa16 with --quality reference]
    #[arg(long, value_enum)]
    pub aa: Option<Antialiasing>,
    /// Where a triangle is shaded that only some of a pixel's samples see (msaa): in the middle of those, or
    /// at the pixel's centre, as OpenGL has it, which may lie outside of it (colours of such pixels are cut to 0..1 then,
    /// also in .exr and .f32). With `--texture trilinear-log`, for pictures to be compared with OpenGL's
    #[arg(long, value_enum, default_value = "covered")]
    pub edge_shading: EdgeShadingName,
    /// Pixels of a triangle, along a side, that share a colour; edges stay where they are. The ray caster
    /// shades each pixel
    #[arg(long, value_enum, default_value = "1")]
    pub shading_rate: ShadingRateName,
    /// The arithmetic that puts vertices on the screen. f32 is off by a few units of 2^-24 of the
    /// largest term: little, unless models are much larger than what is seen of them. No effect on the
    /// ray caster
    #[arg(long, value_enum, default_value = "f64")]
    pub transform: TransformName,
    /// Bits of the grid below the pixel that vertices are snapped to: edges move by up to 1/32, 1/512,
    /// 1/8192 or 1/131072 px, the ray caster's as well where it is to see them snapped. Only 8 has the fast code
    #[arg(long, value_enum, default_value = "8")]
    pub subpixel_bits: SubpixelBitsName,
    /// What is kept of a sample's depth: how far apart things must be to be told apart (docs/depth.md
    /// has the figures). Only f32 has the fast code. No effect on the ray caster
    #[arg(long, value_enum, default_value = "f32")]
    pub depth_format: DepthName,
    /// Draw colours as the mean of so many frames, each shifted by a part of a pixel: smooths textures,
    /// masks and edges alike, and takes as many times as long. Its frames take one sample per pixel
    /// unless --aa says more [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    #[arg(allow_negative_numbers = true)]
    pub accumulate: Option<u32>,
    /// How many pixels are coloured; data passes and the ray caster take all [default: full]
    #[arg(long, value_enum)]
    pub resolution: Option<ResolutionName>,
    /// Kinds of picture; several put their name before the extension (x.png: x.color.png)
    #[arg(long, value_enum, value_delimiter = ',', default_value = "color")]
    pub passes: Vec<PassName>,
    /// Which object is which number of the id pass, as JSON; `-` for standard output. `region` is
    /// left, top, width and height of what was drawn; the `bounds` of an object (left, top, right,
    /// bottom, the last two excluded) count from its corner
    #[arg(long, value_name = "FILE.json")]
    pub legend: Option<PathBuf>,
    /// Bits per sample; 16 for .png and .ppm only (.exr and .f32 always hold 32-bit floats). The
    /// id and triangle passes are 3 x 8 bits either way
    #[arg(long, value_name = "8|16", default_value = "8")]
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(["8", "16"]))]
    pub bits: String,
    /// How hard .png files are packed
    #[arg(long, value_enum, default_value = "fast")]
    pub png_compression: PngCompression,
    /// The test that throws out objects before any other work; changes time, never a pixel
    #[arg(long, value_enum, default_value = "both")]
    pub cull: CullName,
    /// Ask the tree over all objects first (it serves p-vertex, both and sat); changes time, never
    /// a pixel
    #[arg(long, value_enum, default_value = "on")]
    pub hierarchy: Switch,
    /// Leave out what lies behind large triangles and, tile by tile, behind what has been drawn; changes
    /// time, never a pixel
    #[arg(long, value_enum, default_value = "on")]
    pub occlusion: Switch,
    /// Pixels along a side of the tiles that a picture is drawn in, a multiple of 8 up to 256; changes
    /// time, never a pixel
    #[arg(long, value_name = "PX", default_value_t = 64, value_parser = tile_size)]
    #[arg(allow_negative_numbers = true)]
    pub tile_size: u32,
    /// Leave out objects smaller than this on the picture: the longer side of their boxes, in
    /// pixels. Unlike all other culling this changes pixels; 0 leaves out nothing
    #[arg(long, value_name = "PX", default_value_t = 0.0, value_parser = min_size)]
    #[arg(allow_negative_numbers = true)]
    pub min_size: f64,
    /// Instruction set of wide code; one that the machine lacks is an error. Changes time, never a
    /// pixel
    #[arg(long, value_enum, default_value = "auto")]
    pub simd: SimdName,
    /// Worker threads, 0 to 1024; 0 means one per core. Changes time, never a pixel
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub threads: u16,
    /// Who finds what is visible
    #[arg(long, value_enum, default_value = "raster")]
    pub renderer: RendererName,
    /// What the ray caster casts against: corners where the rasterizer's grid puts them, or the
    /// true ones
    #[arg(long, value_enum, default_value = "snapped")]
    pub raycast_geometry: RaycastGeometry,
    /// Draw the frame this often after one warm-up, to measure [default: once, no warm-up]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    pub frames: Option<u16>,
    /// Times (ms) and counters as JSON; `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    pub stats: Option<PathBuf>,
    /// Limit for the pixels drawn. Each takes about 24 bytes of memory for 8-bit colour, 72 for
    /// colour as floats, and 4 to 16 more for every further pass
    #[arg(long, value_name = "PIXELS", default_value_t = 1 << 28, help_heading = "Limits")]
    pub max_pixels: u64,
}

/// `--quality`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// For looking around
    Fast,
    /// Smooth edges and textures
    Balanced,
    /// For photographs
    Reference,
}

impl Quality {
    /// What it means.
    pub fn settings(self) -> Settings {
        match self {
            Quality::Fast => Settings::fast(),
            Quality::Balanced => Settings::balanced(),
            Quality::Reference => Settings::reference(),
        }
    }
}

/// `--resolution`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ResolutionName {
    /// Each
    Full,
    /// One of four; the others are blended from those around them
    Half,
    /// Each, but one of four where a triangle's colours change little: saves where surfaces are even, and
    /// costs time where textures are not
    Adaptive,
}

impl ResolutionName {
    /// What it means.
    pub fn setting(self) -> Resolution {
        match self {
            ResolutionName::Full => Resolution::Full,
            ResolutionName::Half => Resolution::Half,
            ResolutionName::Adaptive => Resolution::Adaptive,
        }
    }
}

/// `--shading`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShadingName {
    /// A sun over an even ambient light
    Lambert,
    /// The base colour alone
    Unlit,
}

/// `--texture`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TextureFilter {
    /// The nearest texel of the nearest level
    Nearest,
    /// Four texels of the nearest level
    Bilinear,
    /// Four texels in each of two levels, blended by the length of what a pixel covers
    Trilinear,
    /// The same, blended by its logarithm, as OpenGL has it: blurs a little more. With --accumulate,
    /// textures get no sharper
    TrilinearLog,
    /// Up to sixteen trilinear samples along the longer side of what a pixel covers
    Anisotropic,
}

impl TextureFilter {
    /// What it means.
    pub fn setting(self) -> Filter {
        match self {
            TextureFilter::Nearest => Filter::Nearest,
            TextureFilter::Bilinear => Filter::Bilinear,
            TextureFilter::Trilinear => Filter::Trilinear,
            TextureFilter::TrilinearLog => Filter::TrilinearLog,
            TextureFilter::Anisotropic => Filter::Anisotropic,
        }
    }
}

/// `--texture-arithmetic`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ArithmeticName {
    /// 32-bit floats
    Float,
    /// 15 bits of colour, 16 of weight
    #[value(name = "16")]
    Sixteen,
    /// 8 bits of colour, 7 of weight
    #[value(name = "8")]
    Eight,
}

impl ArithmeticName {
    /// What it means.
    pub fn setting(self) -> Arithmetic {
        match self {
            ArithmeticName::Float => Arithmetic::Float,
            ArithmeticName::Sixteen => Arithmetic::Sixteen,
            ArithmeticName::Eight => Arithmetic::Eight,
        }
    }
}

/// `--division`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DivisionName {
    /// Division and square root as IEEE 754 has them
    Exact,
    /// Two steps of Newton from a guess
    Approximate,
}

/// `--srgb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SrgbName {
    /// The code nearest to the exact curve
    Exact,
    /// A table of 4096 evenly spaced values
    Table,
    /// A cubic in the fourth root
    Polynomial,
}

/// `--aa`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Antialiasing {
    /// One sample at the pixel centre
    None,
    /// Two samples
    Msaa2,
    /// Four samples
    Msaa4,
    /// Eight samples
    Msaa8,
    /// Two by two pixels for each, all shaded
    Ssaa4,
    /// Four by four pixels for each, all shaded
    Ssaa16,
}

/// `--edge-shading`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EdgeShadingName {
    /// In the middle of the samples that see it
    Covered,
    /// At the pixel's centre, as OpenGL has it
    Centre,
}

/// `--shading-rate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShadingRateName {
    /// Each pixel has its own
    #[value(name = "1")]
    One,
    /// Squares of two by two
    #[value(name = "2")]
    Two,
}

/// `--transform`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TransformName {
    /// Double precision
    F64,
    /// Single precision
    F32,
}

/// `--subpixel-bits`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SubpixelBitsName {
    /// Sixteenths of a pixel
    #[value(name = "4")]
    Four,
    /// The rule of Direct3D
    #[value(name = "8")]
    Eight,
    /// For comparison
    #[value(name = "12")]
    Twelve,
    /// For comparison; triangles are clipped sooner
    #[value(name = "16")]
    Sixteen,
}

/// `--depth-format`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DepthName {
    /// Float, reversed: 1 at the near plane
    F32,
    /// Float, 0 at the near plane
    F32Standard,
    /// 24-bit integer, 0 at the near plane
    U24,
    /// 16-bit integer, 0 at the near plane
    U16,
}

impl Antialiasing {
    /// What it means.
    pub fn setting(self) -> Antialias {
        match self {
            Antialiasing::None => Antialias::None,
            Antialiasing::Msaa2 => Antialias::Msaa2,
            Antialiasing::Msaa4 => Antialias::Msaa4,
            Antialiasing::Msaa8 => Antialias::Msaa8,
            Antialiasing::Ssaa4 => Antialias::Ssaa4,
            Antialiasing::Ssaa16 => Antialias::Ssaa16,
        }
    }
}

/// `--cull`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CullName {
    /// Draw everything
    None,
    /// All eight corners of the box against each plane
    Corners,
    /// One corner of the box against each plane
    PVertex,
    /// The frustum's corners against the planes of the box
    Reverse,
    /// `p-vertex`, and `reverse` of what survives
    Both,
    /// Exact: separating axes
    Sat,
}

/// On or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// Use it
    On,
    /// Do without
    Off,
}

/// `--simd`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SimdName {
    /// The best the machine has
    Auto,
    /// None
    Fallback,
    /// x86, 128 bits
    Sse2,
    /// x86, 128 bits
    #[value(name = "sse4.2")]
    Sse42,
    /// x86, 256 bits
    Avx2,
    /// x86, 512 bits
    Avx512,
    /// ARM, 128 bits
    Neon,
}

impl SimdName {
    /// The level, if the machine has it.
    pub fn level(self) -> Result<Level, Failure> {
        let name = match self {
            SimdName::Auto => return Ok(Level::new()),
            SimdName::Fallback => "scalar",
            SimdName::Sse2 => "sse2",
            SimdName::Sse42 => "sse4.2",
            SimdName::Avx2 => "avx2",
            SimdName::Avx512 => "avx512",
            SimdName::Neon => "neon",
        };
        let levels = cullet::cull::wide::levels();
        let found = levels.iter().find(|(known, _)| *known == name);
        found.map(|(_, level)| *level).ok_or_else(|| {
            let known: Vec<_> = levels.iter().map(|(name, _)| *name).collect();
            let known = known.join(", ").replace("scalar", "fallback");
            Failure::usage(format!("--simd {name}: this machine has {known}"))
        })
    }
}

/// What `--simd` calls a level.
pub fn level_name(level: Level) -> &'static str {
    let levels = cullet::cull::wide::levels();
    let same = |known: &Level| std::mem::discriminant(known) == std::mem::discriminant(&level);
    match levels.iter().find(|(_, known)| same(known)) {
        Some(("scalar", _)) | None => "fallback",
        Some((name, _)) => name,
    }
}

/// `--renderer`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RendererName {
    /// The rasterizer
    Raster,
    /// The plain f64 ray-casting twin; slow, for checking
    Raycast,
}

/// `--raycast-geometry`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RaycastGeometry {
    /// Where the rasterizer's grid puts them
    Snapped,
    /// Where the scene puts them
    Exact,
}

/// `--tile-size`.
pub fn tile_size(text: &str) -> Result<u32, String> {
    let side: u32 = text.parse().map_err(|_| format!("`{text}` is not a whole number"))?;
    if !(8..=256).contains(&side) || !side.is_multiple_of(8) {
        return Err("a tile's side is a multiple of 8 from 8 to 256".into());
    }
    Ok(side)
}

impl RenderArgs {
    /// The settings these options mean, with the passes still to be chosen.
    pub fn settings(&self) -> Result<Settings, Failure> {
        let preset = self.quality.settings();
        // Frames that become one picture need no smoothing of their own.
        let accumulates = self.accumulate.is_some_and(|n| n > 1);
        let antialias = if accumulates { Antialias::None } else { preset.antialias };
        Ok(Settings {
            shading: match self.shading {
                ShadingName::Lambert => Shading::Lambert,
                ShadingName::Unlit => Shading::Unlit,
            },
            passes: cullet::Passes::NONE,
            background: self.background,
            light: Light::new(self.sun, self.ambient)?,
            point_light: self.point_light,
            filter: self.texture.setting(),
            arithmetic: self.texture_arithmetic.setting(),
            division: match self.division {
                DivisionName::Exact => Division::Exact,
                DivisionName::Approximate => Division::Approximate,
            },
            encoding: match self.srgb {
                SrgbName::Exact => Encoding::Exact,
                SrgbName::Table => Encoding::Table,
                SrgbName::Polynomial => Encoding::Polynomial,
            },
            cull: match self.cull {
                CullName::None => CullTest::None,
                CullName::Corners => CullTest::Corners,
                CullName::PVertex => CullTest::PVertex,
                CullName::Reverse => CullTest::Reverse,
                CullName::Both => CullTest::Both,
                CullName::Sat => CullTest::Sat,
            },
            antialias: match self.renderer {
                RendererName::Raster => self.aa.map_or(antialias, Antialiasing::setting),
                RendererName::Raycast => Antialias::None, // it takes one sample
            },
            accumulate: self.accumulate.unwrap_or(preset.accumulate),
            resolution: self.resolution.map_or(preset.resolution, ResolutionName::setting),
            edge_shading: match self.edge_shading {
                EdgeShadingName::Covered => EdgeShading::Covered,
                EdgeShadingName::Centre => EdgeShading::Centre,
            },
            shading_rate: match self.shading_rate {
                ShadingRateName::One => ShadingRate::One,
                ShadingRateName::Two => ShadingRate::Two,
            },
            transforms: match self.transform {
                TransformName::F64 => Transforms::F64,
                TransformName::F32 => Transforms::F32,
            },
            subpixel_bits: match self.subpixel_bits {
                SubpixelBitsName::Four => SubpixelBits::Four,
                SubpixelBitsName::Eight => SubpixelBits::Eight,
                SubpixelBitsName::Twelve => SubpixelBits::Twelve,
                SubpixelBitsName::Sixteen => SubpixelBits::Sixteen,
            },
            depth_format: match self.depth_format {
                DepthName::F32 => DepthKind::ReversedF32,
                DepthName::F32Standard => DepthKind::StandardF32,
                DepthName::U24 => DepthKind::StandardU24,
                DepthName::U16 => DepthKind::StandardU16,
            },
            hierarchy: self.hierarchy == Switch::On,
            occlusion: self.occlusion == Switch::On,
            tile_px: self.tile_size,
            simd: self.simd.level()?,
            threads: usize::from(self.threads),
            min_size_px: self.min_size,
            cull_view: None,
            renderer: match (self.renderer, self.raycast_geometry) {
                (RendererName::Raster, _) => RendererKind::Raster,
                (RendererName::Raycast, RaycastGeometry::Snapped) => {
                    RendererKind::Raycast { snapped: true }
                }
                (RendererName::Raycast, RaycastGeometry::Exact) => {
                    RendererKind::Raycast { snapped: false }
                }
            },
            region: self.region,
        })
    }
}

/// A size as `WxH`, both at least 1.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']);
    let sides = sides.and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let sides: (NonZeroU32, NonZeroU32) =
        sides.ok_or("give width x height in pixels, both at least 1, like 1280x720")?;
    Ok((sides.0.get(), sides.1.get()))
}

fn min_size(text: &str) -> Result<f64, String> {
    let pixels = text.parse().ok().filter(|pixels: &f64| *pixels >= 0.0 && pixels.is_finite());
    pixels.ok_or_else(|| "give a number of pixels, 0 or more".into())
}

fn region(text: &str) -> Result<Region, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => {
            Ok(Region { x, y, width, height })
        }
        _ => Err("give left, top, width, height in pixels, the last two at least 1".into()),
    }
}

fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("give three numbers with commas between them".into()),
    }
}

fn point_light(text: &str) -> Result<PointLight, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z, r, g, b, radius]) => {
            let color = DVec3::new(r, g, b).as_vec3();
            PointLight::new(DVec3::new(x, y, z), color, radius as f32).map_err(|e| e.to_string())
        }
        _ => Err("give place, colour and radius: seven numbers with commas between them".into()),
    }
}

fn background(text: &str) -> Result<Vec4, String> {
    if text == "transparent" {
        return Ok(Vec4::ZERO);
    }
    let color = vector(text)?;
    let sound = color.is_finite() && color.cmpge(Vec3::ZERO).all();
    sound.then_some(color.extend(1.0)).ok_or_else(|| "give finite numbers, none below 0".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("1280x720"), Ok((1280, 720)));
        for text in ["", "1280", "0x1", "1x0", "-1x5", "1.5x2", "4294967296x1", "1x2x3"] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn regions() {
        let expected = Region { x: 1, y: 2, width: 3, height: 4 };
        assert_eq!(region("1,2,3,4"), Ok(expected));
        for text in ["1,2,3", "1,2,0,4", "-1,2,3,4", "1,2,3,4,5"] {
            assert!(region(text).is_err(), "{text}");
        }
    }

    #[test]
    fn point_lights() {
        let light = point_light("1,-2,3,1,0.5,0,inf").unwrap();
        assert_eq!(light.position(), DVec3::new(1.0, -2.0, 3.0));
        assert_eq!((light.color(), light.radius()), (Vec3::new(1.0, 0.5, 0.0), f32::INFINITY));
        for text in ["1,2,3", "1,2,3,1,1,1,-1", "1,2,3,-1,0,0,1", "nan,2,3,1,1,1,1", "a"] {
            assert!(point_light(text).is_err(), "{text}");
        }
    }

    #[test]
    fn backgrounds() {
        assert_eq!(background("transparent"), Ok(Vec4::ZERO));
        assert_eq!(background("1,0.5,0"), Ok(Vec4::new(1.0, 0.5, 0.0, 1.0)));
        for text in ["1,0", "nan,0,0", "-1,0,0", "inf,0,0", "red"] {
            assert!(background(text).is_err(), "{text}");
        }
    }
}
