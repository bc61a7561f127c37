//! Renderers and frames used again: nothing of one picture shows in the next.

use cullet::cull::wide::levels;
use cullet::transform::{View, Viewport};
use cullet::{
    Antialias, Camera, Frame, Pass, Passes, Projection, Region, RendererKind, Resolution, Settings,
    SubpixelBits,
};
use cullet_tests::{all_passes, bytes, cameras, prepare_file, render, shipped_scenes};
use glam::DVec3;

/// Several tiles and bands each, whole and not, and one in the other's memory.
const SIZES: [[u32; 2]; 2] = [[150, 101], [97, 130]];

#[test]
fn a_used_frame_shows_nothing_of_what_was_in_it() {
    let plain = Settings { passes: all_passes(), tile_px: 24, ..Settings::default() };
    let (_, fallback) = *levels().last().expect("plain code is always there");
    let ways = [
        plain,
        Settings { tile_px: 64, ..plain },
        Settings { antialias: Antialias::None, ..plain },
        Settings { antialias: Antialias::Msaa2, ..plain },
        Settings { antialias: Antialias::Msaa8, ..plain },
        Settings { subpixel_bits: SubpixelBits::Four, ..plain },
        Settings { simd: fallback, ..plain },
        Settings { antialias: Antialias::Ssaa4, ..plain },
        Settings { resolution: Resolution::Half, ..plain },
        Settings { resolution: Resolution::Adaptive, ..plain },
        Settings { accumulate: 4, ..plain },
        Settings { renderer: RendererKind::Raycast { snapped: true }, ..plain },
        Settings { region: Some(Region { x: 13, y: 30, width: 61, height: 50 }), ..plain },
        Settings { passes: Passes::NONE.with(Pass::Depth), ..plain },
        Settings { passes: Passes::COLOR, ..plain },
    ];
    let path = shipped_scenes().into_iter().find(|path| path.ends_with("masks.glb"));
    let prepared = prepare_file(&path.expect("a scene with much sky"));
    // One that sees much, one whose near plane cuts all in two, and one without perspective.
    let all = cameras(&prepared);
    let (middle, radius) = (prepared.bounds().center(), prepared.bounds().half_extent().length());
    let direction = DVec3::new(0.9, 0.3, 1.1);
    let near = radius * direction.length();
    let cutting = Projection::Perspective { yfov: 0.8, near, far: f64::INFINITY };
    let cutting = Camera::look_at(middle + direction * radius, middle, DVec3::Y, cutting);
    let is_flat = |camera: &&Camera| matches!(camera.projection(), Projection::Orthographic { .. });
    let flat = all.iter().find(is_flat).expect("one without perspective");
    let views = [all[0], cutting.expect("a possible camera"), *flat];
    let (mut renderer, mut frame) = (cullet::Renderer::default(), Frame::default());
    let mut n_clipped = 0;
    for settings in &ways {
        let sizes = SIZES.into_iter().cycle();
        for (camera, size) in views.iter().cycle().zip(sizes).take(6) {
            let viewport = Viewport::new(size[0], size[1]).expect("a possible size");
            let view = View::new(camera, viewport);
            let stats = renderer.render(&prepared, &view, settings, &mut frame);
            n_clipped += stats.triangles.n_clipped;
            let fresh = render(&prepared, camera, size, settings);
            assert!(bytes(&frame) == bytes(&fresh), "{settings:?}");
            // What is there before the next picture is nobody's.
            frame.depth.fill(-1.0);
            frame.normal.fill(glam::Vec3::NAN);
            frame.albedo.fill(glam::Vec4::NAN);
            frame.uv.fill(glam::Vec2::NAN);
            frame.position.fill(glam::Vec3::NAN);
            frame.id.fill(77);
            frame.triangle.fill(77);
            frame.rgba8.fill([7; 4]);
            frame.linear.fill(glam::Vec4::NAN);
        }
    }
    assert!(n_clipped > 0);
}
