//! A triangle as geometry has it: no clipping, no grid, no cases.
//!
//! A pixel's ray meets a triangle where it is a combination of the three corners with weights
//! of one sign (Olano and Greer 1997 read it the other way round): three volumes of the eye, two
//! corners and the ray. Each volume is linear over the picture, so its value over its slope is
//! the distance to that edge in pixels, and the near and far planes are two edges more.

use cullet::transform::{Kind, View};
use cullet::{Camera, Pass, Passes, Settings};
use cullet_tests::render;
use glam::{DAffine3, DVec3, Vec3};

use crate::{INF, alone, mesh, view};

/// How far from an ideal edge a pixel may be told wrongly, px.
pub const EDGE: f64 = 0.004;

/// A triangle on its way to the screen.
pub struct Ideal {
    /// Pixels right of and below the middle of the picture, times `w`; `w`.
    pub corners: [DVec3; 3],
    pub near: f64,
    pub far: f64,
    middle: [f64; 2],
}

/// What a pixel centre sees of the plane of a triangle.
pub struct Place {
    pub inside: bool,
    /// Distance to the nearest border line, px.
    pub border: f64,
    /// Perspective-correct.
    pub weights: DVec3,
    /// `w`: distance along the axis of a perspective camera.
    pub w: f64,
}

impl Ideal {
    /// For symmetric lenses.
    pub fn new(view: &View, world_from_model: &DAffine3, corners: [Vec3; 3]) -> Self {
        let (camera, window) = (view.camera(), view.window());
        let (width, height) =
            (f64::from(view.viewport().width()), f64::from(view.viewport().height()));
        let is_perspective = window.kind == Kind::Perspective;
        let shift = world_from_model.translation - camera.eye();
        let corners = corners.map(|p| {
            let p = world_from_model.matrix3 * p.as_dvec3() + shift;
            let x = p.dot(camera.right()) * (width / (window.right - window.left));
            let y = p.dot(camera.up()) * (height / (window.top - window.bottom));
            DVec3::new(x, -y, if is_perspective { -p.dot(camera.back()) } else { 1.0 })
        });
        let (near, far) = if is_perspective { (window.near, window.far) } else { (0.0, INF) };
        Ideal { corners, near, far, middle: [0.5 * width, 0.5 * height] }
    }

    pub fn at(&self, x: u32, y: u32) -> Place {
        let [a, b, c] = self.corners;
        let edges = [b.cross(c), c.cross(a), a.cross(b)];
        let volume = a.dot(edges[0]);
        let sign = volume.signum();
        let ray = DVec3::new(
            f64::from(x) + 0.5 - self.middle[0],
            f64::from(y) + 0.5 - self.middle[1],
            1.0,
        );
        let shares = DVec3::from_array(edges.map(|edge| edge.dot(ray))) * sign;
        let plane = (edges[0] + edges[1] + edges[2]) * sign;
        let (sum, volume) = (plane.dot(ray), volume * sign);
        let mut place =
            Place { inside: volume > 0.0, border: INF, weights: shares / sum, w: volume / sum };
        let slope = |edge: DVec3| edge.truncate().length();
        let borders = [
            (shares.x, slope(edges[0])),
            (shares.y, slope(edges[1])),
            (shares.z, slope(edges[2])),
            (volume - sum * self.near, slope(plane * self.near)),
            if self.far < INF {
                (sum * self.far - volume, slope(plane * self.far))
            } else {
                (INF, 1.0)
            },
        ];
        for (value, slope) in borders {
            place.inside &= value >= 0.0;
            let distance = if value == 0.0 { 0.0 } else { value.abs() / slope };
            place.border = place.border.min(distance);
        }
        place
    }
}

/// Draws one triangle and compares every pixel farther than [`EDGE`] from the ideal border.
/// Returns how many pixels show it.
#[track_caller]
pub fn check(camera: &Camera, size: [u32; 2], place: DAffine3, corners: [Vec3; 3]) -> usize {
    let prepared = alone(mesh(&corners, &[[0, 1, 2]]), place);
    let settings =
        Settings { passes: Passes::NONE.with(Pass::Triangle), threads: 1, ..Settings::default() };
    let frame = render(&prepared, camera, size, &settings);
    let ideal = Ideal::new(&view(camera, size), &place, corners);
    for (i, &id) in frame.triangle.iter().enumerate() {
        let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
        let expected = ideal.at(x, y);
        assert!(
            (id == 1) == expected.inside || expected.border <= EDGE,
            "pixel {x}, {y} of {corners:?}: {id}, but {:.5} px from the border; {camera:?}",
            expected.border
        );
    }
    frame.triangle.iter().filter(|&&id| id == 1).count()
}
