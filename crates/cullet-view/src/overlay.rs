//! Lines of the world drawn over a finished picture.
//!
//! Lines are clipped in homogeneous coordinates, before the divide, so that a line which passes
//! behind the eye keeps its visible part and no other (Blinn and Newell 1978; Liang and Barsky
//! 1984). Each column (or row, for steep lines) of a line covers a span of pixels in proportion,
//! which smooths the edges; where the picture's depth is nearer the line shows through faintly.
//!
//! Pixels are 0RGB words, row-major, top row first, as a window takes them.

use cullet::cull::Aabb;
use cullet::transform::{ClipPoint, Kind, Plane, Window};
use cullet::{Frame, View};
use glam::{DAffine3, DMat4, DVec2, DVec3};

/// A picture to draw over.
#[derive(Debug)]
pub struct Canvas<'a> {
    /// `width * height` words 0RGB.
    pub pixels: &'a mut [u32],
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
}

impl Canvas<'_> {
    /// Mixes `color` into a pixel, `opacity` from 0 to 1. Outside of the picture nothing happens.
    pub fn blend(&mut self, x: usize, y: usize, color: u32, opacity: f64) {
        if x < self.width && y < self.height {
            let pixel = &mut self.pixels[y * self.width + x];
            *pixel = mixed(*pixel, color, (opacity * 256.0) as u32);
        }
    }
}

/// `below` with `share` of 256 parts of `above`; more than 256 counts as that.
fn mixed(below: u32, above: u32, share: u32) -> u32 {
    let share = share.min(256);
    let channel = |shift: u32| {
        let (below, above) = (below >> shift & 0xff, above >> shift & 0xff);
        (below * (256 - share) + above * share) >> 8 << shift
    };
    channel(16) | channel(8) | channel(0)
}

/// How a line looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// 0RGB.
    pub color: u32,
    /// Across the line, px.
    pub width: f64,
    /// From 0 to 1.
    pub opacity: f64,
    /// Share of the opacity that is left behind nearer things.
    pub behind: f64,
}

/// Part of a distance by which a line may lie behind a surface and still count as before it, so
/// that the box of a box shows on its faces.
const DEPTH_TOLERANCE: f64 = 0.004;

/// A canvas seen by a camera: takes lines of the world.
#[derive(Debug)]
pub struct Lines<'a> {
    canvas: Canvas<'a>,
    clip_from_world: DMat4,
    window: Window,
    /// The frame whose depth hides lines; its pixels may be larger than those of the canvas.
    frame: &'a Frame,
}

/// An end of a line on the picture.
#[derive(Clone, Copy, Debug)]
struct End {
    /// px.
    at: DVec2,
    /// 1 / w, and the distance along the view axis over w: both are linear on the picture.
    inverse_w: f64,
    distance_over_w: f64,
}

impl<'a> Lines<'a> {
    /// Lines over `canvas`, which shows what `view` sees; those behind the depth of `frame` are
    /// faint (none if it has no depth).
    pub fn new(canvas: Canvas<'a>, view: &View, frame: &'a Frame) -> Self {
        let clip_from_world = view.clip_from_model(&DAffine3::IDENTITY);
        Lines { canvas, clip_from_world, window: view.window(), frame }
    }

    /// A straight line between two points.
    pub fn line(&mut self, a: DVec3, b: DVec3, stroke: &Stroke) {
        let ends = [a, b].map(|p| ClipPoint::from_model(&self.clip_from_world, p));
        if let Some(ends) = clipped(ends) {
            let [a, b] = ends.map(|p| self.end(&p));
            self.draw(a, b, stroke);
        }
    }

    /// A closed line through `corners`.
    pub fn outline(&mut self, corners: &[DVec3], stroke: &Stroke) {
        let next = corners.iter().cycle().skip(1);
        for (&a, &b) in corners.iter().zip(next) {
            self.line(a, b, stroke);
        }
    }

    /// The edges between eight corners; bit 0, 1 and 2 of an index tell two sides apart.
    pub fn edges(&mut self, corners: &[DVec3; 8], stroke: &Stroke) {
        for (i, &corner) in corners.iter().enumerate() {
            for other in [i | 1, i | 2, i | 4].into_iter().filter(|&other| other != i) {
                self.line(corner, corners[other], stroke);
            }
        }
    }

    /// The edges of a box.
    pub fn aabb(&mut self, bounds: &Aabb, stroke: &Stroke) {
        self.edges(&bounds.corners(), stroke);
    }

    /// The volume that `view` sees, cut off at distance `reach` if that is nearer than its far
    /// plane. Inside the frame of each side runs a thin line in the colour of its plane.
    pub fn frustum(
        &mut self,
        view: &View,
        reach: f64,
        stroke: &Stroke,
        plane_color: impl Fn(Plane) -> u32,
    ) {
        let (camera, window) = (view.camera(), view.window());
        let [near, far] = [window.near, window.far.min(reach.max(window.near * 2.0))];
        let corner = |u, v, distance| {
            let p: DVec3 = window.at(u, v, distance);
            camera.eye() + camera.right() * p.x + camera.up() * p.y + camera.back() * p.z
        };
        let corners: [DVec3; 8] = core::array::from_fn(|i| {
            let at = |bit: usize, low, high| if i & bit == 0 { low } else { high };
            corner(at(1, 0.0, 1.0), at(2, 1.0, 0.0), at(4, near, far))
        });
        self.edges(&corners, stroke);
        if window.kind == Kind::Perspective {
            let faint = Stroke { opacity: 0.5 * stroke.opacity, ..*stroke };
            (0..4).for_each(|i| self.line(camera.eye(), corners[i], &faint));
        }
        // Corners of each side, in the order of the planes, going around.
        let sides =
            [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
        for (plane, side) in Plane::ALL.into_iter().zip(sides) {
            let side = side.map(|i| corners[i]);
            let middle = side.iter().sum::<DVec3>() * 0.25;
            let inner = side.map(|corner| corner.lerp(middle, 0.06));
            self.outline(&inner, &Stroke { color: plane_color(plane), ..*stroke });
        }
    }

    fn end(&self, p: &ClipPoint) -> End {
        let distance = match self.window.kind {
            Kind::Perspective => p.w,
            Kind::Orthographic => self.window.far - p.z * (self.window.far - self.window.near),
        };
        let ndc = p.ndc();
        let size = DVec2::new(self.canvas.width as f64, self.canvas.height as f64);
        End {
            at: DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size,
            inverse_w: 1.0 / p.w,
            distance_over_w: distance / p.w,
        }
    }

    /// Walks along the longer axis, a span of pixels across at each step.
    fn draw(&mut self, a: End, b: End, stroke: &Stroke) {
        let along = b.at - a.at;
        let steep = along.y.abs() > along.x.abs();
        let turned = |p: DVec2| if steep { DVec2::new(p.y, p.x) } else { p };
        let (a, b) = if turned(along).x < 0.0 { (b, a) } else { (a, b) };
        let (from, to) = (turned(a.at), turned(b.at));
        let length = to.x - from.x;
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let slope = (to.y - from.y) / length;
        let half = 0.5 * stroke.width * libm::hypot(1.0, slope);
        for step in from.x.max(0.0) as usize..=to.x as usize {
            let (left, right) = (step as f64, step as f64 + 1.0);
            let share = right.min(to.x) - left.max(from.x);
            let t = ((left + 0.5 - from.x) / length).clamp(0.0, 1.0);
            let middle = from.y + (to.y - from.y) * t;
            let inverse_w = a.inverse_w + (b.inverse_w - a.inverse_w) * t;
            let over_w = a.distance_over_w + (b.distance_over_w - a.distance_over_w) * t;
            let distance = over_w / inverse_w;
            let (low, high) = (middle - half, middle + half);
            for across in low.max(0.0) as usize..=high.max(0.0) as usize {
                let covered = high.min(across as f64 + 1.0) - low.max(across as f64);
                let (x, y) = if steep { (across, step) } else { (step, across) };
                let hidden = self.is_nearer(x, y, distance);
                let opacity = if hidden { stroke.opacity * stroke.behind } else { stroke.opacity };
                self.canvas.blend(x, y, stroke.color, opacity * (share * covered).max(0.0));
            }
        }
    }

    /// Whether the picture shows something before `distance`.
    fn is_nearer(&self, x: usize, y: usize, distance: f64) -> bool {
        let scaled = |i: usize, canvas: usize, frame: u32| i * frame as usize / canvas.max(1);
        let column = scaled(x, self.canvas.width, self.frame.width);
        let row = scaled(y, self.canvas.height, self.frame.height);
        let depth = self.frame.depth.get(row * self.frame.width as usize + column);
        depth.is_some_and(|&depth| f64::from(depth) < distance * (1.0 - DEPTH_TOLERANCE))
    }
}

/// The part of a line in the view volume.
fn clipped(ends: [ClipPoint; 2]) -> Option<[ClipPoint; 2]> {
    if !ends.iter().all(ClipPoint::is_finite) {
        return None;
    }
    // Per plane how far inside a point is, linear along the line. A hair is allowed for, so that
    // the frustum of the view itself shows along the border.
    let inside = |p: &ClipPoint| {
        let w = p.w * (1.0 + 1e-9);
        [w + p.x, w - p.x, w + p.y, w - p.y, w - p.z, p.z]
    };
    let [from, to] = [inside(&ends[0]), inside(&ends[1])];
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (from, to) in from.into_iter().zip(to) {
        match (from < 0.0, to < 0.0) {
            (true, true) => return None,
            (true, false) => enter = enter.max(from / (from - to)),
            (false, true) => leave = leave.min(from / (from - to)),
            (false, false) => {}
        }
    }
    let part = [enter, leave].map(|t| ends[0].lerp(&ends[1], t));
    (enter < leave && part.iter().all(|p| p.w > 0.0)).then_some(part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::{Camera, Projection, Viewport};

    const WHITE: Stroke = Stroke { color: 0xff_ffff, width: 1.0, opacity: 1.0, behind: 0.0 };
    const LENS: Projection = Projection::Perspective {
        yfov: core::f64::consts::FRAC_PI_2,
        near: 0.5,
        far: f64::INFINITY,
    };

    /// 16 x 8 pixels at z = 4; at z = 0 they cover x and y in -8..8 and -4..4.
    fn view(projection: Projection) -> View {
        let camera = Camera::look_at(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y, projection).unwrap();
        View::new(&camera, Viewport::new(16, 8).unwrap())
    }

    /// A picture of `draw` as rows of `#` (more than half), `+` (a little) and `.`.
    fn picture(view: &View, frame: &Frame, draw: impl Fn(&mut Lines<'_>)) -> Vec<String> {
        let mut pixels = [0; 16 * 8];
        let canvas = Canvas { pixels: &mut pixels, width: 16, height: 8 };
        draw(&mut Lines::new(canvas, view, frame));
        let mark = |&pixel: &u32| match pixel & 0xff {
            0..16 => '.',
            16..128 => '+',
            _ => '#',
        };
        pixels.chunks(16).map(|row| row.iter().map(mark).collect()).collect()
    }

    #[track_caller]
    fn check(a: [f64; 3], b: [f64; 3], expected: [&str; 8]) {
        for projection in [LENS, Projection::Orthographic { height: 8.0, near: 0.5, far: 99.0 }] {
            let (view, frame) = (view(projection), Frame::default());
            let found = picture(&view, &frame, |lines| lines.line(a.into(), b.into(), &WHITE));
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn lines_run_from_pixel_to_pixel() {
        let flat = [
            "................",
            "................",
            "................",
            "..###########...",
            "................",
            "................",
            "................",
            "................",
        ];
        check([-6.0, 0.5, 0.0], [5.0, 0.5, 0.0], flat);
        check([5.0, 0.5, 0.0], [-6.0, 0.5, 0.0], flat);
        let upright = [
            "................",
            "...........#....",
            "...........#....",
            "...........#....",
            "...........#....",
            "...........#....",
            "................",
            "................",
        ];
        check([3.5, 3.0, 0.0], [3.5, -2.0, 0.0], upright);
    }

    #[test]
    fn lines_stop_at_the_border() {
        let row = "################";
        let empty = "................";
        check(
            [-1e9, 0.5, 0.0],
            [1e9, 0.5, 0.0],
            [empty, empty, empty, row, empty, empty, empty, empty],
        );
        check([-1e9, 9.0, 0.0], [1e9, 9.0, 0.0], [empty; 8]);
        check([f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [empty; 8]);
        check([1.0, 0.5, f64::INFINITY], [1.0, 0.0, 0.0], [empty; 8]);
    }

    #[test]
    fn a_line_past_the_eye_keeps_only_what_is_before_it() {
        let (view, frame) = (view(LENS), Frame::default());
        // From the middle of the picture to a point behind the eye and to the right of it.
        let (a, b) = (DVec3::new(0.0, 0.25, 0.0), DVec3::new(2.0, 0.25, 12.0));
        let found = picture(&view, &frame, |lines| lines.line(a, b, &WHITE));
        let left: String = found.iter().map(|row| &row[..7]).collect();
        assert!(!left.contains(['#', '+']), "{found:#?}");
        assert!(found.iter().any(|row| row.contains('#')), "{found:#?}");
        let behind = DVec3::new(0.0, 0.0, 9.0);
        let found = picture(&view, &frame, |lines| lines.line(behind, b, &WHITE));
        assert!(found.iter().all(|row| *row == "................"), "{found:#?}");
    }

    #[test]
    fn nearer_things_hide_lines() {
        let depth =
            |distance| Frame { width: 8, height: 4, depth: vec![distance; 32], ..Frame::default() };
        for projection in [LENS, Projection::Orthographic { height: 8.0, near: 0.5, far: 99.0 }] {
            let view = view(projection);
            let (a, b) = (DVec3::new(-6.0, 0.5, 0.0), DVec3::new(5.0, 0.5, 0.0));
            let seen = |frame: &Frame| {
                let rows = picture(&view, frame, |lines| lines.line(a, b, &WHITE));
                rows.concat().contains('#')
            };
            assert!(seen(&depth(f32::INFINITY)));
            assert!(seen(&depth(4.0)), "a line on a surface is seen");
            assert!(!seen(&depth(3.9)));
        }
    }

    #[test]
    fn a_box_has_twelve_edges() {
        let view = view(Projection::Orthographic { height: 8.0, near: 0.5, far: 99.0 });
        let bounds = Aabb { min: DVec3::new(-5.5, -2.5, -1.0), max: DVec3::new(4.5, 2.5, 1.0) };
        let found = picture(&view, &Frame::default(), |lines| lines.aabb(&bounds, &WHITE));
        let (side, open) = ("..+#########+...", "..#.........#...");
        assert_eq!(found[0], "................");
        assert!(found[1][3..12].chars().all(|c| c == '#'), "{found:#?}");
        assert!(found[2..6].iter().all(|row| row == open), "{side} {found:#?}");
    }

    #[test]
    fn a_frustum_seen_from_its_own_eye_is_the_border_of_the_picture() {
        let view = view(LENS);
        let wide = Stroke { width: 2.0, ..WHITE };
        let found = picture(&view, &Frame::default(), |lines| {
            lines.frustum(&view, 10.0, &wide, |_| WHITE.color);
        });
        assert!(found[0].chars().all(|c| c != '.') && found[7].chars().all(|c| c != '.'));
    }

    #[test]
    fn mixing_is_exact_at_both_ends() {
        assert_eq!(mixed(0x12_3456, 0xff_0080, 0), 0x12_3456);
        assert_eq!(mixed(0x12_3456, 0xff_0080, 256), 0xff_0080);
        assert_eq!(mixed(0x12_3456, 0xff_0080, 999), 0xff_0080);
        assert_eq!(mixed(0, 0xff_ffff, 128), 0x7f_7f7f);
    }
}
