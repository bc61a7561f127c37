//! A light at a point, hung up where it shows in any scene.
//!
//! It hangs between the eye and what is in the middle of the picture, three quarters of the way, and
//! is as bright there as the sun. Its reach counts in the distance from the eye to the middle: with
//! a reach of 1/4 it would just fail to touch it.

use cullet::{Frame, Pass, Passes, PointLight, Prepared, Region, Renderer, Settings, View};
use glam::{DVec3, Vec3};

/// Linear.
const COLOR: Vec3 = Vec3::new(1.0, 0.7, 0.4);

/// Of the way from the eye to the middle of the picture.
const WAY: f64 = 0.75;

/// Where the light hangs in one view of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    position_world: DVec3,
    /// From the eye to what is in the middle of the picture, scene units, above 0.
    distance: f64,
}

/// A light of this reach, infinity included, that [`Lamp::hang`] still has to hang up.
pub fn of_reach(reach: f32) -> Option<PointLight> {
    PointLight::new(DVec3::ZERO, COLOR, reach).ok()
}

impl Lamp {
    /// Looks for what is in the middle of the picture; where nothing is, the middle of the scene serves.
    pub fn find(prepared: &Prepared, view: &View) -> Lamp {
        let (width, height) = (view.viewport().width(), view.viewport().height());
        let middle = Region { x: width / 2, y: height / 2, width: 1, height: 1 };
        let passes = Passes::NONE.with(Pass::Depth).with(Pass::Position);
        let settings = Settings { passes, region: Some(middle), ..Settings::default() };
        let mut frame = Frame::default();
        Renderer::default().render(prepared, view, &settings, &mut frame);
        let target = match frame.depth[0].is_finite() {
            true => frame.position[0].as_dvec3(),
            false if prepared.bounds().is_empty() => DVec3::ZERO,
            false => prepared.bounds().center(),
        };
        let eye = view.camera().eye();
        let distance = (target - eye).length();
        let distance = if distance > 0.0 && distance.is_finite() { distance } else { 1.0 };
        Lamp { position_world: eye + (target - eye) * WAY, distance }
    }

    /// Puts the light of `settings`, if they have one, in its place, its reach in scene units and as
    /// bright as it has to be there.
    pub fn hang(&self, settings: &mut Settings) {
        let Some(light) = settings.point_light else { return };
        let gap = (1.0 - WAY) * self.distance;
        let color = light.color() * (gap * gap + 1.0) as f32;
        let radius = light.radius() * self.distance as f32;
        // Beyond the range of numbers there is no light to hang up.
        settings.point_light = PointLight::new(self.position_world, color, radius).ok();
    }
}

#[cfg(test)]
mod tests {
    use cullet::frame_scene;
    use cullet::scene::synth::synth;
    use cullet::{Shading, Viewport};

    use super::*;

    #[test]
    fn it_lights_what_is_in_the_middle() {
        for name in ["sphere:16", "box-grid:3", "masks"] {
            let prepared = Prepared::new(synth(name).unwrap()).unwrap();
            let viewport = Viewport::new(65, 49).unwrap();
            let view = View::new(&frame_scene(&prepared, viewport.aspect()), viewport);
            let lamp = Lamp::find(&prepared, &view);
            let draw = |reach| {
                let point_light = of_reach(reach);
                let mut settings = Settings { point_light, ..Settings::default() };
                assert_eq!(settings.shading, Shading::Lambert);
                lamp.hang(&mut settings);
                let mut frame = Frame::default();
                Renderer::default().render(&prepared, &view, &settings, &mut frame);
                frame
                    .rgba8
                    .iter()
                    .map(|[r, g, b, _]| u64::from(*r) + u64::from(*g) + u64::from(*b))
                    .sum()
            };
            let [none, near, far, endless]: [u64; 4] = [0.0, 0.5, 2.0, f32::INFINITY].map(draw);
            assert!(
                none < near && near < far && far < endless,
                "{name}: {none} {near} {far} {endless}"
            );
        }
    }

    #[test]
    fn settings_without_a_light_stay_as_they_are() {
        let lamp = Lamp { position_world: DVec3::ONE, distance: 2.0 };
        let mut settings = Settings::default();
        lamp.hang(&mut settings);
        assert_eq!(settings.point_light, None);
        settings.point_light = of_reach(0.5);
        lamp.hang(&mut settings);
        let light = settings.point_light.unwrap();
        assert_eq!((light.position(), light.radius()), (DVec3::ONE, 1.0));
        assert_eq!(light.color(), COLOR * 1.25);
    }
}
