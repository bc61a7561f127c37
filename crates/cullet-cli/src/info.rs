//! `cullet info`: what is in a scene, and what becomes of it.

use clap::Args;
use cullet::cull::Aabb;
use cullet::scene::{Images, Lens, Scene, SceneCamera, Treatment};
use cullet::shade::{Needs, Shading};
use cullet_measure::{Align, Table};
use glam::DVec3;
use serde_json::{Value, json};

use crate::exit::Failure;
use crate::message::one_line;
use crate::numbers::Number;
use crate::output::print;
use crate::source::Source;
use crate::stats;

/// Say what a scene holds, needs and loses.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    #[command(flatten)]
    source: Source,
    /// Write JSON
    #[arg(long)]
    json: bool,
}

/// Prints everything there is to know.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let info = describe(&args.source.load(0, Images::BaseColors)?.0);
    if args.json { print(&stats::json(&info)) } else { print(text(&info).as_bytes()) }
}

fn describe(scene: &Scene) -> Value {
    let bounds = bounds(scene);
    let corner = |corner: DVec3| corner.to_array().map(Number);
    let n_triangles: usize =
        scene.objects.iter().map(|o| scene.meshes[o.mesh].triangles.len()).sum();
    json!({
        "schema": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "name": scene.name,
        "bounds": (!bounds.is_empty())
            .then(|| json!({ "min": corner(bounds.min), "max": corner(bounds.max) })),
        "counts": {
            "objects": scene.objects.len(),
            "nodes": scene.nodes.len(),
            "meshes": scene.meshes.len(),
            "triangles": n_triangles,
            "triangles_stored": scene.meshes.iter().map(|m| m.triangles.len()).sum::<usize>(),
            "vertices_stored": scene.meshes.iter().map(|m| m.positions.len()).sum::<usize>(),
            "materials": scene.materials.len(),
            "textures": scene.textures.len(),
            "images": scene.images.len(),
            "cameras": scene.cameras.len(),
            "animations": scene.animations.len(),
        },
        "needs": needs(scene),
        "cameras": scene.cameras.iter().enumerate().map(camera).collect::<Vec<_>>(),
        "animations": scene.animations,
        "images": scene.images.iter().map(image).collect::<Vec<_>>(),
        "extensions": scene.extensions.iter().map(|extension| json!({
            "name": extension.name,
            "required": extension.required,
            "treatment": match extension.treatment {
                Treatment::Supported => "supported",
                Treatment::Approximated => "approximated",
                Treatment::Ignored => "ignored",
            },
        })).collect::<Vec<_>>(),
        "left_out": scene.left_out,
        "warnings": scene.warnings,
    })
}

/// The box around every corner of a triangle, world space, without the margin that boxes for
/// culling have.
fn bounds(scene: &Scene) -> Aabb {
    let corners = scene.objects.iter().flat_map(|object| {
        let mesh = &scene.meshes[object.mesh];
        let corners = mesh.triangles.iter().flatten().map(|&i| mesh.positions[i as usize]);
        corners.map(|corner| object.world_from_model.transform_point3(corner.as_dvec3()))
    });
    Aabb::from_points(corners)
}

/// How many objects need what, when lit.
fn needs(scene: &Scene) -> Value {
    let count = |need| {
        let objects = scene.objects.iter();
        let needs = objects.map(|object| {
            let (mesh, material) = (&scene.meshes[object.mesh], &scene.materials[object.material]);
            Needs::of(mesh, material, Shading::Lambert)
        });
        needs.filter(|needs| needs.contains(need)).count()
    };
    json!({
        "light": count(Needs::LIT),
        "smooth_normals": count(Needs::SMOOTH_NORMAL),
        "textures": count(Needs::TEXTURE),
        "texture_transforms": count(Needs::UV_TRANSFORM),
        "vertex_colors": count(Needs::VERTEX_COLOR),
        "alpha_masks": count(Needs::MASK),
    })
}

fn image(image: &cullet::scene::Image) -> Value {
    // Images that no drawn object needs are not read and have no size.
    let side = |pixels: u32| (pixels > 0).then_some(pixels);
    json!({
        "name": image.name,
        "width": side(image.width),
        "height": side(image.height),
        "placeholder": image.placeholder,
    })
}

fn camera((index, camera): (usize, &SceneCamera)) -> Value {
    let far = |far: f64| far.is_finite().then_some(Number(far));
    let lens = match camera.lens {
        Lens::Perspective { yfov, near, far: zfar, .. } => json!({
            "kind": "perspective",
            "yfov_deg": Number(yfov.to_degrees()),
            "znear": Number(near),
            "zfar": far(zfar),
        }),
        Lens::Orthographic { ymag, near, far: zfar, .. } => json!({
            "kind": "orthographic",
            "ortho_height": Number(2.0 * ymag),
            "znear": Number(near),
            "zfar": far(zfar),
        }),
    };
    let eye = camera.world_from_camera.translation.to_array().map(Number);
    json!({ "index": index, "name": camera.name, "eye": eye, "lens": lens })
}

/// The same for people: a table of counts, then everything that has a name.
fn text(info: &Value) -> String {
    let mut table = Table::new(&[("scene", Align::Left), (&plain(&info["name"]), Align::Right)]);
    let rows = |value: &Value| -> Vec<(String, String)> {
        let entries = value.as_object().into_iter().flatten();
        entries.map(|(key, value)| (key.replace('_', " "), plain(value))).collect()
    };
    for (key, value) in rows(&info["counts"]) {
        table.push([key, value]);
    }
    for (key, value) in rows(&info["needs"]) {
        table.push([format!("objects with {key}"), value]);
    }
    for (key, value) in rows(&info["bounds"]) {
        table.push([format!("bounds {key}"), value]);
    }
    let mut text = table.to_string();
    let mut list = |title: &str, lines: Vec<String>| {
        if !lines.is_empty() {
            text += &format!("\n{title}\n");
            lines.iter().for_each(|line| text += &format!("  {}\n", one_line(line)));
        }
    };
    let each = |key: &str, line: fn(&Value) -> String| -> Vec<String> {
        info[key].as_array().into_iter().flatten().map(line).collect()
    };
    list(
        "cameras",
        each("cameras", |c| {
            format!("{} `{}` {}", c["index"], plain(&c["name"]), plain(&c["lens"]["kind"]))
        }),
    );
    list(
        "extensions",
        each("extensions", |e| {
            let required = if e["required"] == true { ", required" } else { "" };
            format!("{}: {}{required}", plain(&e["name"]), plain(&e["treatment"]))
        }),
    );
    list("animations", each("animations", plain));
    list(
        "images",
        each("images", |i| {
            let name = plain(&i["name"]);
            if i["width"].is_null() {
                return format!("`{name}` not read");
            }
            let note = if i["placeholder"] == true { ", unreadable" } else { "" };
            format!("`{name}` {}x{}{note}", i["width"], i["height"])
        }),
    );
    list("left out", each("left_out", plain));
    list("warnings", each("warnings", plain));
    text
}

/// A value without quotes and brackets.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => one_line(text),
        Value::Array(values) => values.iter().map(plain).collect::<Vec<_>>().join(", "),
        value => value.to_string(),
    }
}
