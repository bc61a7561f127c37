//! Cameras: a place, a direction, a lens. Constructors refuse every camera that can make no
//! picture, so nothing after them has to check.

use glam::{DAffine3, DMat4, DVec3, DVec4};

/// Why a camera cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// NaN or infinity where a finite number is needed.
    #[error("camera: {what} must be finite")]
    NotFinite {
        /// Which value.
        what: &'static str,
    },
    /// Field of view outside (0, π).
    #[error(
        "camera: the vertical field of view is {degrees} degrees; it must lie between 0 and 180, both excluded"
    )]
    FieldOfView {
        /// The offending value.
        degrees: f64,
    },
    /// A perspective near distance <= 0, or an orthographic one < 0.
    #[error("camera: the near distance is {near}; it must be {}", if *.perspective { "greater than 0" } else { "at least 0" })]
    Near {
        /// The offending value.
        near: f64,
        /// Which lens.
        perspective: bool,
    },
    /// `near >= far`, or far NaN, or an orthographic far at infinity.
    #[error("camera: the far distance is {far} with near {near}; it must be greater than near{}", if *.perspective { "" } else { " and finite" })]
    Far {
        /// Near distance.
        near: f64,
        /// The offending value.
        far: f64,
        /// Which lens.
        perspective: bool,
    },
    /// A view rectangle without area.
    #[error("camera: the view is {width} wide and {height} high; both must be greater than 0")]
    Window {
        /// Width of the rectangle.
        width: f64,
        /// Height of the rectangle.
        height: f64,
    },
    /// Eye and target are the same point.
    #[error("camera: eye and target are the same point")]
    NoDirection,
    /// The up vector is zero or parallel to the view direction.
    #[error("camera: the up vector is zero or parallel to the view direction")]
    NoUp,
}

/// The two families of lenses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Lines meet at the eye.
    Perspective,
    /// Lines stay parallel.
    Orthographic,
}

/// What part of the world in front of the eye is in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Which family.
    pub kind: Kind,
    /// Left border: at unit distance along the view axis (perspective), or in scene units.
    pub left: f64,
    /// Right border, greater than `left`.
    pub right: f64,
    /// Lower border.
    pub bottom: f64,
    /// Upper border, greater than `bottom`.
    pub top: f64,
    /// Distance to the near plane, scene units.
    pub near: f64,
    /// Distance to the far plane, scene units; may be infinite for perspective.
    pub far: f64,
}

impl Window {
    /// The view-space point at `distance` along the view axis that is seen `u` of the way from
    /// the left border to the right one and `v` of the way from the upper border to the lower.
    pub fn at(&self, u: f64, v: f64, distance: f64) -> DVec3 {
        let x = self.left + (self.right - self.left) * u;
        let y = self.top + (self.bottom - self.top) * v;
        match self.kind {
            Kind::Perspective => DVec3::new(x * distance, y * distance, -distance),
            Kind::Orthographic => DVec3::new(x, y, -distance),
        }
    }

    /// The matrix from view space to clip space (see the convention table): reversed depth,
    /// infinite far as the limit of finite far, so that no plane is computed by subtracting
    /// nearly equal numbers. Source: the off-centre frustum of the OpenGL specification,
    /// appendix on matrices; reversed infinite depth: Upchurch & Desbrun 2012, Reed 2015.
    pub fn clip_from_view(&self) -> DMat4 {
        let (width, height) = (self.right - self.left, self.top - self.bottom);
        let (x_shift, y_shift) =
            ((self.right + self.left) / width, (self.top + self.bottom) / height);
        let depth = self.far - self.near;
        match self.kind {
            Kind::Perspective => {
                // depth(d) = near (far - d) / ((far - near) d), near / d in the limit
                let (z_scale, z_shift) = if self.far.is_infinite() {
                    (0.0, self.near)
                } else {
                    (self.near / depth, self.near * (self.far / depth))
                };
                DMat4::from_cols(
                    DVec4::new(2.0 / width, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, 2.0 / height, 0.0, 0.0),
                    DVec4::new(x_shift, y_shift, z_scale, -1.0),
                    DVec4::new(0.0, 0.0, z_shift, 0.0),
                )
            }
            Kind::Orthographic => DMat4::from_cols(
                DVec4::new(2.0 / width, 0.0, 0.0, 0.0),
                DVec4::new(0.0, 2.0 / height, 0.0, 0.0),
                DVec4::new(0.0, 0.0, 1.0 / depth, 0.0),
                DVec4::new(-x_shift, -y_shift, self.far / depth, 1.0),
            ),
        }
    }
}

/// A lens. The width of the symmetric ones follows from the picture's aspect ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Symmetric perspective.
    Perspective {
        /// Vertical field of view, radians, in (0, π).
        yfov: f64,
        /// Near distance, > 0.
        near: f64,
        /// Far distance, > near, may be infinite.
        far: f64,
    },
    /// Symmetric orthographic.
    Orthographic {
        /// Height of the view in scene units, > 0.
        height: f64,
        /// Near distance, >= 0.
        near: f64,
        /// Far distance, > near, finite.
        far: f64,
    },
    /// Any window, off-centre or not, whatever the picture's aspect ratio.
    OffCentre(Window),
}

impl Projection {
    /// The window for a picture `aspect` times as wide as high.
    fn window(&self, aspect: f64) -> Window {
        let symmetric = |kind, half_height: f64, near, far| {
            let half_width = half_height * aspect;
            let (left, bottom) = (-half_width, -half_height);
            Window { kind, left, right: half_width, bottom, top: half_height, near, far }
        };
        match *self {
            Projection::Perspective { yfov, near, far } => {
                symmetric(Kind::Perspective, libm::tan(0.5 * yfov), near, far)
            }
            Projection::Orthographic { height, near, far } => {
                symmetric(Kind::Orthographic, 0.5 * height, near, far)
            }
            Projection::OffCentre(window) => window,
        }
    }

    fn check(&self) -> Result<(), CameraError> {
        if let Projection::Perspective { yfov, .. } = *self
            && !(yfov > 0.0 && yfov < core::f64::consts::PI)
        {
            return Err(CameraError::FieldOfView { degrees: yfov.to_degrees() });
        }
        let Window { kind, left, right, bottom, top, near, far } = self.window(1.0);
        let perspective = kind == Kind::Perspective;
        if !(near > 0.0 || (near == 0.0 && !perspective)) || near.is_infinite() {
            return Err(CameraError::Near { near, perspective });
        }
        if !(far > near && (perspective || far.is_finite())) {
            return Err(CameraError::Far { near, far, perspective });
        }
        let (width, height) = (right - left, top - bottom);
        let finite = width.is_finite() && height.is_finite();
        if !(finite && width > 0.0 && height > 0.0) {
            return Err(CameraError::Window { width, height });
        }
        Ok(())
    }
}

/// A camera that can make a picture: finite eye, orthonormal axes, a sound lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    back: DVec3,
    projection: Projection,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` somewhere above it (all in world
    /// space). Neither the distance of the target nor the length of `up` matters.
    pub fn look_at(
        eye: DVec3,
        target: DVec3,
        up: DVec3,
        projection: Projection,
    ) -> Result<Self, CameraError> {
        if !eye.is_finite() {
            return Err(CameraError::NotFinite { what: "eye" });
        }
        if !target.is_finite() {
            return Err(CameraError::NotFinite { what: "target" });
        }
        Camera::look_along(eye, difference(eye * 0.5, target * 0.5), up, projection)
    }

    /// The camera of a node: it sits at the node's origin and looks down the node's -z, with
    /// the node's y up. Scale and shear of the node do not change the lens.
    pub fn from_node(
        world_from_camera: &DAffine3,
        projection: Projection,
    ) -> Result<Self, CameraError> {
        let matrix = world_from_camera.matrix3;
        let back = (matrix.z_axis, DVec3::ZERO);
        Camera::look_along(world_from_camera.translation, back, matrix.y_axis, projection)
    }

    /// `back` is the sum of two vectors, of any length.
    fn look_along(
        eye: DVec3,
        back: (DVec3, DVec3),
        up: DVec3,
        projection: Projection,
    ) -> Result<Self, CameraError> {
        if !eye.is_finite() {
            return Err(CameraError::NotFinite { what: "eye" });
        }
        projection.check()?;
        let scale = power_of_two(back.0).ok_or(CameraError::NoDirection)?;
        let (back, rest) = (back.0 * scale, back.1 * scale);
        let up = up * power_of_two(up).ok_or(CameraError::NoUp)?;
        // Where the two are almost parallel little is left of the products: each must be exact,
        // and so must be the difference of eye and target.
        let right = cross(up, back) + up.cross(rest);
        // Sine of the angle between the two; below this, rounding alone decides where up is.
        if right.length() < 1e-12 * up.length() * back.length() {
            return Err(CameraError::NoUp);
        }
        let back = unit(back).ok_or(CameraError::NoDirection)?;
        let right = unit(right).ok_or(CameraError::NoUp)?;
        Ok(Camera { eye, right, up: cross(back, right), back, projection })
    }

    /// Where the camera is, world space.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Unit vector to the right of the picture, world space.
    pub fn right(&self) -> DVec3 {
        self.right
    }

    /// Unit vector to the top of the picture, world space.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// Unit vector from the scene to the eye: against the view direction, world space.
    pub fn back(&self) -> DVec3 {
        self.back
    }

    /// The lens as given.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// What part of the world is in a picture `aspect` times as wide as high.
    pub fn window(&self, aspect: f64) -> Window {
        self.projection.window(aspect)
    }

    /// The same camera looking through a part or a multiple of one of its own windows.
    pub(crate) fn through(&self, window: Window) -> Camera {
        Camera { projection: Projection::OffCentre(window), ..*self }
    }
}

/// `a - b` as a rounded difference and what its rounding dropped (Knuth 1969).
fn difference(a: DVec3, b: DVec3) -> (DVec3, DVec3) {
    let difference = a - b;
    let back = difference - a;
    (difference, (a - (difference - back)) - (b + back))
}

/// The cross product, each component within 2 ulp, zero only if it is zero: the difference of two
/// products with what their roundings dropped (Kahan; Jeannerod, Louvet and Muller 2013).
fn cross(a: DVec3, b: DVec3) -> DVec3 {
    let component = |a1: f64, b2: f64, a2: f64, b1: f64| {
        let dropped = a2 * b1;
        let error = libm::fma(-a2, b1, dropped);
        libm::fma(a1, b2, -dropped) + error
    };
    DVec3::new(
        component(a.y, b.z, a.z, b.y),
        component(a.z, b.x, a.x, b.z),
        component(a.x, b.y, a.y, b.x),
    )
}

/// A power of two that brings the largest component of `v` near 1, or `None` for zero and for what
/// is not finite.
fn power_of_two(v: DVec3) -> Option<f64> {
    let largest = v.abs().max_element();
    let (_, exponent) = libm::frexp(largest);
    (largest > 0.0 && v.is_finite()).then(|| libm::scalbn(1.0, -exponent.clamp(-1022, 1022)))
}

/// `v` at length 1, or `None` for zero and for what is not finite. Scales first, so that
/// neither 1e-300 nor 1e300 under- or overflows.
fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    if !(largest > 0.0 && v.is_finite()) {
        return None;
    }
    let scaled = v / largest;
    Some(scaled / libm::sqrt(scaled.dot(scaled)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ClipPoint;

    const LENS: Projection = Projection::Perspective { yfov: 1.0, near: 0.1, far: f64::INFINITY };

    fn with(projection: Projection) -> Result<Camera, CameraError> {
        Camera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y, projection)
    }

    fn perspective(degrees: f64, near: f64, far: f64) -> Result<Camera, CameraError> {
        with(Projection::Perspective { yfov: degrees.to_radians(), near, far })
    }

    #[test]
    fn axes_are_right_handed() {
        let camera = with(LENS).unwrap();
        assert_eq!((camera.right(), camera.up(), camera.back()), (DVec3::X, DVec3::Y, DVec3::Z));
    }

    #[test]
    fn possible_lenses() {
        for degrees in [1e-3, 45.0, 179.0, 179.99] {
            assert!(perspective(degrees, 1e-6, 1e12).is_ok(), "{degrees}");
        }
        assert!(perspective(60.0, 1e-6, f64::INFINITY).is_ok());
        assert!(with(Projection::Orthographic { height: 2.0, near: 0.0, far: 9.0 }).is_ok());
    }

    #[test]
    fn impossible_lenses_are_errors() {
        for degrees in [0.0, -5.0, 180.0, 270.0, f64::NAN, f64::INFINITY] {
            let error = perspective(degrees, 0.1, 10.0).unwrap_err();
            assert!(matches!(error, CameraError::FieldOfView { .. }), "{degrees}");
        }
        for near in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = perspective(45.0, near, f64::INFINITY).unwrap_err();
            assert!(matches!(error, CameraError::Near { .. }), "{near}");
        }
        for far in [0.1, 0.05, f64::NAN, f64::NEG_INFINITY] {
            let error = perspective(45.0, 0.1, far).unwrap_err();
            assert!(matches!(error, CameraError::Far { .. }), "{far}");
        }
        for (height, near, far) in
            [(0.0, 0.1, 1.0), (-1.0, 0.1, 1.0), (f64::NAN, 0.1, 1.0), (f64::INFINITY, 0.1, 1.0)]
        {
            let error = with(Projection::Orthographic { height, near, far }).unwrap_err();
            assert!(matches!(error, CameraError::Window { .. }), "{height}");
        }
        for (near, far) in [(0.0, f64::INFINITY), (-1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0)] {
            assert!(with(Projection::Orthographic { height: 1.0, near, far }).is_err());
        }
    }

    #[test]
    fn impossible_places_are_errors() {
        let at = |eye, target, up| Camera::look_at(eye, target, up, LENS);
        let (o, x, y) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        assert_eq!(at(o, o, y), Err(CameraError::NoDirection));
        assert_eq!(at(o, y, y), Err(CameraError::NoUp));
        assert_eq!(at(o, -y * 3.0, y), Err(CameraError::NoUp));
        assert_eq!(at(o, x, o), Err(CameraError::NoUp));
        assert_eq!(at(o, x, DVec3::NAN), Err(CameraError::NoUp));
        assert_eq!(at(DVec3::NAN, x, y), Err(CameraError::NotFinite { what: "eye" }));
        let far = DVec3::splat(f64::INFINITY);
        assert_eq!(at(o, far, y), Err(CameraError::NotFinite { what: "target" }));
    }

    #[test]
    fn extreme_places_keep_unit_axes() {
        for scale in [1e-300, 1e-30, 1.0, 1e30, 1e300] {
            let eye = DVec3::new(1.0, -2.0, 3.0) * scale;
            let camera = Camera::look_at(eye, -eye, DVec3::Y * scale, LENS).unwrap();
            for axis in [camera.right(), camera.up(), camera.back()] {
                assert!((axis.length() - 1.0).abs() < 1e-15, "{scale}");
            }
        }
    }

    #[test]
    fn depth_is_one_at_near_and_zero_at_far() {
        let lenses = [
            Projection::Perspective { yfov: 1.0, near: 0.5, far: 200.0 },
            Projection::Orthographic { height: 3.0, near: 0.5, far: 200.0 },
        ];
        for lens in lenses {
            let clip_from_view = lens.window(1.5).clip_from_view();
            let depth = |d: f64| {
                let p = ClipPoint::from_model(&clip_from_view, DVec3::new(0.0, 0.0, -d));
                p.ndc().depth
            };
            assert!((depth(0.5) - 1.0).abs() < 1e-15);
            assert!(depth(200.0).abs() < 1e-15);
            assert!(depth(1.0) > depth(2.0));
        }
        let infinite = LENS.window(1.0).clip_from_view();
        let p = ClipPoint::from_model(&infinite, DVec3::new(0.0, 0.0, -0.1));
        assert_eq!((p.z, p.w), (0.1, 0.1));
    }

    #[test]
    fn off_centre_windows_put_their_borders_on_the_picture_borders() {
        for kind in [Kind::Perspective, Kind::Orthographic] {
            let (left, right, bottom, top) = (-0.25, 1.0, 0.5, 2.0);
            let window = Window { kind, left, right, bottom, top, near: 1.0, far: 4.0 };
            let clip_from_view = Projection::OffCentre(window).window(7.0).clip_from_view();
            let ndc = |x, y| ClipPoint::from_model(&clip_from_view, DVec3::new(x, y, -1.0)).ndc();
            assert!((ndc(left, bottom).x + 1.0).abs() < 1e-15);
            assert!((ndc(left, bottom).y + 1.0).abs() < 1e-15);
            assert!((ndc(right, top).x - 1.0).abs() < 1e-15);
            assert!((ndc(right, top).y - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_camera_of_a_scaled_node_keeps_its_lens() {
        let node = DAffine3::from_scale(DVec3::new(2.0, 3.0, 0.5));
        let camera = Camera::from_node(&node, LENS).unwrap();
        assert_eq!((camera.right(), camera.up(), camera.back()), (DVec3::X, DVec3::Y, DVec3::Z));
        assert!(Camera::from_node(&DAffine3::from_scale(DVec3::ZERO), LENS).is_err());
    }
}
