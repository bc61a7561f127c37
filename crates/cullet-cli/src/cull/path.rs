//! Cameras one after the other: `--path`.

use std::path::PathBuf;
use std::str::FromStr;

use cullet::cull::Aabb;
use cullet::{Camera, Projection};
use glam::{DMat3, DVec3};

/// A way for the camera to go.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraPath {
    /// Around the vertical line through the middle of the boxes, in `n` equal steps.
    Orbit {
        /// How many cameras.
        n: u32,
        /// Distance of the eye from the middle, as a multiple of where `--camera` has it.
        distance: f64,
    },
    /// Straight on, from where `--camera` stands until all lies behind it.
    Dolly {
        /// How many cameras.
        n: u32,
    },
    /// The cameras of a file.
    File(PathBuf),
}

/// Cameras of a dolly when it does not say.
const DOLLY: u32 = 32;
/// More are surely a slip of the finger.
const MOST: u32 = 100_000;

impl CameraPath {
    /// How many cameras it names; 0 for a file, which knows itself.
    pub fn len(&self) -> usize {
        match self {
            CameraPath::Orbit { n, .. } | CameraPath::Dolly { n } => *n as usize,
            CameraPath::File(_) => 0,
        }
    }
}

impl FromStr for CameraPath {
    type Err = String;

    fn from_str(text: &str) -> Result<CameraPath, String> {
        let mut words = text.split(':');
        let first = words.next();
        let rest: Vec<&str> = words.collect();
        let count = |word: &str| {
            let n = word.parse().ok().filter(|n| (1..=MOST).contains(n));
            n.ok_or_else(|| format!("`{word}` is no number of cameras from 1 to {MOST}"))
        };
        match (first, &rest[..]) {
            (Some("orbit"), [n]) => Ok(CameraPath::Orbit { n: count(n)?, distance: 1.0 }),
            (Some("orbit"), [n, distance]) => {
                let positive = |value: &f64| *value > 0.0 && value.is_finite();
                let parsed = distance.parse().ok().filter(positive);
                let distance = parsed.ok_or(format!("`{distance}` is no distance above 0"))?;
                Ok(CameraPath::Orbit { n: count(n)?, distance })
            }
            (Some("dolly"), []) => Ok(CameraPath::Dolly { n: DOLLY }),
            (Some("dolly"), [n]) => Ok(CameraPath::Dolly { n: count(n)? }),
            _ if text.to_ascii_lowercase().ends_with(".json") => Ok(CameraPath::File(text.into())),
            _ => Err("give orbit:N, orbit:N:DISTANCE, dolly, dolly:N or a file (.json)".into()),
        }
    }
}

/// The median of the centres of `boxes`, by axis; zero if none is finite. One box far out, or one
/// without measure, does not take it away from the others.
pub fn middle(boxes: &[Aabb]) -> DVec3 {
    let finite = boxes.iter().filter(|b| b.min.is_finite() && b.max.is_finite() && !b.is_empty());
    let centers: Vec<DVec3> = finite.map(Aabb::center).collect();
    let median = |axis: usize| {
        let mut along: Vec<f64> = centers.iter().map(|center| center[axis]).collect();
        let half = along.len() / 2;
        along.sort_unstable_by(f64::total_cmp);
        match along.len() {
            0 => 0.0,
            n if n % 2 == 0 => 0.5 * along[half - 1] + 0.5 * along[half],
            _ => along[half],
        }
    };
    DVec3::new(median(0), median(1), median(2))
}

/// The cameras of an orbit around `middle`, `distance` times as far from it as `base` is. With a
/// distance of 1 the first is `base` itself, bit for bit.
pub fn orbit(base: &Camera, middle: DVec3, n: u32, distance: f64) -> Vec<Camera> {
    let arm = (base.eye() - middle) * distance;
    (0..n)
        .filter_map(|i| {
            if i == 0 && distance == 1.0 {
                return Some(*base);
            }
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(n));
            let turn =
                DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos));
            moved(base, middle + turn * arm, &turn)
        })
        .collect()
}

/// The cameras of a straight way from `base` through `bounds`, the last one still before its end.
pub fn dolly(base: &Camera, bounds: &Aabb, n: u32) -> Vec<Camera> {
    let end = bounds.farthest_along(-base.back());
    let way = (end - base.eye()).dot(-base.back());
    let way = if way.is_finite() && way > 0.0 { way } else { 0.0 };
    (0..n)
        .filter_map(|i| {
            let step = way * f64::from(i) / f64::from(n);
            moved(base, base.eye() - base.back() * step, &DMat3::IDENTITY)
        })
        .collect()
}

/// An automatic `camera` for going through `bounds`: its near plane touches what it frames, which
/// would be in the way; this one lies at a thousandth of the size of everything.
pub fn close_up(camera: &Camera, bounds: &Aabb) -> Camera {
    let Projection::Perspective { yfov, near, far } = camera.projection() else { return *camera };
    let close = 1e-3 * (bounds.max - bounds.min).length();
    let near = if close > 0.0 { near.min(close) } else { near };
    let (eye, lens) = (camera.eye(), Projection::Perspective { yfov, near, far });
    let target = eye - camera.back() * eye.length().max(1.0);
    Camera::look_at(eye, target, camera.up(), lens).unwrap_or(*camera)
}

/// `base` with its eye elsewhere and turned. `None` so far from the origin that f64 cannot tell
/// the eye from what it looks at.
fn moved(base: &Camera, eye: DVec3, turn: &DMat3) -> Option<Camera> {
    let target = eye - *turn * base.back() * eye.length().max(1.0);
    Camera::look_at(eye, target, *turn * base.up(), base.projection()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base() -> Camera {
        let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: 100.0 };
        Camera::look_at(DVec3::new(0.0, 3.0, 11.0), DVec3::new(0.0, 3.0, 1.0), DVec3::Y, lens)
            .unwrap()
    }

    const BOUNDS: Aabb = Aabb { min: DVec3::new(-2.0, 0.0, -1.0), max: DVec3::new(2.0, 6.0, 3.0) };

    #[track_caller]
    fn near(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-12, "{a} {b}");
    }

    #[test]
    fn spellings() {
        let path = |text: &str| text.parse::<CameraPath>();
        assert_eq!(path("orbit:36"), Ok(CameraPath::Orbit { n: 36, distance: 1.0 }));
        assert_eq!(path("orbit:8:0.25"), Ok(CameraPath::Orbit { n: 8, distance: 0.25 }));
        assert_eq!(path("dolly"), Ok(CameraPath::Dolly { n: DOLLY }));
        assert_eq!(path("dolly:5"), Ok(CameraPath::Dolly { n: 5 }));
        assert_eq!(path("a:b.JSON"), Ok(CameraPath::File("a:b.JSON".into())));
        for wrong in ["orbit", "orbit:0", "orbit:x", "orbit:4:0", "orbit:4:nan", "dolly:1:1", "x"] {
            assert!(path(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_orbit_looks_at_the_middle_from_all_sides() {
        let cameras = orbit(&base(), BOUNDS.center(), 4, 0.5);
        let eyes = [[0.0, 3.0, 6.0], [5.0, 3.0, 1.0], [0.0, 3.0, -4.0], [-5.0, 3.0, 1.0]];
        for (camera, eye) in cameras.iter().zip(eyes.map(DVec3::from_array)) {
            near(camera.eye(), eye);
            near(camera.back(), (eye - BOUNDS.center()).normalize());
        }
    }

    #[test]
    fn an_orbit_begins_with_the_camera_itself() {
        for middle in [DVec3::ZERO, DVec3::splat(1e17), DVec3::new(0.1, 0.2, 0.3)] {
            let first = orbit(&base(), middle, 8, 1.0)[0];
            assert_eq!((first.eye(), first.back()), (base().eye(), base().back()));
            assert_eq!((first.up(), first.right()), (base().up(), base().right()));
        }
    }

    #[test]
    fn odd_boxes_do_not_move_the_middle() {
        let cube = |at: DVec3, half: f64| Aabb { min: at - half, max: at + half };
        let mut boxes: Vec<Aabb> =
            (0..9).map(|i| cube(DVec3::new(f64::from(i), 1.0, -1.0), 0.5)).collect();
        let expected = DVec3::new(4.0, 1.0, -1.0);
        assert_eq!(middle(&boxes), expected);
        boxes.extend([Aabb::NAN, Aabb::EMPTY, Aabb::INFINITE]);
        assert_eq!(middle(&boxes), expected);
        boxes.push(cube(DVec3::new(1e30, 1.0, -1.0), 1.0));
        assert_eq!(middle(&boxes), DVec3::new(4.5, 1.0, -1.0));
        boxes.push(Aabb { min: DVec3::splat(-1e24), max: DVec3::splat(0.1e24) });
        assert_eq!(middle(&boxes), expected);
        assert_eq!(middle(&boxes[..2]), DVec3::new(0.5, 1.0, -1.0));
        assert_eq!(middle(&[Aabb::NAN]), DVec3::ZERO);
    }

    #[test]
    fn a_dolly_ends_before_everything_is_behind_it() {
        let eyes: Vec<f64> =
            dolly(&base(), &BOUNDS, 4).iter().map(|camera| camera.eye().z).collect();
        assert_eq!(eyes, [11.0, 8.0, 5.0, 2.0]);
        assert_eq!(dolly(&base(), &Aabb::EMPTY, 2).len(), 2);
    }
}
