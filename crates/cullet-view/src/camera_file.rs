//! The camera as a file that `cullet render --camera` reads.

use cullet::{Camera, Projection};

/// One line of JSON; numbers keep every bit. Off-centre lenses, which such a file cannot say,
/// become symmetric ones of the same height.
pub fn camera_file(camera: &Camera, width: u32, height: u32) -> String {
    let eye = camera.eye();
    let vector = |v: glam::DVec3| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    let window = camera.window(1.0);
    let lens = match camera.projection() {
        Projection::Perspective { yfov, .. } => format!("\"yfov_deg\": {:?}", yfov.to_degrees()),
        Projection::Orthographic { height, .. } => format!("\"ortho_height\": {height:?}"),
        Projection::OffCentre(window) => {
            let height = window.top - window.bottom;
            match window.kind {
                cullet::transform::Kind::Perspective => {
                    format!("\"yfov_deg\": {:?}", 2.0 * libm::atan(0.5 * height).to_degrees())
                }
                cullet::transform::Kind::Orthographic => format!("\"ortho_height\": {height:?}"),
            }
        }
    };
    let far =
        if window.far.is_finite() { format!("{:?}", window.far) } else { String::from("null") };
    format!(
        "{{\"eye\": {}, \"target\": {}, \"up\": {}, {lens}, \"znear\": {:?}, \"zfar\": {far}, \
         \"width\": {width}, \"height\": {height}}}",
        vector(eye),
        vector(eye - camera.back()),
        vector(camera.up()),
        window.near,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn files_say_everything_about_a_camera() {
        let lens = Projection::Perspective { yfov: 1.0, near: 1e-7, far: f64::INFINITY };
        let camera = Camera::look_at(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y, lens).unwrap();
        assert_eq!(
            camera_file(&camera, 64, 48),
            r#"{"eye": [0.0, 0.0, 4.0], "target": [0.0, 0.0, 3.0], "up": [0.0, 1.0, 0.0], "yfov_deg": 57.29577951308232, "znear": 1e-7, "zfar": null, "width": 64, "height": 48}"#
        );
        let flat = Projection::Orthographic { height: 2.5, near: 0.0, far: 9.0 };
        let camera = Camera::look_at(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y, flat).unwrap();
        let file = camera_file(&camera, 64, 48);
        assert!(file.contains(r#""ortho_height": 2.5, "znear": 0.0, "zfar": 9.0"#), "{file}");
    }
}
