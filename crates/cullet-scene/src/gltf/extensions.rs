//! What does Cullet make of each extension?

use std::collections::BTreeSet;

use ::gltf::json::{Root, Texture};

use crate::{Extension, LoadError, Treatment};

/// Lists the extensions that a file names, or refuses the file for one that it requires
/// and Cullet lacks.
pub(super) fn treat(
    name: &str,
    used: &[String],
    required: &[String],
) -> Result<Vec<Extension>, LoadError> {
    let mut extensions: Vec<Extension> = Vec::new();
    let mut met = BTreeSet::new();
    let all = required.iter().map(|name| (name, true)).chain(used.iter().map(|name| (name, false)));
    for (extension, required) in all.filter(|(name, _)| met.insert(*name)) {
        let treatment = match treatment(extension) {
            Some(treatment) => treatment,
            None if required => return Err(unsupported(name, extension)),
            None => Treatment::Ignored,
        };
        extensions.push(Extension { name: extension.clone(), required, treatment });
    }
    Ok(extensions)
}

/// Refuses a file that requires an image format which Cullet lacks, unless every texture
/// has a fallback.
pub(super) fn check_textures(
    name: &str,
    root: &Root,
    extensions: &[Extension],
) -> Result<(), LoadError> {
    let is_needed = |known: &&Extension| known.required && is_image_format(&known.name);
    for Extension { name: extension, .. } in extensions.iter().filter(is_needed) {
        let lacks_fallback = |texture: &Texture| {
            let extensions = texture.extensions.as_ref();
            let named = extensions.is_some_and(|all| all.others.contains_key(extension.as_str()));
            named && texture.source.value() >= root.images.len()
        };
        if root.textures.iter().any(lacks_fallback) {
            return Err(unsupported(name, extension));
        }
    }
    Ok(())
}

fn is_image_format(extension: &str) -> bool {
    matches!(extension, "KHR_texture_basisu" | "EXT_texture_avif" | "MSFT_texture_dds")
}

/// The refusal of a file that cannot be drawn without `extension`.
pub(super) fn unsupported(name: &str, extension: &str) -> LoadError {
    let remedy = match extension {
        DRACO | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "save the model again without mesh compression"
        }
        _ if is_image_format(extension) => "save the model again with PNG, JPEG or WebP images",
        _ => "save the model again without it",
    };
    LoadError::Unsupported { path: name.into(), extension: extension.into(), remedy: remedy.into() }
}

/// The name of Draco compression, which replaces the data of a primitive.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// `None`: a file that requires it is refused.
///
/// Image formats count as known, because textures may have a fallback; see
/// [`check_textures`].
fn treatment(extension: &str) -> Option<Treatment> {
    Some(match extension {
        "EXT_mesh_gpu_instancing"
        | "EXT_texture_webp"
        | "KHR_materials_unlit"
        | "KHR_mesh_quantization"
        | "KHR_node_visibility"
        | "KHR_texture_transform" => Treatment::Supported,
        "KHR_materials_variants"
        | "EXT_lights_ies"
        | "EXT_lights_image_based"
        | "CESIUM_primitive_outline"
        | "FB_ngon_encoding"
        | "KHR_animation_pointer"
        | "KHR_lights_punctual"
        | "KHR_node_hoverability"
        | "KHR_node_selectability"
        | "KHR_xmp"
        | "KHR_xmp_json_ld"
        | "MSFT_lod" => Treatment::Ignored,
        _ if is_image_format(extension) => Treatment::Ignored,
        _ if KNOWN_MATERIALS.contains(&extension) => Treatment::Approximated,
        _ => return None,
    })
}

/// Materials whose base colour Cullet draws, without what makes them special.
const KNOWN_MATERIALS: &[&str] = &[
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
];

#[cfg(test)]
mod tests {
    use super::*;

    fn check(used: &[&str], required: &[&str]) -> Result<Vec<Extension>, LoadError> {
        let owned = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        treat("a.glb", &owned(used), &owned(required))
    }

    #[test]
    fn a_required_unknown_extension_is_named() {
        let error = check(&["X_y", DRACO], &[DRACO]).unwrap_err().to_string();
        assert!(error.contains(DRACO) && error.contains("without mesh compression"), "{error}");
    }

    #[test]
    fn an_optional_unknown_extension_is_ignored_and_listed_once() {
        let listed = check(&["X_y", "KHR_materials_ior", "X_y"], &["KHR_materials_ior"]).unwrap();
        assert_eq!(listed.len(), 2);
        assert_eq!(listed[0].treatment, Treatment::Approximated);
        assert_eq!((listed[1].treatment, listed[1].required), (Treatment::Ignored, false));
    }

    /// Quadratic work on this takes minutes.
    #[test]
    fn many_extensions_are_listed_in_their_order() {
        let names: Vec<String> = (0..100_000).map(|i| format!("X_{}", i % 90_000)).collect();
        let listed = treat("a.glb", &names, &[]).unwrap();
        assert!(listed.iter().map(|extension| &extension.name).eq(&names[..90_000]));
    }
}
