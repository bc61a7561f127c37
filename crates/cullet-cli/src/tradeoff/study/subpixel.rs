//! What does snapping to a grid change on small triangles?
//!
//! Triangles of some pixels, one in each cell of 8 x 8, seen straight on. A sample is wrong if the triangle
//! drawn there is not the one whose unsnapped edges, in f64, hold it. Counted against all samples that
//! belong to a triangle in either.

use cullet::scene::{Mesh, Scene, synth::synth};
use cullet::{
    Camera, Frame, Pass, Passes, Prepared, Projection, Renderer, Settings, SubpixelBits, View,
    Viewport,
};
use glam::{DAffine3, DVec2, DVec3, Vec3};

use super::super::doubt::Outcome;
use super::super::findings::Verdict;
use super::super::words::short;
use super::{Claim, Random, Study};
use crate::exit::Failure;

/// Pixels along a side of the picture, a whole number of cells.
const SIDE: u32 = 2048;
const CELL: u32 = 8;

/// The grids, and what is expected of them.
const GRIDS: [(SubpixelBits, &str, f64); 4] = [
    (SubpixelBits::Four, "Of small triangles a grid of 4 bits changes .022 of the samples", 2.2e-2),
    (
        SubpixelBits::Eight,
        "Of small triangles a grid of 8 bits changes .0014 of the samples",
        1.4e-3,
    ),
    (
        SubpixelBits::Twelve,
        "Of small triangles a grid of 12 bits changes .00027 of the samples",
        2.7e-4,
    ),
    (SubpixelBits::Sixteen, "Of small triangles a grid of 16 bits changes no sample", 0.0),
];

/// Differing samples by grid.
pub fn study() -> Result<Study, Failure> {
    let (prepared, view, corners) = small_triangles()?;
    let truth = ideal(&corners);
    let mut renderer = Renderer::default();
    let (mut lines, mut claims) = (Vec::new(), Vec::new());
    for (subpixel_bits, text, expected) in GRIDS {
        let passes = Passes::NONE.with(Pass::Triangle);
        let settings = Settings { passes, subpixel_bits, ..Settings::default() };
        let mut frame = Frame::default();
        renderer.render(&prepared, &view, &settings, &mut frame);
        let pairs = || truth.iter().zip(&frame.triangle);
        let n = pairs().filter(|(a, b)| **a != 0 || **b != 0).count();
        let n_wrong = pairs().filter(|(a, b)| a != b).count();
        let share = n_wrong as f64 / n as f64;
        let verdict = Verdict {
            scene: "small triangles".into(),
            outcome: as_expected(n_wrong, n, expected),
            figures: format!("{}, {n_wrong} of {n}", short(share)),
        };
        claims.push(Claim { text, verdict });
        let bits = subpixel_bits.count();
        lines.push((format!("{bits} bits"), vec![share, expected, n as f64]));
    }
    Ok(Study {
        name: "subpixel",
        scene: None,
        about: "share of samples of triangles of some pixels that differ from the unsnapped ones",
        columns: ["share", "expected", "samples"].map(String::from).to_vec(),
        lines,
        claims,
    })
}

/// Whether `n_wrong` of `n` is the `expected` share, as far as so many tell: within twice the square root of what
/// is counted.
fn as_expected(n_wrong: usize, n: usize, expected: f64) -> Outcome {
    let (found, expected) = (n_wrong as f64, expected * n as f64);
    Outcome::exactly((found - expected).abs() <= 2.0 * found.sqrt())
}

/// The scene, its view, and the corners of each triangle on the screen, px.
fn small_triangles() -> Result<(Prepared, View, Vec<[DVec2; 3]>), Failure> {
    // A scene with a material, a node and one object, whose mesh is changed for another.
    let mut scene: Scene = synth("sphere:3").map_err(Failure::usage)?;
    let mut random = Random(1);
    let mut positions = Vec::new();
    let n = SIDE / CELL;
    for cell in 0..n * n {
        let corner = DVec2::new(f64::from(cell % n), f64::from(cell / n)) * f64::from(CELL);
        let mut place = || corner + f64::from(CELL) * DVec2::new(random.next(), random.next());
        let mut of_one = [place(), place(), place()];
        // Seen from the front: counter-clockwise with y up, as the rows count down.
        if (of_one[1] - of_one[0]).perp_dot(of_one[2] - of_one[0]) > 0.0 {
            of_one.swap(1, 2);
        }
        let half = 0.5 * f64::from(SIDE);
        positions.extend(of_one.map(|p| Vec3::new((p.x - half) as f32, (half - p.y) as f32, 0.0)));
    }
    let triangles =
        (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    scene.objects.truncate(1);
    let object = &mut scene.objects[0];
    object.world_from_model = DAffine3::IDENTITY;
    scene.meshes[object.mesh] =
        Mesh { name: "small triangles".into(), positions, triangles, ..Mesh::default() };
    let lens = Projection::Orthographic { height: f64::from(SIDE), near: 0.0, far: 2.0 };
    let camera = Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, lens).map_err(Failure::usage)?;
    let view = View::new(&camera, Viewport::new(SIDE, SIDE)?);
    let mesh = &scene.meshes[scene.objects[0].mesh];
    let on_screen = |i: u32| {
        let point = view.project(mesh.positions[i as usize].as_dvec3());
        DVec2::new(point.x, point.y)
    };
    let corners = mesh.triangles.iter().map(|corners| corners.map(on_screen)).collect();
    Ok((Prepared::new(scene)?, view, corners))
}

/// Triangle number + 1 by pixel, 0 where none is.
fn ideal(corners: &[[DVec2; 3]]) -> Vec<u32> {
    let mut ids = vec![0; (SIDE * SIDE) as usize];
    for (id, [a, b, c]) in (1..).zip(corners) {
        let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
        let pixels =
            |low: f64, high: f64| low.floor().max(0.0) as u32..(high.ceil() as u32).min(SIDE);
        for y in pixels(low.y, high.y) {
            for x in pixels(low.x, high.x) {
                let p = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let inside = |from: &DVec2, to: &DVec2| (*to - *from).perp_dot(p - *from) < 0.0;
                if inside(a, b) && inside(b, c) && inside(c, a) {
                    ids[(y * SIDE + x) as usize] = id;
                }
            }
        }
    }
    ids
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finer_grids_change_less_and_the_finest_nothing() {
        let study = study().unwrap_or_else(|failure| panic!("{failure:?}"));
        let shares: Vec<f64> = study.lines.iter().map(|(_, values)| values[0]).collect();
        assert!(shares.windows(2).all(|pair| pair[1] < 0.25 * pair[0]), "{shares:?}");
        assert!(shares[0] > 1e-3 && shares[0] < 0.1, "{shares:?}");
    }

    #[test]
    fn counts_are_judged_as_far_as_they_tell() {
        assert_eq!(as_expected(1000, 100_000, 0.01), Outcome::Confirmed);
        assert_eq!(as_expected(1050, 100_000, 0.01), Outcome::Confirmed);
        assert_eq!(as_expected(1100, 100_000, 0.01), Outcome::Refuted);
        assert_eq!(as_expected(900, 100_000, 0.01), Outcome::Refuted);
        assert_eq!(as_expected(0, 10_000, 0.0), Outcome::Confirmed);
        assert_eq!(as_expected(1, 10_000, 0.000_01), Outcome::Confirmed);
        assert_eq!(as_expected(5, 10_000, 0.0), Outcome::Refuted);
    }
}
