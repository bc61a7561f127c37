//! Boxes and frustum from above and from the side, coloured by what became of each box.

use std::fmt::Write;

use cullet::cull::{Aabb, Frustum, Verdict};
use glam::{DVec2, DVec3};

use super::color;

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 460.0;

/// More would only cover each other, and make the page slow.
pub const MOST_BOXES: usize = 3000;

/// How far beyond the middle half of all boxes the page may reach, as a multiple of its width.
const STRAY: f64 = 4.0;

/// A direction to look along: which world axes go right and up on the page, and their signs.
#[derive(Clone, Copy)]
pub struct Projection {
    right: (usize, f64),
    up: (usize, f64),
}

impl Projection {
    /// From above: x to the right, -z up.
    pub const TOP: Projection = Projection { right: (0, 1.0), up: (2, -1.0) };

    /// From the side: y up, and the level axis nearest to `forward` to the right.
    pub fn side(forward: DVec3) -> Projection {
        let axis = if forward.x.abs() > forward.z.abs() { 0 } else { 2 };
        Projection { right: (axis, 1f64.copysign(forward[axis])), up: (1, 1.0) }
    }

    /// What the two directions of the page are.
    pub fn title(&self) -> String {
        let name = |(axis, sign): (usize, f64)| {
            format!("{}{}", if sign < 0.0 { "−" } else { "" }, ["x", "y", "z"][axis])
        };
        format!("{} to the right, {} up", name(self.right), name(self.up))
    }

    fn of(&self, point: DVec3) -> DVec2 {
        DVec2::new(point[self.right.0] * self.right.1, point[self.up.0] * self.up.1)
    }

    fn rect(&self, bounds: &Aabb) -> [DVec2; 2] {
        let (a, b) = (self.of(bounds.min), self.of(bounds.max));
        [a.min(b), a.max(b)]
    }
}

/// The boxes of one camera.
pub struct Map<'a> {
    /// World space.
    pub boxes: &'a [Aabb],
    /// On each box.
    pub verdicts: &'a [Verdict],
    /// World space.
    pub frustum: &'a Frustum,
    /// It is a camera's, and has an eye.
    pub eye: bool,
}

impl Map<'_> {
    /// The drawing.
    pub fn draw(&self, projection: Projection) -> String {
        let [low, high] = self.region(projection);
        let scale = (WIDTH / (high.x - low.x)).min(HEIGHT / (high.y - low.y));
        let middle = 0.5 * (low + high);
        let place = |p: DVec2| {
            let p = (p - middle) * scale;
            DVec2::new(0.5 * WIDTH + p.x, 0.5 * HEIGHT - p.y)
        };
        let mut body = String::new();
        for i in self.order() {
            let [a, b] = projection.rect(&self.boxes[i]).map(place);
            let border = DVec2::splat(20.0);
            let page = DVec2::new(WIDTH, HEIGHT);
            let (low, high) = (DVec2::new(a.x, b.y), DVec2::new(b.x, a.y));
            let (low, high) = (low.max(-border), high.min(page + border));
            if low.x > high.x || low.y > high.y {
                continue; // off the page
            }
            let everywhere = low == -border && high == page + border;
            let opacity = if everywhere { " fill-opacity='.04'" } else { "" };
            // Flat boxes and distant ones still show.
            let size = (high - low).max(DVec2::ONE);
            let fate = self.verdicts[i].fate;
            let class = fate.index();
            let _ = write!(
                body,
                "<rect class='f{class}' x='{:.1}' y='{:.1}' width='{:.1}' height='{:.1}' fill='{color}' \
                 stroke='{color}'{opacity}><title>box {i}: {}</title></rect>",
                low.x,
                low.y,
                size.x,
                size.y,
                fate.name(),
                color = color(fate),
            );
        }
        let reach = 4.0 * (high - low).length();
        let corners: Vec<DVec2> =
            corners(self.frustum, reach).into_iter().map(|p| projection.of(p)).collect();
        let outline: Vec<String> = hull(corners)
            .into_iter()
            .map(place)
            .filter(|p| p.is_finite())
            .map(|p| format!("{:.1},{:.1}", p.x, p.y))
            .collect();
        let eye = place(projection.of(self.frustum.origin()));
        let _ = write!(body, "<polygon class='frustum' points='{}'/>", outline.join(" "));
        if self.eye && eye.is_finite() {
            let _ = write!(body, "<circle class='eye' cx='{:.1}' cy='{:.1}' r='4'/>", eye.x, eye.y);
        }
        format!("<svg viewBox='0 0 {WIDTH} {HEIGHT}' role='img'>{body}</svg>")
    }

    /// The boxes to draw: not too many, large ones first, visible ones last.
    fn order(&self) -> Vec<usize> {
        let step = self.boxes.len().div_ceil(MOST_BOXES).max(1);
        let drawable = |i: &usize| !self.boxes[*i].is_nan() && !self.boxes[*i].is_empty();
        let mut order: Vec<usize> = (0..self.boxes.len()).step_by(step).filter(drawable).collect();
        let size = |i: usize| (self.boxes[i].max - self.boxes[i].min).element_sum();
        order.sort_by(|&a, &b| {
            let seen = |i: usize| self.verdicts[i].visible();
            seen(a).cmp(&seen(b)).then(size(b).total_cmp(&size(a)))
        });
        order
    }

    /// What the page shows: most boxes and the eye, whatever a few boxes far away do.
    fn region(&self, projection: Projection) -> [DVec2; 2] {
        let finite = |bounds: &&Aabb| bounds.min.is_finite() && bounds.max.is_finite();
        let rects: Vec<[DVec2; 2]> =
            self.boxes.iter().filter(finite).map(|bounds| projection.rect(bounds)).collect();
        // The eye, or where the volume begins.
        let eye = match self.eye {
            true => self.frustum.origin(),
            false => self.frustum.origin() + self.frustum.corners()[0].truncate(),
        };
        let eye = projection.of(eye);
        let eye = if eye.is_finite() { eye } else { DVec2::ZERO };
        let side = |axis: usize| {
            let [low, high] = [0, 1].map(|end| {
                let mut values: Vec<f64> = rects.iter().map(|rect| rect[end][axis]).collect();
                values.sort_by(f64::total_cmp);
                values
            });
            let at = |values: &[f64], share: f64| {
                let rank = (share * values.len().saturating_sub(1) as f64).round() as usize;
                values.get(rank).copied().unwrap_or(eye[axis])
            };
            // Boxes some times farther out than the middle half of them is wide are left out.
            let reach = STRAY * (at(&high, 0.75) - at(&low, 0.25));
            let least = at(&low, 0.01).max(at(&low, 0.25) - reach).min(eye[axis]);
            let most = at(&high, 0.99).min(at(&high, 0.75) + reach).max(eye[axis]);
            (least, most)
        };
        let (x, y) = (side(0), side(1));
        let (low, high) = (DVec2::new(x.0, y.0), DVec2::new(x.1, y.1));
        let margin = 0.06 * (high - low).max_element();
        let margin = if margin > 0.0 && margin.is_finite() { margin } else { 1.0 };
        [low - margin, high + margin]
    }
}

/// The corners of the view volume, those at infinity at a distance of `reach`.
fn corners(frustum: &Frustum, reach: f64) -> Vec<DVec3> {
    let near = |i: usize| frustum.corners()[i & 3].truncate();
    let corner = |i: usize| {
        let corner = frustum.corners()[i];
        let point = match corner.w {
            w if w > 0.0 => corner.truncate() / w,
            0.0 => near(i) + corner.truncate().normalize_or_zero() * reach,
            // Beyond the horizon: the edge leads away from there.
            w => near(i) + (near(i) - corner.truncate() / w).normalize_or_zero() * reach,
        };
        frustum.origin() + point
    };
    (0..8).map(corner).collect()
}

/// The convex hull, counter-clockwise (Andrew, "Another Efficient Algorithm for Convex Hulls in
/// Two Dimensions", 1979).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.retain(|point| point.is_finite());
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(point - b) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

#[cfg(test)]
mod tests {
    use cullet::cull::Sat;
    use cullet::transform::{Kind, Window};
    use glam::DMat3;

    use super::*;

    #[test]
    fn a_hull_has_the_outer_points_only() {
        let point = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
        let points = (0..25).map(|i| point(i % 5, i / 5)).collect();
        assert_eq!(hull(points), [point(0, 0), point(4, 0), point(4, 4), point(0, 4)]);
        assert_eq!(hull(vec![point(1, 1)]), []);
    }

    #[test]
    fn odd_boxes_do_not_spoil_the_picture() {
        let window = Window {
            kind: Kind::Perspective,
            left: -1.0,
            right: 1.0,
            bottom: -1.0,
            top: 1.0,
            near: 1.0,
            far: f64::INFINITY,
        };
        let frustum = Frustum::from_window(DVec3::ZERO, &DMat3::IDENTITY, &window);
        let sat = Sat::new(&frustum);
        let unit = Aabb { min: DVec3::new(-1.0, -1.0, -4.0), max: DVec3::new(1.0, 1.0, -3.0) };
        for boxes in [
            vec![],
            vec![Aabb::NAN, Aabb::EMPTY, Aabb::INFINITE, unit],
            vec![unit, unit, unit, unit, Aabb { min: unit.min * 1e30, max: unit.max }],
            vec![Aabb { min: DVec3::ZERO, max: DVec3::ZERO }],
            vec![unit; MOST_BOXES + 5],
        ] {
            let verdicts: Vec<Verdict> =
                boxes.iter().map(|bounds| Verdict::on(bounds, &sat)).collect();
            let map = Map { boxes: &boxes, verdicts: &verdicts, frustum: &frustum, eye: true };
            for projection in [Projection::TOP, Projection::side(DVec3::NEG_Z)] {
                let drawn = map.draw(projection);
                assert!(!drawn.contains("NaN") && !drawn.contains("inf"), "{drawn}");
                assert!(drawn.matches("<rect").count() <= MOST_BOXES);
            }
        }
    }
}
