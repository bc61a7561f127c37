//! How exactly: the choices a frame has about positions and depths.
//!
//! The default takes the wide code of [`crate::draw`]; every other choice takes the plain code, sample by
//! sample, with the same rules on another grid or with other codes of depth.

use cullet_transform::{ClipPoint, PlaneMask, Viewport};

use crate::depth::{DepthFormat, ReversedF32, StandardF32, StandardU16, StandardU24};
use crate::fixed::{Fixed, guard_band, snap};
use crate::interpolate::Interpolator;

/// How exactly positions and depths are held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Precision {
    /// The grid that vertices are snapped to.
    pub subpixel_bits: SubpixelBits,
    /// What is kept of a sample's depth.
    pub depth: DepthKind,
}

impl Precision {
    /// Whether the wide code of [`crate::draw()`] serves.
    pub(crate) fn is_wide(self) -> bool {
        self == Precision::default()
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
