//! Frusta and boxes to measure the tests by.
//!
//! What a test leaves over depends on how large boxes are beside the frustum and on how the
//! frustum is turned, so a table of tests needs a table of scenes. These are seeded and the same
//! on every machine. Each sample is one frustum with boxes around it, spread evenly in
//! space wherever some test may keep one: a test's waste, the share of the boxes it
//! keeps that are not visible, then says something about the test and nothing about the spread.
//!
//! The camera sees 60 degrees upright at 16:9, from 0.1 to 100 unless said otherwise, looks
//! anywhere around and up to 0.5 radians up or down. A box edge is uniform between 0 and
//! twice its mean.
//!
//! Measured, in percent of the boxes kept (`tests_waste_what_the_table_says` holds it):
//!
//! | boxes | p-vertex | reverse | both |
//! | --- | --- | --- | --- |
//! | small | .03 | 62 | .004 |
//! | medium | 1.8 | 55 | .4 |
//! | big | 18.6 | 36 | 3.7 |
//! | frustum-sized | 43 | 17 | 5.6 |
//! | huge | 62 | 4.1 | 2.5 |
//! | rolled | 19 | 69 | 10.4 |
//! | tiles | 22.6 | 84 | 17 |
//! | clusters | 61 | 15.7 | 5.2 |
//! | city | 1.6 | 43 | .21 |
//!
//! The exact test leaves none.

use alloc::vec::Vec;

use cullet_transform::{Kind, Window};
use glam::{DMat3, DQuat, DVec3};

use crate::{Aabb, Frustum};

/// A way to make frusta and boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Distribution {
    /// Mean edge 1: props.
    Small,
    /// Mean edge 10: houses.
    Medium,
    /// Mean edge 50: half as large as the view is deep.
    Big,
    /// Mean edge 150: as large as the view.
    FrustumSized,
    /// Mean edge 500: ground planes, skies, upper nodes of a tree.
    Huge,
    /// Each edge from 1 to 100, evenly in the logarithm; the camera is turned any way.
    Rolled,
    /// The frusta of 16 x 9 tiles of a picture, turned any way; mean edge 9.
    Tiles,
    /// Such tiles cut into 24 slices of depth; mean edge 10: light ranges.
    Clusters,
    /// All nodes of a tree over the buildings of a city, the camera in its streets, far 230.
    City,
}

/// One frustum and the boxes to ask it about.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Who looks.
    pub frustum: Frustum,
    /// At what.
    pub boxes: Vec<Aabb>,
}

impl Distribution {
    /// All of them, in the order of the table.
    pub const ALL: [Distribution; 9] = [
        Distribution::Small,
        Distribution::Medium,
        Distribution::Big,
        Distribution::FrustumSized,
        Distribution::Huge,
        Distribution::Rolled,
        Distribution::Tiles,
        Distribution::Clusters,
        Distribution::City,
    ];

    /// Lower-case name with hyphens, for tables.
    pub const fn name(self) -> &'static str {
        const NAMES: [&str; 9] = [
            "small",
            "medium",
            "big",
            "frustum-sized",
            "huge",
            "rolled",
            "tiles",
            "clusters",
            "city",
        ];
        NAMES[self as usize]
    }

    /// An endless row of samples of some hundred boxes each.
    pub fn samples(self, seed: u64) -> impl Iterator<Item = Sample> {
        let mut rng = Rng(seed);
        let city = if self == Distribution::City { city(&mut rng) } else { Vec::new() };
        core::iter::repeat_with(move || self.sample(&mut rng, &city))
    }

    fn sample(self, rng: &mut Rng, city: &[Aabb]) -> Sample {
        let everywhere = |rng: &mut Rng, edge: f64| {
            let around = Aabb { min: DVec3::splat(-100.0), max: DVec3::splat(100.0) };
            let frustum = Frustum::from_window(DVec3::ZERO, &upright(rng, 0.5), &VIEW);
            Sample { frustum, boxes: boxes(rng, &around.grown(edge), mean(edge)) }
        };
        match self {
            Distribution::Small => everywhere(rng, 1.0),
            Distribution::Medium => everywhere(rng, 10.0),
            Distribution::Big => everywhere(rng, 50.0),
            Distribution::FrustumSized => everywhere(rng, 150.0),
            Distribution::Huge => everywhere(rng, 500.0),
            Distribution::Rolled => {
                let frustum = Frustum::from_window(DVec3::ZERO, &rotation(rng), &VIEW);
                let boxes = boxes(rng, &frustum.bounds().grown(50.0), |rng| {
                    DVec3::new(rng.log(1.0, 100.0), rng.log(1.0, 100.0), rng.log(1.0, 100.0))
                });
                Sample { frustum, boxes }
            }
            Distribution::Tiles => {
                let window = tile(rng, VIEW);
                let frustum = Frustum::from_window(DVec3::ZERO, &rotation(rng), &window);
                let boxes = boxes(rng, &frustum.bounds().grown(9.0), mean(9.0));
                Sample { frustum, boxes }
            }
            Distribution::Clusters => {
                let slice = |i: f64| VIEW.near * libm::pow(VIEW.far / VIEW.near, i / 24.0);
                let i = libm::floor(rng.within(0.0, 24.0));
                let window = Window { near: slice(i), far: slice(i + 1.0), ..tile(rng, VIEW) };
                let frustum = Frustum::from_window(DVec3::ZERO, &rotation(rng), &window);
                let boxes = boxes(rng, &frustum.bounds().grown(10.0), mean(10.0));
                Sample { frustum, boxes }
            }
            Distribution::City => {
                let street = |rng: &mut Rng| BLOCK * libm::floor(rng.within(-8.0, 8.0));
                let eye = DVec3::new(street(rng), 1.7, street(rng));
                let window = Window { far: 230.0, ..VIEW };
                let frustum = Frustum::from_window(eye, &upright(rng, 0.1), &window);
                Sample { frustum, boxes: city.to_vec() }
            }
        }
    }
}

/// 60 degrees at 16:9.
const VIEW: Window = Window {
    kind: Kind::Perspective,
    left: -TAN_30 * 16.0 / 9.0,
    right: TAN_30 * 16.0 / 9.0,
    bottom: -TAN_30,
    top: TAN_30,
    near: 0.1,
    far: 100.0,
};
const TAN_30: f64 = 0.577_350_269_189_625_8;

/// From the middle of one street of the city to that of the next.
const BLOCK: f64 = 40.0;

/// The axes of a camera that looks anywhere around, and up or down by up to `tilt` radians.
fn upright(rng: &mut Rng, tilt: f64) -> DMat3 {
    DMat3::from_rotation_y(rng.angle()) * DMat3::from_rotation_x(rng.within(-tilt, tilt))
}

/// Evenly among all rotations (Shoemake, "Uniform Random Rotations", Graphics Gems III, 1992).
fn rotation(rng: &mut Rng) -> DMat3 {
    let (u, v, w) = (rng.within(0.0, 1.0), rng.angle(), rng.angle());
    let (a, b) = (libm::sqrt(1.0 - u), libm::sqrt(u));
    let (sin_v, cos_v) = libm::sincos(v);
    let (sin_w, cos_w) = libm::sincos(w);
    DMat3::from_quat(DQuat::from_xyzw(a * sin_v, a * cos_v, b * sin_w, b * cos_w))
}

/// Any of the 16 x 9 tiles of `window`.
fn tile(rng: &mut Rng, window: Window) -> Window {
    let (width, height) = ((window.right - window.left) / 16.0, (window.top - window.bottom) / 9.0);
    let (x, y) = (libm::floor(rng.within(0.0, 16.0)), libm::floor(rng.within(0.0, 9.0)));
    let (left, bottom) = (window.left + x * width, window.bottom + y * height);
    Window { left, right: left + width, bottom, top: bottom + height, ..window }
}

/// 500 boxes with their middles evenly in `around` and edges as `edges` says.
fn boxes(rng: &mut Rng, around: &Aabb, edges: impl Fn(&mut Rng) -> DVec3) -> Vec<Aabb> {
    core::iter::repeat_with(|| {
        let middle = rng.point(around.min, around.max);
        let half = 0.5 * edges(rng);
        Aabb { min: middle - half, max: middle + half }
    })
    .take(500)
    .collect()
}

/// Edges from 0 to twice `mean`.
fn mean(mean: f64) -> impl Fn(&mut Rng) -> DVec3 {
    move |rng| rng.point(DVec3::ZERO, DVec3::splat(2.0 * mean))
}

/// Every node of a tree over 16 x 16 blocks of four buildings, halved in the middle of the longer
/// side down to the single building.
fn city(rng: &mut Rng) -> Vec<Aabb> {
    let mut buildings = Vec::new();
    for (x, z) in (-16..16).flat_map(|x| (-16..16).map(move |z| (x, z))) {
        // Two by two in a block, with a street of 8 between blocks.
        let place = |i: i32| {
            let corner = f64::from(i) * (BLOCK / 2.0);
            if i % 2 == 0 { corner + 4.0 } else { corner + 1.0 }
        };
        let min = DVec3::new(place(x), 0.0, place(z));
        let size =
            DVec3::new(rng.within(10.0, 15.0), rng.within(6.0, 60.0), rng.within(10.0, 15.0));
        buildings.push(Aabb { min, max: min + size });
    }
    let mut nodes = Vec::new();
    halved(&mut buildings, &mut nodes);
    nodes
}

fn halved(boxes: &mut [Aabb], nodes: &mut Vec<Aabb>) {
    let node = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds));
    nodes.push(node);
    if boxes.len() > 1 {
        let axis = if node.half_extent().x > node.half_extent().z { 0 } else { 2 };
        boxes.sort_by(|a, b| a.min[axis].total_cmp(&b.min[axis]));
        let (low, high) = boxes.split_at_mut(boxes.len() / 2);
        halved(low, nodes);
        halved(high, nodes);
    }
}

/// SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    /// In `low..high`.
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Evenly in the logarithm.
    fn log(&mut self, low: f64, high: f64) -> f64 {
        low * libm::pow(high / low, self.within(0.0, 1.0))
    }

    pub(crate) fn point(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        DVec3::new(
            self.within(low.x, high.x),
            self.within(low.y, high.y),
            self.within(low.z, high.z),
        )
    }

    fn angle(&mut self) -> f64 {
        self.within(0.0, core::f64::consts::TAU)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ladder, Test, visible};

    #[test]
    fn samples_are_the_same_every_time() {
        for distribution in Distribution::ALL {
            let first = |seed| {
                let sample = distribution.samples(seed).nth(2).expect("endless");
                (sample.frustum.planes, sample.boxes)
            };
            assert_eq!(first(5), first(5));
            assert_ne!(first(5), first(6));
        }
    }

    /// Percent of the boxes kept by p-vertex, reverse and both that are outside.
    fn waste(distribution: Distribution, n_samples: usize) -> [f64; 3] {
        let (mut n_visible, mut n_kept) = (0, [0; 3]);
        for Sample { frustum, boxes } in distribution.samples(1).take(n_samples) {
            let exact = Ladder::new(&frustum, &[Test::Both, Test::Sat]);
            for bounds in &boxes {
                n_visible += u32::from(exact.visible(bounds, &mut ()));
                for (n, test) in n_kept.iter_mut().zip([Test::PVertex, Test::Reverse, Test::Both]) {
                    *n += u32::from(visible(test, &frustum, bounds));
                }
            }
        }
        n_kept.map(|n| 100.0 * f64::from(n - n_visible) / f64::from(n))
    }

    /// As the table in the module's documentation says, to a tenth, or a tenth of a percent.
    #[track_caller]
    fn check(distribution: Distribution, expected: [f64; 3]) {
        let measured = waste(distribution, 400);
        for (measured, expected) in measured.into_iter().zip(expected) {
            let off = (measured - expected).abs();
            assert!(off <= (0.1 * expected).max(0.1), "{distribution:?} {measured}");
        }
    }

    #[test]
    fn tests_waste_what_the_table_says() {
        check(Distribution::Small, [0.03, 62.0, 0.0]);
        check(Distribution::Medium, [1.8, 55.0, 0.4]);
        check(Distribution::Big, [18.6, 36.0, 3.7]);
        check(Distribution::FrustumSized, [43.0, 17.0, 5.6]);
        check(Distribution::Huge, [62.0, 4.1, 2.5]);
        check(Distribution::Rolled, [19.0, 69.0, 10.4]);
        check(Distribution::Tiles, [22.6, 84.0, 17.0]);
        check(Distribution::Clusters, [61.0, 15.7, 5.2]);
        check(Distribution::City, [1.6, 43.0, 0.21]);
    }
}
