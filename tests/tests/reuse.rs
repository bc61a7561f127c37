//! Renderers and frames used again: nothing of one picture shows in the next.

use cullet::transform::{View, Viewport};
use cullet::{Antialias, Frame, Pass, Passes, Projection, RendererKind, Resolution, Settings};
use cullet_tests::{all_passes, bytes, cameras, prepare_file, render, shipped_scenes};

const SIZE: [u32; 2] = [100, 60];

#[test]
fn a_used_frame_shows_nothing_of_what_was_in_it() {
    let plain = Settings { passes: all_passes(), ..Settings::default() };
    let ways = [
        plain,
        Settings { antialias: Antialias::None, ..plain },
        Settings { antialias: Antialias::Ssaa4, ..plain },
        Settings { resolution: Resolution::Half, ..plain },
        Settings { resolution: Resolution::Adaptive, ..plain },
        Settings { accumulate: 4, ..plain },
        Settings { renderer: RendererKind::Raycast { snapped: true }, ..plain },
        Settings { passes: Passes::NONE.with(Pass::Depth), ..plain },
        Settings { passes: Passes::COLOR, ..plain },
    ];
    let path = shipped_scenes().into_iter().find(|path| path.ends_with("masks.glb"));
    let prepared = prepare_file(&path.expect("a scene with much sky"));
    // Two that see much, the second from near, so that triangles are clipped, and one without perspective.
    let all = cameras(&prepared);
    let is_flat = |lens: &Projection| matches!(lens, Projection::Orthographic { .. });
    let flat = all.iter().position(|camera| is_flat(&camera.projection()));
    let views = [all[0], all[all.len() - 4], all[flat.expect("one without perspective")]];
    let viewport = Viewport::new(SIZE[0], SIZE[1]).expect("a possible size");
    let (mut renderer, mut frame) = (cullet::Renderer::default(), Frame::default());
    for settings in &ways {
        for camera in views.iter().cycle().take(5) {
            renderer.render(&prepared, &View::new(camera, viewport), settings, &mut frame);
            let fresh = render(&prepared, camera, SIZE, settings);
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
}
