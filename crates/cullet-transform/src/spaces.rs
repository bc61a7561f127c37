//! Points in the spaces where stages meet and a mix-up would compile.

use glam::{DMat4, DVec3, DVec4};

use crate::PlaneMask;

/// A point in clip space, before the divide by `w`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPoint {
    /// Inside: `-w..=w`.
    pub x: f64,
    /// Inside: `-w..=w`, up.
    pub y: f64,
    /// Inside: `0..=w`, reversed: `w` at the near plane.
    pub z: f64,
    /// Distance along the view axis (perspective) or 1 (orthographic).
    pub w: f64,
}

impl ClipPoint {
    /// A model-space point through `clip_from_model`.
    pub fn from_model(clip_from_model: &DMat4, point_model: DVec3) -> Self {
        let p: DVec4 = *clip_from_model * point_model.extend(1.0);
        ClipPoint { x: p.x, y: p.y, z: p.z, w: p.w }
    }

    /// The planes this point lies outside of ("outcode"; Newman & Sproull 1973, after Cohen and
    /// Sutherland). A point on a plane is inside. NaN coordinates are outside of nothing:
    /// ask [`ClipPoint::is_finite`] first.
    pub fn outcode(&self) -> PlaneMask {
        let outside = [
            self.x < -self.w,
            self.x > self.w,
            self.y < -self.w,
            self.y > self.w,
            self.z > self.w,
            self.z < 0.0,
        ];
        let mut mask = PlaneMask::NONE;
        for (i, _) in outside.into_iter().enumerate().filter(|(_, out)| *out) {
            mask.insert(i);
        }
        mask
    }

    /// No coordinate is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite() && self.w.is_finite()
    }

    /// The divide. Meaningful for `w > 0` only; `w = 0` gives infinities or NaN.
    pub fn ndc(&self) -> NdcPoint {
        NdcPoint { x: self.x / self.w, y: self.y / self.w, depth: self.z / self.w }
    }

    /// The point between `self` (`t = 0`) and `other` (`t = 1`).
    #[must_use]
    pub fn lerp(&self, other: &ClipPoint, t: f64) -> ClipPoint {
        ClipPoint {
            x: self.x + (other.x - self.x) * t,
            y: self.y + (other.y - self.y) * t,
            z: self.z + (other.z - self.z) * t,
            w: self.w + (other.w - self.w) * t,
        }
    }
}

/// A point after the divide: x right and y up in -1..1, depth 1 (near) to 0 (far).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NdcPoint {
    /// -1 at the left border, 1 at the right.
    pub x: f64,
    /// -1 at the lower border, 1 at the upper.
    pub y: f64,
    /// Reversed depth.
    pub depth: f64,
}

/// A point in pixels, y down, origin at the top left corner of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenPoint {
    /// Pixels to the right of the left border.
    pub x: f64,
    /// Pixels below the upper border.
    pub y: f64,
    /// Reversed depth.
    pub depth: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Plane;

    #[track_caller]
    fn check(point: [f64; 4], expected: &[Plane]) {
        let [x, y, z, w] = point;
        let outside: Vec<_> = ClipPoint { x, y, z, w }.outcode().iter().collect();
        let expected: Vec<_> = expected.iter().map(|p| p.index()).collect();
        assert_eq!(outside, expected, "{point:?}");
    }

    #[test]
    fn outcodes_name_the_planes_a_point_is_outside_of() {
        check([0.0, 0.0, 0.5, 1.0], &[]);
        check([1.0, -1.0, 1.0, 1.0], &[]);
        check([-1.5, 0.0, 0.5, 1.0], &[Plane::Left]);
        check([1.5, 2.0, 0.5, 1.0], &[Plane::Right, Plane::Top]);
        check([0.0, -2.0, 2.0, 1.0], &[Plane::Bottom, Plane::Near]);
        check([0.0, 0.0, -0.1, 1.0], &[Plane::Far]);
        check([0.0, 0.0, 0.1, -1.0], &Plane::ALL[..5]);
        check([f64::NAN; 4], &[]);
    }

    #[test]
    fn lerp_ends_where_it_should() {
        let a = ClipPoint { x: 1.0, y: 2.0, z: 3.0, w: 4.0 };
        let b = ClipPoint { x: 3.0, y: 1.0, z: 0.0, w: 8.0 };
        assert_eq!(a.lerp(&b, 0.0), a);
        assert_eq!(a.lerp(&b, 1.0), b);
    }
}
