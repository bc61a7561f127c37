//! How exactly: the choices a frame has about positions and depths.
//!
//! The default takes the wide code of [`crate::draw`] where there are wide registers; every other choice takes the
//! plain code, sample by sample, with the same rules on another grid or with other codes of depth.

use cullet_transform::{ClipPoint, PlaneMask, Viewport};
use glam::{DMat4, Vec3};

use crate::depth::{DepthFormat, ReversedF32, StandardF32, StandardU16, StandardU24};
use crate::fixed::{Fixed, guard_band, snap};
use crate::interpolate::Interpolator;

/// How exactly positions and depths are held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Precision {
    /// The arithmetic that brings vertices to that grid.
    pub transforms: Transforms,
    /// The grid that vertices are snapped to.
    pub subpixel_bits: SubpixelBits,
    /// What is kept of a sample's depth.
    pub depth: DepthKind,
}

impl Precision {
    /// Whether the wide code of [`crate::draw()`] serves, on machines that can run it.
    pub(crate) fn is_wide(self) -> bool {
        let transforms = self.transforms;
        self == Precision { transforms, ..Precision::default() }
    }
}

/// The arithmetic of matrices, divide and snap, as far as the rasterizer goes: shading, culling and the
/// ray caster are f64 always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Transforms {
    /// Exact to far below the grid, whatever the lens, offset or scale.
    #[default]
    F64,
    /// Off by a few units of 2^-24 of the largest term: next to nothing where model coordinates are of
    /// the size of what is seen, a good part of a pixel for models of 1e5 times that size or lenses
    /// of .01 degrees. What culling throws out is decided by true positions, and may then show at the
    /// border of a picture drawn without culling.
    F32,
}

impl Transforms {
    /// A model-space point in clip space. In f32 the result is one of f32, operation by operation
    /// rounded.
    pub fn clip(self, clip_from_model: &DMat4, point: Vec3) -> ClipPoint {
        if self == Transforms::F64 {
            return ClipPoint::from_model(clip_from_model, point.as_dvec3());
        }
        let m = clip_from_model.as_mat4();
        let (i, j, k, t) = (m.x_axis, m.y_axis, m.z_axis, m.w_axis);
        let sum = |axis: usize| {
            f64::from(point.x * i[axis] + point.y * j[axis] + point.z * k[axis] + t[axis])
        };
        ClipPoint { x: sum(0), y: sum(1), z: sum(2), w: sum(3) }
    }

    /// [`snap`] in this arithmetic.
    pub(crate) fn snap<const BITS: u32>(self, viewport: Viewport, point: &ClipPoint) -> Fixed {
        if self == Transforms::F64 {
            return snap::<BITS>(viewport, point);
        }
        let axis = |at: f64, half: f32, side: u32| {
            let px = (0.5 + at as f32 / point.w as f32 * half) * side as f32;
            let guard = guard_band(side, BITS) as f32;
            let (low, high) = (-guard, side as f32 + guard);
            // Compare and select, as there: NaN lands on the low border.
            let px = if px > low { px } else { low };
            let px = if px < high { px } else { high };
            (px * (1u32 << BITS) as f32).round_ties_even() as i64
        };
        Fixed { x: axis(point.x, 0.5, viewport.width()), y: axis(point.y, -0.5, viewport.height()) }
    }

    /// Reversed depth in this arithmetic; division may round a clipped depth past the end.
    pub(crate) fn depth(self, point: &ClipPoint) -> f64 {
        match self {
            Transforms::F64 => point.ndc().depth.clamp(0.0, 1.0),
            Transforms::F32 => f64::from((point.z as f32 / point.w as f32).clamp(0.0, 1.0)),
        }
    }
}

/// Bits of a snapped position below the pixel. Edges move by up to half a unit of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SubpixelBits {
    /// Edges move by up to 1/32 px.
    Four,
    /// Up to 1/512 px: the rule of Direct3D, and the fast way.
    #[default]
    Eight,
    /// Up to 1/8192 px.
    Twelve,
    /// Up to 1/131072 px. The guard band ends 8192 px beyond a picture of 16384 px, sooner beyond a
    /// larger one.
    Sixteen,
}

impl SubpixelBits {
    /// Every number of bits.
    pub const ALL: [SubpixelBits; 4] =
        [SubpixelBits::Four, SubpixelBits::Eight, SubpixelBits::Twelve, SubpixelBits::Sixteen];

    /// How many.
    pub const fn count(self) -> u32 {
        match self {
            SubpixelBits::Four => 4,
            SubpixelBits::Eight => 8,
            SubpixelBits::Twelve => 12,
            SubpixelBits::Sixteen => 16,
        }
    }

    /// Units of the grid in a pixel.
    pub const fn units(self) -> f64 {
        (1u32 << self.count()) as f64
    }

    /// [`crate::guard_band`] on this grid.
    pub const fn guard_band(self, side: u32) -> u32 {
        guard_band(side, self.count())
    }

    /// [`crate::snap`] to this grid.
    pub fn snap(self, viewport: Viewport, point: &ClipPoint) -> Fixed {
        match self {
            SubpixelBits::Four => snap::<4>(viewport, point),
            SubpixelBits::Eight => snap::<8>(viewport, point),
            SubpixelBits::Twelve => snap::<12>(viewport, point),
            SubpixelBits::Sixteen => snap::<16>(viewport, point),
        }
    }

    /// [`Interpolator::new`] on this grid.
    pub fn interpolator(
        self,
        viewport: Viewport,
        corners: &[ClipPoint; 3],
        planes: PlaneMask,
    ) -> Interpolator {
        match self {
            SubpixelBits::Four => Interpolator::new::<4>(viewport, corners, planes),
            SubpixelBits::Eight => Interpolator::new::<8>(viewport, corners, planes),
            SubpixelBits::Twelve => Interpolator::new::<12>(viewport, corners, planes),
            SubpixelBits::Sixteen => Interpolator::new::<16>(viewport, corners, planes),
        }
    }
}

/// A [`DepthFormat`], chosen at run time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthKind {
    /// [`crate::ReversedF32`]: the fast way.
    #[default]
    ReversedF32,
    /// [`crate::StandardF32`].
    StandardF32,
    /// [`crate::StandardU24`].
    StandardU24,
    /// [`crate::StandardU16`].
    StandardU16,
}

impl DepthKind {
    /// Every format.
    pub const ALL: [DepthKind; 4] = [
        DepthKind::ReversedF32,
        DepthKind::StandardF32,
        DepthKind::StandardU24,
        DepthKind::StandardU16,
    ];

    /// The key of a reversed depth, in `0..=1`: never smaller for what is nearer.
    pub fn key(self, reversed: f64) -> i32 {
        fn key<D: DepthFormat>(reversed: f64) -> i32 {
            D::key(D::encode(reversed))
        }
        match self {
            DepthKind::ReversedF32 => key::<ReversedF32>(reversed),
            DepthKind::StandardF32 => key::<StandardF32>(reversed),
            DepthKind::StandardU24 => key::<StandardU24>(reversed),
            DepthKind::StandardU16 => key::<StandardU16>(reversed),
        }
    }
}
