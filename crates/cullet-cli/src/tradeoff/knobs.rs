//! What can be turned: every trade of speed for accuracy, one line per value.
//!
//! A new one is a [`Knob`] with its name, what is measured of it, and how each value changes the
//! settings; the rest follows from this list. Knobs and values stand in order of importance: where
//! the budget is short, the last are left out first.

use cullet::{
    Antialias, Arithmetic, CullTest, DepthKind, Division, EdgeShading, Encoding, Filter,
    Resolution, Settings, Shading, ShadingRate, SubpixelBits, Transforms,
};

use super::lamp::of_reach;
use super::metrics::Metric::{
    self, DefaultMax, EdgeRmse, FalseVisible, FlatRmse, Flip, IdPpm, LightFlip, LightMax, Shimmer,
    SsimLoss,
};

/// One trade.
pub struct Knob {
    /// As the option of `cullet render` is called.
    pub name: &'static str,
    /// What is measured of its values.
    pub metrics: &'static [Metric],
    /// From fast to true, mostly.
    pub values: &'static [Value],
}

/// A setting of a knob: its name, and what it changes of the balanced settings.
pub type Value = (&'static str, fn(&mut Settings));

/// The name of the knob whose values are the presets.
pub const QUALITY: &str = "quality";

/// The name of the knob of the light at a point; its values are reaches, see [`super::lamp`].
pub const POINT_LIGHT: &str = "point-light";

/// Its light without end: what one with an end is measured against.
pub fn endless_light(settings: &mut Settings) {
    settings.point_light = of_reach(f32::INFINITY);
}

/// The name of the knob of reciprocals and inverse roots.
pub const DIVISION: &str = "division";

/// The name of the knob of 8-bit codes.
pub const SRGB: &str = "srgb";

/// Every knob.
pub const KNOBS: &[Knob] = &[
    Knob {
        name: QUALITY,
        metrics: &[Flip, EdgeRmse, FlatRmse],
        values: &[
            ("balanced", |s| *s = Settings::balanced()),
            ("fast", |s| *s = Settings::fast()),
            ("reference", |s| *s = Settings::reference()),
        ],
    },
    Knob {
        name: "aa",
        metrics: &[Flip, EdgeRmse, FlatRmse],
        values: &[
            ("none", |s| s.antialias = Antialias::None),
            ("msaa2", |s| s.antialias = Antialias::Msaa2),
            ("msaa4", |s| s.antialias = Antialias::Msaa4),
            ("msaa8", |s| s.antialias = Antialias::Msaa8),
            ("ssaa4", |s| s.antialias = Antialias::Ssaa4),
            ("ssaa16", |s| s.antialias = Antialias::Ssaa16),
        ],
    },
    Knob {
        name: "texture",
        metrics: &[Flip, SsimLoss, Shimmer],
        values: &[
            ("nearest", |s| s.filter = Filter::Nearest),
            ("bilinear", |s| s.filter = Filter::Bilinear),
            ("trilinear-log", |s| s.filter = Filter::TrilinearLog),
            ("trilinear", |s| s.filter = Filter::Trilinear),
            ("anisotropic", |s| s.filter = Filter::Anisotropic),
        ],
    },
    Knob {
        name: "resolution",
        metrics: &[Flip, EdgeRmse],
        values: &[
            ("half", |s| s.resolution = Resolution::Half),
            ("adaptive", |s| s.resolution = Resolution::Adaptive),
            ("full", |s| s.resolution = Resolution::Full),
        ],
    },
    Knob {
        name: "accumulate",
        metrics: &[Flip, EdgeRmse, FlatRmse],
        values: &[
            ("1", |s| s.accumulate = 1),
            // Frames of one sample each, as a photograph is put together.
            ("4", |s| (s.accumulate, s.antialias) = (4, Antialias::None)),
            ("16", |s| (s.accumulate, s.antialias) = (16, Antialias::None)),
        ],
    },
    Knob {
        name: "shading",
        metrics: &[Flip],
        values: &[
            ("unlit", |s| s.shading = Shading::Unlit),
            ("lambert", |s| s.shading = Shading::Lambert),
        ],
    },
    Knob {
        name: "occlusion",
        metrics: &[IdPpm],
        values: &[("off", |s| s.occlusion = false), ("on", |s| s.occlusion = true)],
    },
    Knob {
        name: "cull",
        metrics: &[FalseVisible],
        values: &[
            ("none", |s| s.cull = CullTest::None),
            ("corners", |s| (s.cull, s.hierarchy) = (CullTest::Corners, false)),
            ("p-vertex", |s| s.cull = CullTest::PVertex),
            ("reverse", |s| (s.cull, s.hierarchy) = (CullTest::Reverse, false)),
            ("both", |s| s.cull = CullTest::Both),
            ("sat", |s| s.cull = CullTest::Sat),
            ("p-vertex-flat", |s| (s.cull, s.hierarchy) = (CullTest::PVertex, false)),
            ("both-flat", |s| s.hierarchy = false),
            ("sat-flat", |s| (s.cull, s.hierarchy) = (CullTest::Sat, false)),
        ],
    },
    // A light that is in no other row, so its errors have a reference and panels of their own.
    Knob {
        name: POINT_LIGHT,
        metrics: &[LightFlip, LightMax],
        values: &[
            ("none", |s| s.point_light = None),
            ("0.5", |s| s.point_light = of_reach(0.5)),
            ("1", |s| s.point_light = of_reach(1.0)),
            ("2", |s| s.point_light = of_reach(2.0)),
            ("inf", endless_light),
            // No object is spared for lying beyond the end.
            ("1-everywhere", |s| (s.point_light, s.cull) = (of_reach(1.0), CullTest::None)),
        ],
    },
    Knob {
        name: "shading-rate",
        metrics: &[Flip, SsimLoss],
        values: &[
            ("2", |s| s.shading_rate = ShadingRate::Two),
            ("1", |s| s.shading_rate = ShadingRate::One),
        ],
    },
    Knob {
        name: DIVISION,
        metrics: &[Flip, DefaultMax],
        values: &[
            ("approximate", |s| s.division = Division::Approximate),
            ("exact", |s| s.division = Division::Exact),
        ],
    },
    Knob {
        name: SRGB,
        metrics: &[Flip, DefaultMax],
        values: &[
            ("table", |s| s.encoding = Encoding::Table),
            ("polynomial", |s| s.encoding = Encoding::Polynomial),
            ("exact", |s| s.encoding = Encoding::Exact),
        ],
    },
    Knob {
        name: "transform",
        metrics: &[IdPpm],
        values: &[
            ("f32", |s| s.transforms = Transforms::F32),
            ("f64", |s| s.transforms = Transforms::F64),
        ],
    },
    Knob {
        name: "texture-arithmetic",
        metrics: &[Flip],
        values: &[
            ("8", |s| s.arithmetic = Arithmetic::Eight),
            ("16", |s| s.arithmetic = Arithmetic::Sixteen),
            ("float", |s| s.arithmetic = Arithmetic::Float),
        ],
    },
    Knob {
        name: "edge-shading",
        metrics: &[Flip, EdgeRmse],
        values: &[
            ("centre", |s| s.edge_shading = EdgeShading::Centre),
            ("covered", |s| s.edge_shading = EdgeShading::Covered),
        ],
    },
    Knob {
        name: "subpixel-bits",
        metrics: &[IdPpm],
        values: &[
            ("4", |s| s.subpixel_bits = SubpixelBits::Four),
            ("8", |s| s.subpixel_bits = SubpixelBits::Eight),
            ("12", |s| s.subpixel_bits = SubpixelBits::Twelve),
            ("16", |s| s.subpixel_bits = SubpixelBits::Sixteen),
        ],
    },
    Knob {
        name: "depth-format",
        metrics: &[IdPpm],
        values: &[
            ("u16", |s| s.depth_format = DepthKind::StandardU16),
            ("u24", |s| s.depth_format = DepthKind::StandardU24),
            ("f32-standard", |s| s.depth_format = DepthKind::StandardF32),
            ("f32", |s| s.depth_format = DepthKind::ReversedF32),
        ],
    },
    Knob {
        name: "min-size",
        metrics: &[Flip, IdPpm],
        values: &[
            ("0", |s| s.min_size_px = 0.0),
            ("1", |s| s.min_size_px = 1.0),
            ("4", |s| s.min_size_px = 4.0),
            ("16", |s| s.min_size_px = 16.0),
        ],
    },
];

/// Whether these settings leave the wide code for the plain one: `texture nearest`, grids other than the
/// default's and other depth formats. What they take says nothing about what such values cost where
/// there is wide code.
pub fn is_plain(settings: &Settings) -> bool {
    let usual = Settings::balanced();
    settings.filter == Filter::Nearest
        || settings.subpixel_bits != usual.subpixel_bits
        || settings.depth_format != usual.depth_format
}

/// One configuration, and every value of a knob that means it.
pub struct Configuration {
    /// All of them.
    pub settings: Settings,
    /// Knob, its value, and what is measured of it.
    pub uses: Vec<(&'static str, &'static str, &'static [Metric])>,
}

/// Every value of every knob, turned from the balanced settings with `common` applied; values that
/// mean the same are one. The first is the balanced one.
pub fn configurations(common: impl Fn(&mut Settings)) -> Vec<Configuration> {
    let mut all: Vec<Configuration> = Vec::new();
    for knob in KNOBS {
        for &(value, change) in knob.values {
            let mut settings = Settings::balanced();
            change(&mut settings);
            common(&mut settings);
            let wording = format!("{settings:?}");
            let used = (knob.name, value, knob.metrics);
            match all.iter_mut().find(|known| format!("{:?}", known.settings) == wording) {
                Some(known) => known.uses.push(used),
                None => all.push(Configuration { settings, uses: vec![used] }),
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_knob_has_the_default_among_its_values() {
        let all = configurations(|_| ());
        let balanced = &all[0];
        assert_eq!(balanced.uses[0].1, "balanced");
        for knob in KNOBS {
            assert!(balanced.uses.iter().any(|(name, ..)| *name == knob.name), "{}", knob.name);
            assert!(!knob.metrics.is_empty());
        }
        let n: usize = KNOBS.iter().map(|knob| knob.values.len()).sum();
        assert_eq!(all.iter().map(|one| one.uses.len()).sum::<usize>(), n);
    }
}
