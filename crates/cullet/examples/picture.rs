//! The whole library in one page: a scene in, a PNG out.
//!
//! `cargo run --release -p cullet --example picture -- scenes/showpiece.glb picture.png`

use std::path::Path;

use cullet::{Frame, Prepared, Renderer, Settings, View, Viewport, frame_scene, scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(input), Some(output)) = (arguments.next(), arguments.next()) else {
        return Err("usage: picture SCENE OUT.png".into());
    };
    let scene = scene::load(Path::new(&input), &scene::LoadOptions::default())?;
    let prepared = Prepared::new(scene)?;
    let viewport = Viewport::new(1280, 720)?;
    let view = View::new(&frame_scene(&prepared, viewport.aspect()), viewport);

    let mut frame = Frame::default();
    let stats = Renderer::default().render(&prepared, &view, &Settings::default(), &mut frame);
    println!("{:?}: {stats:#?}", stats.total);

    image::save_buffer(
        output,
        frame.rgba8.as_flattened(),
        frame.width,
        frame.height,
        image::ColorType::Rgba8,
    )?;
    Ok(())
}
