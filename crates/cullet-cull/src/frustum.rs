//! What a camera can see: six planes and the eight corners between them.
//!
//! Built from the camera's own numbers where there is a camera: subtracting the rows of a
//! rounded matrix loses the far plane (near 0.01, far 1000 is enough in f32), while
//! here every plane is one sum of two basis vectors. From a matrix, where that is all
//! there is, by [`Frustum::from_matrix`].
//!
//! Planes and corners count from [`Frustum::origin`], the eye: a box is moved there
//! before it is tested, in one rounding per coordinate, so a world 10^8 units from its zero
//! is as sharp as one around it.
//!
//! Each plane also knows the sizes of the terms it was summed from. From these,
//! [`Frustum::farthest`] and [`Frustum::nearest`] make one-sided answers: the normal
//! is an interval, the box is an interval, and interval arithmetic (Moore 1966) gives an end
//! that no rounding can overstep. A component that came out near zero by cancellation thus
//! has no sign to be wrong about.
//!
//! ```text
//!        6-------7     corner index: bit 0 right, bit 1 top, bit 2 far
//!        |\     /|
//!        | 2---3 |     2, 3, 0, 1 on the near plane
//!        | 0---1 |
//!        |/     \|
//!        4-------5     with infinite far: directions (w = 0)
//! ```
//!
//! Source: INFOGR lecture 6, the view frustum and its planes.

use cullet_transform::{Camera, Kind, Projection, Window};
use glam::{DMat3, DVec3, DVec4};

use crate::halfspace::{Halfspace, excludes, holds};
use crate::implied::{self, Row};
use crate::matrix::ExactRows;
use crate::number::Interval;
use crate::rounding::ROUNDING;
use crate::{Aabb, Plane};

/// The view volume of a camera; a closed set.
///
/// What it is made of can be read but not changed: planes, corners, bounds and the room for their
/// rounding belong together, and no test could promise anything otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    /// Where planes and corners count from, in the space of the boxes.
    pub(crate) origin: DVec3,
    /// See [`Frustum::planes`]. All below is derived together with these.
    pub(crate) planes: [Plane; 6],
    /// See [`Frustum::corners`].
    pub(crate) corners: [DVec4; 8],
    /// Per plane, the sizes of what its coefficients were summed from.
    pub(crate) terms: [Plane; 6],
    /// How far corners move with the planes; `None` where they are found anew instead.
    pub(crate) sway: Option<Sway>,
    /// Around all of the volume, as far as the slack lets planes move.
    pub(crate) bounds: Aabb,
    /// Relative allowance on each term, at least [`ROUNDING`].
    pub(crate) slack: f64,
    /// Per plane, the slack times the sizes of its terms.
    pub(crate) errors: [Plane; 6],
    /// What the planes were rounded from, if they came from a matrix.
    pub(crate) exact: Option<ExactRows>,
}

impl Frustum {
    /// The view volume of `camera` for pictures of `aspect` (width over height), in world
    /// space, counted from the eye.
    pub fn from_camera(camera: &Camera, aspect: f64) -> Frustum {
        let world_from_view = DMat3::from_cols(camera.right(), camera.up(), camera.back());
        // An angle given in degrees has lost up to 3 units of 2^-53 of itself on its way
        // here, which wide angles magnify: tan' = 1 + tan^2.
        let doubt = match camera.projection() {
            Projection::Perspective { yfov, .. } => {
                let tan = libm::tan(0.5 * yfov);
                1.5 * f64::EPSILON * 0.5 * yfov * (1.0 / tan + tan)
            }
            _ => 0.0,
        };
        Frustum::with_doubt(camera.eye(), &world_from_view, &camera.window(aspect), doubt)
    }

    /// The view volume through any `window`, such as one tile of a picture.
    ///
    /// `world_from_view` is a rotation: its columns are right, up and back. The window is
    /// not empty and its distances are in order, as `Projection::window` makes it.
    pub fn from_window(eye: DVec3, world_from_view: &DMat3, window: &Window) -> Frustum {
        Frustum::with_doubt(eye, world_from_view, window, 0.0)
    }

    /// With the borders of the window off by up to `doubt` of themselves.
    fn with_doubt(eye: DVec3, world_from_view: &DMat3, window: &Window, doubt: f64) -> Frustum {
        let scale = 1.0 + doubt / ROUNDING;
        let DMat3 { x_axis: right, y_axis: up, z_axis: back } = *world_from_view;
        let side = |axis: DVec3, edge: f64| match window.kind {
            Kind::Perspective => slanted(axis, back, edge, scale),
            Kind::Orthographic => upright(axis, -edge),
        };
        let planes_and_terms = [
            side(right, window.left),
            negated(side(right, window.right)),
            side(up, window.bottom),
            negated(side(up, window.top)),
            upright(-back, -window.near),
            if window.far.is_finite() { upright(back, window.far) } else { AT_INFINITY },
        ];
        let mut sway = Sway { corners: [DVec3::ZERO; 8], growth: 0.0 };
        let corners: [DVec4; 8] = core::array::from_fn(|i| {
            let x = if i & 1 == 0 { window.left } else { window.right };
            let y = if i & 2 == 0 { window.bottom } else { window.top };
            let z = if i & 4 == 0 { window.near } else { window.far };
            let lateral = right * x + up * y;
            let (x_terms, y_terms) = (scale * x.abs(), scale * y.abs());
            match window.kind {
                Kind::Perspective => {
                    // Of a corner at infinity, what there is per unit of depth.
                    let (z, w) = if z.is_infinite() { (1.0, 0.0) } else { (z, 1.0) };
                    let at = DVec3::new(x_terms * z, y_terms * z, z);
                    sway.add(i, world_from_view, at, [x_terms, y_terms]);
                    ((lateral - back) * z).extend(w)
                }
                Kind::Orthographic => {
                    let at = DVec3::new(x_terms, y_terms, z);
                    sway.add(i, world_from_view, at, [0.0; 2]);
                    (lateral - back * z).extend(1.0)
                }
            }
        });
        let frustum = Frustum {
            origin: eye,
            planes: planes_and_terms.map(|(plane, _)| plane),
            corners,
            terms: planes_and_terms.map(|(_, terms)| terms),
            sway: Some(sway),
            bounds: Aabb::INFINITE,
            slack: ROUNDING,
            errors: planes_and_terms.map(|(_, terms)| terms),
            exact: None,
        };
        frustum.outset(ROUNDING)
    }

    /// The same volume for boxes that already count from the eye: the origin becomes zero.
    #[must_use]
    pub fn relative_to_eye(&self) -> Frustum {
        Frustum { origin: DVec3::ZERO, ..*self }
    }

    /// The same volume with its planes moved outwards by `relative` times the sum of the sizes
    /// of the terms of each distance; less than [`ROUNDING`] counts as that.
    ///
    /// This is the margin of a renderer. Clip coordinates of a vertex are sums of the same
    /// terms as its distances to the planes, so a renderer whose numbers round to `u` and
    /// pass through `n` roundings gives `n * u`, and then never draws anything of a box that
    /// was excluded, nor clips by a plane that was not named. With the frustum of a camera, f64
    /// vertices (u = 2^-53) are covered without calling this, provided the box was made by
    /// [`Aabb::transformed`] with the matrix that takes the vertices to the eye's origin, whose
    /// own terms may be larger than their sum; f32 vertices ask for `64 * 2^-24`.
    ///
    /// [`Frustum::bounds`] holds all that the moved planes do. Where they may move so far that its
    /// corners are anywhere, it is infinite, and the reverse test keeps everything: for
    /// `64 * 2^-24` that takes a camera of some 179.9 degrees, or a matrix whose terms are so much
    /// larger than their sums, because the eye is far from the zero it counts from.
    #[must_use]
    pub fn outset(&self, relative: f64) -> Frustum {
        let slack = relative.max(ROUNDING);
        let error =
            |terms: Plane| Plane { normal: slack * terms.normal, offset: slack * terms.offset };
        let moved = Frustum { slack, errors: self.terms.map(error), ..*self };
        let bounds = match &self.sway {
            Some(sway) => sway.bounds(&self.corners, slack),
            None => moved.bounds_of_rows(),
        };
        Frustum { bounds, ..moved }
    }

    /// Where planes and corners count from, in the space of the boxes, scene units: the eye, or zero
    /// for a matrix.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Inward unit normals, counted from [`Frustum::origin`], in the order of `PlaneMask`: left,
    /// right, bottom, top, near, far. An infinite far plane has normal zero and offset `+inf`:
    /// everything is inside.
    pub fn planes(&self) -> &[Plane; 6] {
        &self.planes
    }

    /// The corners, counted from [`Frustum::origin`], rounded: points (`w = 1`), or with infinite far
    /// the last four are directions (`w = 0`, length of one unit of view depth): the corner in the
    /// limit along that direction. Where an oblique matrix tips the far plane over the horizon, or a
    /// matrix without inverse has no end, there are corners with `w = -1`: no points of the volume,
    /// which is open there.
    pub fn corners(&self) -> &[DVec4; 8] {
        &self.corners
    }

    /// Whether there is a far plane at a finite distance.
    pub fn has_far(&self) -> bool {
        self.planes[5].offset < f64::INFINITY && self.corners[7].w != 0.0
    }

    /// A box around all of the volume, counted from [`Frustum::origin`]; infinite where the
    /// volume is. Its faces lie outwards of the true ones by some hundred times the slack of what the
    /// corners were summed from, and at wide angles by the tangent of half the angle more: far less
    /// than 64 * 2^-24 of it, without an outset.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// No point of `bounds` is farther inside plane `index` than this, scene units: below zero
    /// is proof that the plane excludes the box.
    ///
    /// `bounds` counts from [`Frustum::origin`] and has no NaN. `0 * inf` is 0; NaN where
    /// infinities oppose.
    pub fn farthest(&self, index: usize, bounds: &Aabb) -> f64 {
        self.halfspace(index).farthest(bounds)
    }

    /// No point of `bounds` is farther outside plane `index` than this, as a signed distance:
    /// at or above zero is proof that the box lies wholly inside. Otherwise like
    /// [`Frustum::farthest`].
    pub fn nearest(&self, index: usize, bounds: &Aabb) -> f64 {
        self.halfspace(index).nearest(bounds)
    }

    /// Whether plane `index` excludes `bounds`: a proof like `farthest(index, bounds) < 0.0`, but
    /// quicker. The two may differ within the rounding that both allow for.
    #[inline(always)]
    pub fn excludes(&self, index: usize, bounds: &Aabb) -> bool {
        // Planes at infinity exclude nothing.
        self.planes[index].offset < f64::INFINITY
            && excludes(&self.planes[index], &self.errors[index], bounds)
    }

    /// Whether `bounds` lies wholly inside plane `index`: likewise like
    /// `nearest(index, bounds) >= 0.0`.
    #[inline(always)]
    pub fn holds(&self, index: usize, bounds: &Aabb) -> bool {
        self.planes[index].offset == f64::INFINITY
            || holds(&self.planes[index], &self.errors[index], bounds)
    }

    /// Plane `index`, give or take the slack.
    pub(crate) fn halfspace(&self, index: usize) -> Halfspace {
        Halfspace { plane: self.planes[index], error: self.errors[index] }
    }

    /// A box around all points that some planes of [`Frustum::rows`] hold: by the corners of these, if
    /// all are known to be where a frustum has them.
    fn bounds_of_rows(&self) -> Aabb {
        let mut rows = self.rows();
        for (row, plane) in rows.iter_mut().zip(&self.planes) {
            if plane.offset == f64::INFINITY {
                row[3].value = 1.0; // the same plane, with no product too large
            }
        }
        let Some(corners) = implied::all_corners(&rows) else { return Aabb::INFINITE };
        let corners = corners.map(implied::rounded);
        bounds_of(&corners.map(|(corner, _)| corner), &corners.map(|(_, error)| error))
    }

    /// All planes as rows, as certain as the slack says; one at infinity holds everywhere.
    pub(crate) fn rows(&self) -> [Row<Interval>; 6] {
        core::array::from_fn(|i| {
            let Halfspace { plane, error } = self.halfspace(i);
            let value = plane.normal.extend(plane.offset.min(f64::MAX));
            let error = error.normal.extend(error.offset);
            core::array::from_fn(|c| Interval { value: value[c], error: error[c] })
        })
    }
}

/// How far the corners of a camera's frustum move with its planes.
///
/// # Derivation
///
/// Planes moved by `r` of their terms hold a point `p` that the frustum does not. `p*` is `p` with
/// its depth brought between near and far, then its `x` and `y` between the edges there: a point of
/// the frustum. Of `p`, only sizes matter, `|p_k|` by world axis `k`; `R`, `U` and `B` are sums of
/// these over the axes that right, up and back are not exactly zero along. With `e` the edge
/// (of `x` or `y`, per unit of depth; an orthographic one does not depend on depth) and `z` the
/// depth of the face that `p*` was brought to, what the planes say is
///
/// ```text
/// dz <= r (B + z)
/// dx <= r (R + |e| B) + |e| dz          perspective
/// dx <= r (R + |e|)                     orthographic; likewise dy with U
/// ```
///
/// and along world axis `k`, `p` is away from `p*` by those of `dx`, `dy`, `dz` whose axis of
/// view is not zero there. With the sizes of `p*` in place of those of `p`, call that `r D(p*)`; it is
/// `r` times [`Sway::corners`] where `p*` is a corner. `D` is made of sums of sizes, which are
/// convex, so that `p*_k + r D_k` is greatest at a corner, or along its direction to infinity.
///
/// The sizes of `p` itself exceed those of `p*` by `r D(p)`. If `r D` never makes more than half of
/// `R`, `U` or `B` out of what it is given, then `D(p) <= 2 D(p*)` (the geometric series), and that
/// is what [`Sway::growth`] is for. One part more covers what planes and corners were rounded by, a
/// dozen units of 2^-53 against the 64 in every slack.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sway {
    /// Per corner, or direction: `D`, scene units.
    corners: [DVec3; 8],
    /// How much larger than `R`, `U` or `B` what `D` makes of them is, at most.
    growth: f64,
}

impl Sway {
    /// Corner `index`, whose view coordinates have sizes `at`. `edges`: of these, x and y per unit of
    /// depth; 0 for an orthographic one.
    fn add(&mut self, index: usize, world_from_view: &DMat3, at: DVec3, edges: [f64; 2]) {
        let DMat3 { x_axis, y_axis, z_axis } = *world_from_view;
        let axes = DMat3::from_cols(nonzero(x_axis), nonzero(y_axis), nonzero(z_axis));
        let sums = axes.transpose();
        let [x_edge, y_edge] = edges;
        let made = |of: DVec3, own: DVec3| {
            let dz = of.z + own.z;
            let dx = of.x + x_edge * (of.z + dz) + own.x;
            let dy = of.y + y_edge * (of.z + dz) + own.y;
            axes * DVec3::new(dx, dy, dz)
        };
        // What the offsets add that are no sums of coordinates.
        let own = DVec3::new(
            if x_edge == 0.0 { at.x } else { 0.0 },
            if y_edge == 0.0 { at.y } else { 0.0 },
            at.z,
        );
        let of = sums * (axes * at);
        self.corners[index] = made(of, own);
        let again = sums * self.corners[index];
        for axis in 0..3 {
            if again[axis] > 0.0 {
                self.growth = self.growth.max(again[axis] / of[axis]);
            }
        }
    }

    /// A box around all points that the planes may hold, moved by `slack` of their terms.
    fn bounds(&self, corners: &[DVec4; 8], slack: f64) -> Aabb {
        let stays = slack * self.growth <= 0.5; // false for NaN
        if !stays {
            return Aabb::INFINITE;
        }
        bounds_of(corners, &self.corners.map(|sway| 3.0 * slack * sway))
    }
}

/// The least box around corners that may be off by `errors`, the half-lines from the points along
/// the directions included. Without bounds if some corner is neither.
pub(crate) fn bounds_of(corners: &[DVec4; 8], errors: &[DVec3; 8]) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    let mut open = DVec3::ZERO..DVec3::ZERO;
    for (corner, error) in corners.iter().zip(errors) {
        let (low, high) = (corner.truncate() - error, corner.truncate() + error);
        if corner.w > 0.0 {
            bounds = Aabb { min: bounds.min.min(low), max: bounds.max.max(high) };
        } else if corner.w == 0.0 {
            open = open.start.min(low)..open.end.max(high);
        } else {
            return Aabb::INFINITE;
        }
    }
    Aabb {
        min: DVec3::select(open.start.cmplt(DVec3::ZERO), DVec3::NEG_INFINITY, bounds.min),
        max: DVec3::select(open.end.cmpgt(DVec3::ZERO), DVec3::INFINITY, bounds.max),
    }
}

pub(crate) const AT_INFINITY: (Plane, Plane) = (
    Plane { normal: DVec3::ZERO, offset: f64::INFINITY },
    Plane { normal: DVec3::ZERO, offset: 0.0 },
);

/// The plane `axis · p >= -offset`, and its terms.
fn upright(axis: DVec3, offset: f64) -> (Plane, Plane) {
    (Plane { normal: axis, offset }, Plane { normal: nonzero(axis), offset: offset.abs() })
}

/// The plane through the eye that holds all points with `axis · p >= edge * depth`, where
/// depth is `-back · p`; and its terms, those of the edge times `scale`.
fn slanted(axis: DVec3, back: DVec3, edge: f64, scale: f64) -> (Plane, Plane) {
    let length = libm::hypot(1.0, edge);
    let (cos, sin) = (1.0 / length, edge / length);
    (
        Plane { normal: axis * cos + back * sin, offset: 0.0 },
        Plane { normal: nonzero(axis) * cos + nonzero(back) * (scale * sin.abs()), offset: 0.0 },
    )
}

fn negated((plane, terms): (Plane, Plane)) -> (Plane, Plane) {
    (-plane, terms)
}

/// One for each component that is not exactly zero. A component of a rotation is off by
/// rounding of numbers around one, however small it came out; but an exact zero is meant,
/// and keeps an infinite box off the planes parallel to it.
fn nonzero(v: DVec3) -> DVec3 {
    DVec3::select(v.cmpeq(DVec3::ZERO), DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use cullet_transform::Projection;
    use glam::{DMat4, DQuat};

    use super::*;
    use crate::DepthRange;
    use crate::distributions::Rng;

    /// Along an axis, half of the time.
    fn direction(random: &mut Rng) -> DVec3 {
        let axis = DVec3::AXES[random.within(0.0, 3.0) as usize];
        let any = random.point(DVec3::splat(-0.5), DVec3::splat(0.5));
        match random.within(0.0, 4.0) as usize {
            0 => axis,
            1 => -axis,
            _ => any.normalize_or(axis),
        }
    }

    fn rotation(random: &mut Rng) -> DMat3 {
        let (axis, angle) = (direction(random), random.within(0.0, 6.0));
        DMat3::from_quat(DQuat::from_axis_angle(axis, angle))
    }

    fn window(kind: Kind, far: f64) -> Window {
        Window { kind, left: -2.0, right: 1.0, bottom: -0.5, top: 0.75, near: 0.5, far }
    }

    /// A rotation without roundings.
    fn sideways() -> DMat3 {
        DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y)
    }

    #[test]
    fn corners_lie_on_their_planes() {
        for (kind, far) in [
            (Kind::Perspective, 8.0),
            (Kind::Perspective, f64::INFINITY),
            (Kind::Orthographic, 8.0),
        ] {
            let frustum = Frustum::from_window(DVec3::ONE, &sideways(), &window(kind, far));
            assert_eq!(frustum.has_far(), far.is_finite());
            for (i, corner) in frustum.corners.iter().enumerate() {
                let on = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)];
                for (p, plane) in frustum.planes.iter().enumerate() {
                    let distance = if corner.w == 0.0 {
                        plane.normal.dot(corner.truncate())
                    } else {
                        plane.distance(corner.truncate())
                    };
                    if on.contains(&p) {
                        let at_infinity = p == 5 && far.is_infinite();
                        assert!(at_infinity || distance.abs() < 1e-14, "{i} {p} {distance}");
                    } else {
                        assert!(distance > 0.1 || corner.w == 0.0, "{i} {p} {distance}");
                    }
                }
            }
        }
    }

    #[test]
    fn planes_face_inward_with_unit_normals() {
        let projection = Projection::Perspective { yfov: 1.0, near: 0.1, far: 100.0 };
        let eye = DVec3::new(1e7, 3.0, -1e7);
        let target = eye + DVec3::new(1.0, 2.0, 3.0);
        let camera = Camera::look_at(eye, target, DVec3::Y, projection).unwrap();
        let frustum = Frustum::from_camera(&camera, 16.0 / 9.0);
        for plane in &frustum.planes {
            assert!((plane.normal.length() - 1.0).abs() < 1e-15);
            assert!(plane.distance(target - frustum.origin) > 0.0);
        }
        assert_eq!(frustum.origin, eye);
        assert_eq!(frustum.relative_to_eye().origin, DVec3::ZERO);
        assert_eq!(frustum.relative_to_eye().planes, frustum.planes);
    }

    #[test]
    fn the_ends_enclose_the_distances_of_all_corners() {
        let frustum =
            Frustum::from_window(DVec3::ZERO, &sideways(), &window(Kind::Perspective, 9.0));
        let bounds = Aabb { min: DVec3::new(-1.0, -7.0, 0.3), max: DVec3::new(2.0, 1e6, 0.4) };
        for (i, plane) in frustum.planes.iter().enumerate() {
            for corner in bounds.corners() {
                let distance = plane.distance(corner);
                assert!(frustum.nearest(i, &bounds) <= distance);
                assert!(distance <= frustum.farthest(i, &bounds));
            }
        }
    }

    /// What the planes of an outset keep, its bounds hold: reverse rejects no point that they keep.
    #[track_caller]
    fn bounds_hold_what_the_planes_do(frustum: &Frustum, slack: f64, random: &mut Rng) {
        let wide = frustum.outset(slack);
        let mut n_points = 0;
        let points = wide.corners.iter().filter(|corner| corner.w > 0.0);
        for corner in points.map(|corner| corner.truncate()) {
            for _ in 0..24 {
                // As far from the corner as the planes allow, along some direction.
                let along = direction(random);
                let keeps = |distance: f64| {
                    let p = corner + distance * along;
                    let bounds = Aabb { min: p, max: p };
                    let kept = !(0..6).any(|i| wide.farthest(i, &bounds) < 0.0);
                    assert!(
                        !kept || wide.bounds().contains_point(p),
                        "{along} {distance} {wide:?}"
                    );
                    kept
                };
                let (mut low, mut high) = (0.0, 2.0 * corner.length());
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if keeps(middle) {
                        (low, n_points) = (middle, n_points + 1);
                    } else {
                        high = middle;
                    }
                }
            }
        }
        assert!(n_points > 0 || frustum.corners.iter().all(|corner| corner.w <= 0.0));
    }

    const SLACKS: [f64; 4] = [0.0, 64.0 / (1 << 24) as f64, 1e-3, 0.02];

    fn lens(fov: f64, far: f64) -> Window {
        let edge = libm::tan(0.5 * fov.to_radians());
        let (left, right, bottom, top) = (-edge, edge, -0.5 * edge, 0.01 * edge);
        Window { kind: Kind::Perspective, left, right, bottom, top, near: 1.0, far }
    }

    #[test]
    fn the_bounds_of_a_camera_hold_what_its_outset_planes_do() {
        let mut random = Rng(1);
        let turns = [DMat3::IDENTITY, DMat3::from_rotation_z(0.3), DMat3::from_rotation_y(0.3)];
        for round in 0..300 {
            let rotation = match round % 5 {
                turn @ 0..3 => turns[turn],
                // Level sides of a rolled picture: right and up share a plane with two axes.
                3 => {
                    DMat3::from_rotation_x(random.within(0.0, 1.0))
                        * DMat3::from_rotation_z(random.within(0.0, 1.0))
                }
                _ => rotation(&mut random),
            };
            let far = [2.0, 1e4, f64::INFINITY][round % 3];
            let fov = [0.1, 2.0, 60.0, 120.0, 170.0, 179.0, 179.99][round % 7];
            let mut window = lens(fov, far);
            if round % 4 == 0 && far.is_finite() {
                window.kind = Kind::Orthographic;
            }
            let frustum = Frustum::from_window(DVec3::ZERO, &rotation, &window);
            for slack in SLACKS {
                bounds_hold_what_the_planes_do(&frustum, slack, &mut random);
            }
        }
    }

    #[test]
    fn the_bounds_of_a_matrix_hold_what_its_outset_planes_do() {
        let mut random = Rng(2);
        let mut n_bounded = 0;
        for round in 0..300 {
            let offset = [0.0, 1.0, 1e2, 1e4][round % 4];
            let eye = if round == 1 {
                DVec3::new(10.0, 20.0, 70.0)
            } else {
                offset * direction(&mut random)
            };
            let rotation = if round % 3 == 0 { DMat3::IDENTITY } else { rotation(&mut random) };
            let far = [2.0, 1e4, f64::INFINITY][round % 3];
            let fov = [1.0, 60.0, 120.0, 170.0, 179.0][round % 5];
            let view = DMat4::from_mat3(rotation.transpose()) * DMat4::from_translation(-eye);
            let matrix = (lens(fov, far).clip_from_view() * view).as_mat4().as_dmat4();
            let frustum = Frustum::from_matrix(&matrix, DepthRange::Reversed).expect("a frustum");
            for slack in SLACKS {
                bounds_hold_what_the_planes_do(&frustum, slack, &mut random);
            }
            n_bounded += usize::from(frustum.outset(SLACKS[1]).bounds() != Aabb::INFINITE);
        }
        assert!(n_bounded > 100, "{n_bounded}");
    }

    #[test]
    fn an_outset_of_an_ordinary_camera_is_no_larger_than_it_need_be() {
        let frustum = Frustum::from_window(DVec3::ZERO, &rotation(&mut Rng(3)), &lens(60.0, 100.0));
        let (bounds, wide) = (frustum.bounds(), frustum.outset(SLACKS[1]).bounds());
        assert!(bounds.grown(0.1).contains(&wide), "{bounds:?} {wide:?}");
        assert!(wide.contains(&bounds));
    }

    #[test]
    fn an_outset_moves_planes_by_their_terms() {
        let frustum =
            Frustum::from_window(DVec3::ZERO, &sideways(), &window(Kind::Orthographic, 9.0));
        let point = Aabb { min: DVec3::splat(4.0), max: DVec3::splat(4.0) };
        let wide = frustum.outset(0.125);
        // Near: depth -4 against 0.5; far: -4 against 9.
        assert_eq!(wide.farthest(4, &point), -4.5 + 0.125 * 4.5);
        assert_eq!(wide.nearest(5, &point), 13.0 - 0.125 * 13.0);
        assert_eq!(frustum.outset(0.0).farthest(4, &point), frustum.farthest(4, &point));
        assert_eq!(frustum.outset(f64::NAN).farthest(4, &point), frustum.farthest(4, &point));
    }
}
