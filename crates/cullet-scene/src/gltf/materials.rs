//! What colour does each material have?
//!
//! Only base colours so far. Specular-glossiness materials lend their diffuse colour.

use std::collections::BTreeMap;

use ::gltf::json::material::AlphaMode as AlphaModeJson;
use ::gltf::json::mesh::Primitive;
use ::gltf::json::texture::{Info, MagFilter, MinFilter, Sampler as SamplerJson, WrappingMode};
use ::gltf::json::validation::Checked;
use glam::{Affine2, Mat2, Vec2, Vec4};

use super::{Input, Output, document, name_or};
use crate::{AlphaMode, Image, Material, Sampler, Texture, TextureRef, Wrap};

/// Adds all materials (file index + 1), the textures of their base colours, and all images,
/// still empty.
pub(super) fn load(input: &Input<'_>, output: &mut Output) {
    let root = &input.document.root;
    for (i, image) in root.images.iter().enumerate() {
        let uri = image.uri.as_ref().filter(|uri| !uri.starts_with("data:") && uri.len() < 256);
        let name = name_or(&image.name.clone().or(uri.cloned()), "image", i);
        output.scene.images.push(Image { name, ..Image::default() });
    }
    let mut textures = BTreeMap::new();
    for (i, json) in root.materials.iter().enumerate() {
        let name = name_or(&json.name, "material", i);
        let extensions = json.extensions.as_ref();
        let (factor, info) = match extensions.and_then(|all| all.pbr_specular_glossiness.as_ref()) {
            Some(old) => (old.diffuse_factor.0, old.diffuse_texture.as_ref()),
            None => {
                let pbr = &json.pbr_metallic_roughness;
                (pbr.base_color_factor.0, pbr.base_color_texture.as_ref())
            }
        };
        let place = format!("material `{name}`");
        let mut base_color = Vec4::from_array(factor);
        if !base_color.is_finite() {
            output.warn(&place, "has a base colour that is not finite; white is used");
            base_color = Vec4::ONE;
        }
        let base_color_texture =
            info.and_then(|info| texture_ref(input, output, &mut textures, &place, info));
        output.scene.materials.push(Material {
            name,
            base_color,
            base_color_texture,
            alpha: match json.alpha_mode {
                Checked::Valid(AlphaModeJson::Mask) => {
                    AlphaMode::Mask { cutoff: json.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0) }
                }
                Checked::Valid(AlphaModeJson::Blend) => AlphaMode::Blend,
                _ => AlphaMode::Opaque,
            },
            double_sided: json.double_sided,
            unlit: extensions.is_some_and(|all| all.unlit.is_some()),
        });
    }
}

/// Index in the scene of the material of a primitive.
pub(super) fn index(json: &Primitive) -> usize {
    json.material.map_or(0, |material| material.value() + 1)
}

/// Warns about what the materials that are drawn cannot show yet.
pub(super) fn warn_about_blending(output: &mut Output, used: &[bool]) {
    for i in (0..used.len()).filter(|&i| used[i]) {
        let material = &output.scene.materials[i];
        if material.alpha == AlphaMode::Blend {
            let place = format!("material `{}`", material.name);
            output.warn(&place, "is meant to be blended; drawn as opaque");
        }
    }
}

/// Lists the textures of drawn materials that no shading reads yet. They are not decoded.
pub(super) fn leave_out_other_textures(input: &Input<'_>, output: &mut Output, used: &[bool]) {
    for (json, _) in input.document.root.materials.iter().zip(&used[1..]).filter(|pair| *pair.1) {
        let gloss = json.extensions.as_ref().and_then(|all| all.pbr_specular_glossiness.as_ref());
        let others = [
            json.pbr_metallic_roughness.metallic_roughness_texture.is_some(),
            gloss.is_some_and(|gloss| gloss.specular_glossiness_texture.is_some()),
            json.normal_texture.is_some(),
            json.occlusion_texture.is_some(),
            json.emissive_texture.is_some(),
        ];
        others.into_iter().filter(|other| *other).for_each(|_| output.leave_out(OTHER_TEXTURES));
    }
}

const OTHER_TEXTURES: &str = "textures other than base colours";

fn texture_ref(
    input: &Input<'_>,
    output: &mut Output,
    textures: &mut BTreeMap<usize, Option<usize>>,
    place: &str,
    info: &Info,
) -> Option<TextureRef> {
    let key = info.index.value();
    let texture = match textures.get(&key) {
        Some(known) => *known,
        None => {
            let made = texture(input, output, key);
            textures.insert(key, made);
            made
        }
    };
    let Some(texture) = texture else {
        output.warn(place, format_args!("uses texture {key}, which has no image; left out"));
        return None;
    };
    let json = info.extensions.as_ref().and_then(|all| all.texture_transform.as_ref());
    let uv_set = json.and_then(|json| json.tex_coord).unwrap_or(info.tex_coord);
    if uv_set > 1 {
        output.warn(place, format_args!("uses texture coordinates {uv_set}; texture left out"));
        return None;
    }
    let transform = json
        .map(|json| transform(json.offset.0, json.rotation.0, json.scale.0))
        .filter(|transform| *transform != Affine2::IDENTITY);
    if transform.is_some_and(|transform| !transform.is_finite()) {
        output.warn(place, "has a texture transform that is not finite; texture left out");
        return None;
    }
    Some(TextureRef { texture, uv_set: uv_set as usize, transform })
}

/// Scale, then rotation, then offset. Positive angles turn u towards -v, which looks
/// counter-clockwise because v grows downwards.
fn transform(offset: [f32; 2], angle: f32, scale: [f32; 2]) -> Affine2 {
    let (sin, cos) = libm::sincos(f64::from(angle));
    let (sin, cos) = (sin as f32, cos as f32);
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let scale = Mat2::from_diagonal(Vec2::from_array(scale));
    Affine2::from_mat2_translation(rotation * scale, Vec2::from_array(offset))
}

/// Adds texture `index` to the scene, unless it has no image that can be drawn.
fn texture(input: &Input<'_>, output: &mut Output, index: usize) -> Option<usize> {
    let root = &input.document.root;
    let json = root.textures.get(index)?;
    let webp = json.extensions.as_ref().and_then(|all| all.others.get("EXT_texture_webp"));
    let webp = webp
        .and_then(|webp| document::whole_number(webp.get("source")?))
        .map(|source| source as usize);
    let n_images = output.scene.images.len();
    let image = [webp, Some(json.source.value())].into_iter().flatten().find(|&i| i < n_images)?;
    let sampler = json.sampler.and_then(|sampler| root.get(sampler)).map(sampler);
    let texture = Texture { image, sampler: sampler.unwrap_or_default() };
    output.scene.textures.push(texture);
    Some(output.scene.textures.len() - 1)
}

fn sampler(json: &SamplerJson) -> Sampler {
    use MinFilter::{Nearest, NearestMipmapLinear, NearestMipmapNearest};
    let nearest_min =
        |filter| matches!(filter, Nearest | NearestMipmapLinear | NearestMipmapNearest);
    Sampler {
        wrap_u: wrap(json.wrap_s),
        wrap_v: wrap(json.wrap_t),
        nearest_mag: matches!(json.mag_filter, Some(Checked::Valid(MagFilter::Nearest))),
        nearest_min: matches!(json.min_filter, Some(Checked::Valid(filter)) if nearest_min(filter)),
    }
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_transforms_scale_then_turn_then_move() {
        let quarter = std::f32::consts::FRAC_PI_2;
        let moved = transform([10.0, 20.0], quarter, [2.0, 3.0]);
        // u = 1 becomes 2, turns to v = -2, and moves to (10, 18).
        assert!((moved.transform_point2(Vec2::X) - Vec2::new(10.0, 18.0)).length() < 1e-6);
        assert!((moved.transform_point2(Vec2::Y) - Vec2::new(13.0, 20.0)).length() < 1e-6);
    }
}
