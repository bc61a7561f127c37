//! The rasterizer against its plain twin, the ray caster.

use std::path::Path;

use cullet::raster::{DepthFormat, ReversedF32, snap};
use cullet::scene::{AlphaMode, LoadOptions, load};
use cullet::transform::{ClipPoint, View, Viewport};
use cullet::{Antialias, Camera, CullTest, Frame, Prepared, RendererKind, Settings};
use cullet_tests::{all_passes, cameras, long_mode, prepare, prepare_file, real_models, render};
use glam::{DVec2, DVec3};

const SIZE: [u32; 2] = [160, 90];

/// Ids may differ this close to an edge, px.
const EDGE: f64 = 0.004;

/// Where a cutoff moved by this decides otherwise, the two may decide differently: the places where they ask
/// a texture are this accurate, times how steep its alpha is.
const CUTOFF: f32 = 1e-5;

/// How often they may.
const MAX_AT_CUTOFF: f64 = 0.000_1;

/// How often the two may tell a tie or an edge differently before something is wrong.
const MAX_DIFFERING: f64 = 0.002;

/// The twin is asked without culling, so that a false cull shows.
fn frame(prepared: &Prepared, camera: &Camera, renderer: RendererKind) -> Frame {
    let cull = if renderer == RendererKind::Raster { CullTest::Both } else { CullTest::None };
    let settings = Settings {
        passes: all_passes(),
        renderer,
        cull,
        antialias: Antialias::None,
        ..Settings::default()
    };
    render(prepared, camera, SIZE, &settings)
}

/// What two pictures of one view have in common.
#[derive(Debug, Default)]
struct Comparison {
    n_pixels: usize,
    n_differing: usize,
    /// Of those, where alpha is as good as at its cutoff.
    n_at_cutoff: usize,
}

/// Pixels that show different triangles must lie on an edge of one of them, or the two must be
/// equally near, or alpha as good as at its cutoff; all others must agree in every channel.
#[track_caller]
fn check(name: &str, path: &Path) {
    let prepared = &prepare_file(path);
    let cameras = some_cameras(prepared);
    let mut seen = Comparison::default();
    let mut unsnapped = 0;
    for (i, camera) in cameras.iter().enumerate() {
        let view = View::new(camera, Viewport::new(SIZE[0], SIZE[1]).unwrap());
        let raster = frame(prepared, camera, RendererKind::Raster);
        let cast = frame(prepared, camera, RendererKind::Raycast { snapped: true });
        let ideal = frame(prepared, camera, RendererKind::Raycast { snapped: false });
        let place = format!("{name}, camera {i}");
        seen.n_pixels += raster.len();
        for pixel in 0..raster.len() {
            let (a, b) = (raster.triangle[pixel], cast.triangle[pixel]);
            unsnapped += usize::from(a != ideal.triangle[pixel]);
            if a == b {
                channels_agree(&place, pixel, &raster, &cast);
                continue;
            }
            seen.n_differing += 1;
            let excused = [a, b].into_iter().any(|id| is_near_edge(prepared, &view, id, pixel))
                || is_tie(&raster, &cast, &view, pixel);
            if !excused {
                let at_cutoff = is_near_cutoff(path, camera, a, pixel);
                assert!(at_cutoff, "{place}, pixel {pixel}: triangle {a} against {b}");
                seen.n_at_cutoff += 1;
            }
        }
    }
    let share = unsnapped as f64 / seen.n_pixels as f64;
    println!("{name}: {seen:?}, against unsnapped geometry {share:.5} of the pixels differ");
    let n = seen.n_differing as f64;
    assert!(n <= MAX_DIFFERING * seen.n_pixels as f64, "{name}: {seen:?}");
    let n = seen.n_at_cutoff as f64;
    assert!(n <= MAX_AT_CUTOFF * seen.n_pixels as f64, "{name}: {seen:?}");
}

#[track_caller]
fn channels_agree(place: &str, pixel: usize, raster: &Frame, cast: &Frame) {
    let (a, b) = (raster.rgba8[pixel], cast.rgba8[pixel]);
    let off = (0..4).map(|i| a[i].abs_diff(b[i])).max();
    assert!(off <= Some(2), "{place}, pixel {pixel}: {a:?} against {b:?}");
    let tolerance = 2.0 / 255.0;
    let normal = (raster.normal[pixel] - cast.normal[pixel]).abs().max_element();
    let albedo = (raster.albedo[pixel] - cast.albedo[pixel]).abs().max_element();
    assert!(
        normal <= tolerance && albedo <= tolerance,
        "{place}, pixel {pixel}: {normal} {albedo}"
    );
    let linear = (raster.linear[pixel] - cast.linear[pixel]).abs().max_element();
    assert!(linear <= tolerance, "{place}, pixel {pixel}: linear {linear}");
    let (a, b) = (raster.depth[pixel], cast.depth[pixel]);
    assert!(a == b || (a - b).abs() <= 1e-4 * a, "{place}, pixel {pixel}: depth {a} against {b}");
    // Where the surface is seen edge on, a place on it moves far per pixel: measured along the ray.
    let position = (raster.position[pixel] - cast.position[pixel]).abs().max_element();
    let reach = if a.is_finite() { a } else { 1.0 };
    assert!(position <= 1e-3 * reach, "{place}, pixel {pixel}: position off by {position}");
    let uv = (raster.uv[pixel] - cast.uv[pixel]).abs().max_element();
    assert!(uv <= 1e-2, "{place}, pixel {pixel}: uv off by {uv}");
}

/// The twin shows triangle `id - 1` with cutoffs a little lower or higher.
fn is_near_cutoff(path: &Path, camera: &Camera, id: u32, pixel: usize) -> bool {
    [-CUTOFF, CUTOFF].into_iter().any(|by| {
        let mut scene = load(path, &LoadOptions::default()).expect("a scene that was loaded");
        for material in &mut scene.materials {
            if let AlphaMode::Mask { cutoff } = &mut material.alpha {
                *cutoff += by;
            }
        }
        let cast = frame(&prepare(scene), camera, RendererKind::Raycast { snapped: true });
        cast.triangle[pixel] == id
    })
}

/// Both show something equally near, within two codes of the depth buffer.
fn is_tie(raster: &Frame, cast: &Frame, view: &View, pixel: usize) -> bool {
    let code = |distance: f32| {
        let in_view = DVec3::new(0.0, 0.0, -f64::from(distance));
        ReversedF32::encode(ClipPoint::from_model(view.clip_from_view(), in_view).ndc().depth)
    };
    let (a, b) = (code(raster.depth[pixel]), code(cast.depth[pixel]));
    a.is_finite() && b.is_finite() && a.to_bits().abs_diff(b.to_bits()) <= 2
}

/// Whether the centre of a pixel is within [`EDGE`] of the outline of triangle `id - 1` on the
/// screen, as cut by the near and far planes.
fn is_near_edge(prepared: &Prepared, view: &View, id: u32, pixel: usize) -> bool {
    let Some(id) = id.checked_sub(1) else { return false };
    let items = prepared.items();
    let item = &items[items.partition_point(|item| item.first_triangle <= id) - 1];
    let mesh = &prepared.scene().meshes[item.mesh];
    let clip_from_model = view.clip_from_model(&item.world_from_model);
    let corners = mesh.triangles[(id - item.first_triangle) as usize]
        .map(|i| ClipPoint::from_model(&clip_from_model, mesh.positions[i as usize].as_dvec3()));
    let mut outline = corners.to_vec();
    let is_cut = corners.iter().any(|p| p.z > p.w || p.z < 0.0);
    outline = cut(&outline, |p| p.w - p.z);
    outline = cut(&outline, |p| p.z);
    let on_screen = |p: &ClipPoint| {
        if is_cut {
            let screen = view.viewport().screen_from_ndc(p.ndc());
            return DVec2::new(screen.x, screen.y);
        }
        let at = snap::<8>(view.viewport(), p);
        DVec2::new(at.x as f64, at.y as f64) / 256.0
    };
    let outline: Vec<DVec2> = outline.iter().map(on_screen).collect();
    let (x, y) = (pixel as u32 % SIZE[0], pixel as u32 / SIZE[0]);
    let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    (0..outline.len()).any(|i| {
        let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
        let t = (centre - a).dot(b - a) / (b - a).length_squared();
        let nearest = if t.is_finite() { a + (b - a) * t.clamp(0.0, 1.0) } else { a };
        (nearest - centre).length() <= EDGE
    })
}

fn cut(outline: &[ClipPoint], inside: impl Fn(&ClipPoint) -> f64) -> Vec<ClipPoint> {
    let mut kept = Vec::new();
    for (i, here) in outline.iter().enumerate() {
        let next = &outline[(i + 1) % outline.len()];
        let (a, b) = (inside(here), inside(next));
        if a >= 0.0 {
            kept.push(*here);
        }
        if (a >= 0.0) != (b >= 0.0) {
            kept.push(here.lerp(next, a / (a - b)));
        }
    }
    kept
}

/// One camera of each kind: the scene's own or one beside it, one inside with an infinite far
/// plane, one inside and rolled with a finite one, an orthographic one. All of them in long mode.
fn some_cameras(prepared: &Prepared) -> Vec<Camera> {
    let mut cameras = cameras(prepared);
    if !long_mode() {
        let n = cameras.len();
        cameras = [0, n - 4, n - 3, n - 2].map(|i| cameras[i]).to_vec();
    }
    cameras
}

#[test]
fn shipped_scenes() {
    for path in cullet_tests::shipped_scenes() {
        check(&path.display().to_string(), &path);
    }
}

#[test]
fn real_scenes() {
    let Some(folder) = real_models() else { return };
    for model in
        ["FlightHelmet/FlightHelmet.gltf", "low-poly-jungle/scene.gltf", "terrain/terrain.glb"]
    {
        check(model, &folder.join("scenes").join(model));
    }
}
