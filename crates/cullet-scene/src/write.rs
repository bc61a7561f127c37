//! How is a scene kept? As a GLB 2.0 file: everything in [`Scene`] that a picture needs.
//!
//! Nodes keep names and hierarchy, and objects of one node become the primitives of one
//! glTF mesh, which nodes with the same primitives share. Numbers are written in the
//! shortest decimals that read back the same; the same scene gives the same bytes.
//!
//! What changes: transforms are written relative to the parent, so world matrices come
//! back with the rounding of one f64 product. Objects without triangles keep their node
//! only. Warnings, animations and the names of objects are not
//! written; loaders make up the latter from the nodes. Material 0 is the format's default
//! and is left out of the file.
//!
//! Source: Khronos Group, "glTF 2.0 Specification", 2021, sections 3 and 4; the texture
//! transform from the extension KHR_texture_transform.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

use glam::{Affine2, DAffine3, DMat4, Vec2, Vec3, Vec4};
use image::ExtendedColorType;
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use serde_json::{Map, Value, json};

use crate::{AlphaMode, Image, Lens, Material, Mesh, Sampler, Scene, TextureRef, Wrap};

/// Why a scene cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// The format holds finite numbers only.
    #[error("{what} holds NaN or infinity, which glTF cannot express")]
    NotFinite {
        /// The mesh or camera.
        what: String,
    },
    /// An image was not decoded when the scene was loaded.
    #[error("image `{name}` has no pixels; load the scene with its textures")]
    NoPixels {
        /// The image.
        name: String,
    },
    /// The picture does not fit its size, or cannot be packed.
    #[error("image `{name}` cannot be written: {problem}")]
    Image {
        /// The image.
        name: String,
        /// What the encoder says.
        problem: String,
    },
    /// A texture transform that is no move, turn and scale.
    #[error("material `{material}` shears its texture, which glTF cannot express")]
    Sheared {
        /// The material.
        material: String,
    },
    /// GLB files end at 4 GiB.
    #[error("the scene needs {bytes} bytes, and GLB ends at 4 GiB")]
    TooBig {
        /// Length of the file.
        bytes: usize,
    },
}

/// Writes `scene` as one GLB 2.0 file with images inside.
pub fn write_glb(scene: &Scene) -> Result<Vec<u8>, WriteError> {
    let mut buffer = Buffer::default();
    let mut root = Map::new();
    let generator = concat!("cullet-scene ", env!("CARGO_PKG_VERSION"));
    root.insert("asset".into(), json!({ "version": "2.0", "generator": generator }));

    let (meshes, mesh_of_node) = meshes(scene, &mut buffer)?;
    let mut nodes = nodes(scene, &mesh_of_node);
    let cameras = cameras(scene, &mut nodes)?;
    let roots: Vec<usize> = roots(&mut nodes);
    root.insert("scene".into(), json!(0));
    let listed = if roots.is_empty() { json!({}) } else { json!({ "nodes": roots }) };
    root.insert("scenes".into(), json!([listed]));

    let mut used = BTreeSet::new();
    let materials =
        scene.materials.iter().skip(1).map(|material| material_json(material, &mut used));
    let materials = materials.collect::<Result<Vec<_>, _>>()?;
    let (textures, samplers) = textures(scene);
    let images =
        scene.images.iter().map(|image| buffer.image(image)).collect::<Result<Vec<_>, _>>()?;

    let mut list = |name: &str, values: Vec<Value>| {
        if !values.is_empty() {
            root.insert(name.into(), Value::Array(values));
        }
    };
    list("nodes", nodes.into_iter().map(|node| Value::Object(node.json)).collect());
    list("meshes", meshes);
    list("cameras", cameras);
    list("materials", materials);
    list("textures", textures);
    list("samplers", samplers);
    list("images", images);
    list("accessors", buffer.accessors);
    list("bufferViews", buffer.views);
    list("extensionsUsed", used.into_iter().map(Value::from).collect());
    if !buffer.bytes.is_empty() {
        list("buffers", vec![json!({ "byteLength": buffer.bytes.len() })]);
    }
    container(&Value::Object(root).to_string(), &buffer.bytes)
}

/// Header, JSON chunk, binary chunk.
fn container(json: &str, bytes: &[u8]) -> Result<Vec<u8>, WriteError> {
    let chunks = [(b"JSON", json.as_bytes(), b' '), (b"BIN\0", bytes, 0)];
    let chunks = &chunks[..if bytes.is_empty() { 1 } else { 2 }];
    let padded = |chunk: &[u8]| chunk.len().next_multiple_of(4);
    let length = 12 + chunks.iter().map(|(_, chunk, _)| 8 + padded(chunk)).sum::<usize>();
    let total = u32::try_from(length).map_err(|_| WriteError::TooBig { bytes: length })?;
    let mut file = Vec::with_capacity(length);
    file.extend(b"glTF");
    file.extend(2u32.to_le_bytes());
    file.extend(total.to_le_bytes());
    for (kind, chunk, filler) in chunks {
        file.extend((padded(chunk) as u32).to_le_bytes());
        file.extend(*kind);
        file.extend(*chunk);
        file.resize(file.len().next_multiple_of(4), *filler);
    }
    Ok(file)
}

/// The glTF meshes, and which of them each node shows.
fn meshes(
    scene: &Scene,
    buffer: &mut Buffer,
) -> Result<(Vec<Value>, BTreeMap<usize, usize>), WriteError> {
    let mut drawn_by_node: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
    for object in &scene.objects {
        if !scene.meshes[object.mesh].triangles.is_empty() {
            drawn_by_node.entry(object.node).or_default().push((object.mesh, object.material));
        }
    }
    let mut meshes = Vec::new();
    let mut geometry_of_mesh = BTreeMap::new();
    let mut idx_of_drawn = BTreeMap::new();
    let mut mesh_of_node = BTreeMap::new();
    for (node, drawn) in drawn_by_node {
        if let Some(idx) = idx_of_drawn.get(&drawn) {
            mesh_of_node.insert(node, *idx);
            continue;
        }
        let mut primitives = Vec::new();
        for (mesh, material) in &drawn {
            let mut primitive: Map<String, Value> = match geometry_of_mesh.get(mesh) {
                Some(geometry) => Map::clone(geometry),
                None => {
                    let geometry = buffer.geometry(&scene.meshes[*mesh])?;
                    geometry_of_mesh.insert(*mesh, geometry.clone());
                    geometry
                }
            };
            if let Some(written) = material.checked_sub(1) {
                primitive.insert("material".into(), json!(written));
            }
            primitives.push(Value::Object(primitive));
        }
        let name = &scene.meshes[drawn[0].0].name;
        meshes.push(json!({ "name": name, "primitives": primitives }));
        mesh_of_node.insert(node, meshes.len() - 1);
        idx_of_drawn.insert(drawn, meshes.len() - 1);
    }
    Ok((meshes, mesh_of_node))
}

/// A node on its way into the file.
struct WrittenNode {
    parent: Option<usize>,
    json: Map<String, Value>,
}

fn nodes(scene: &Scene, mesh_of_node: &BTreeMap<usize, usize>) -> Vec<WrittenNode> {
    let write = |(idx, node): (usize, &crate::Node)| {
        let relative = node.parent.map(|parent| {
            (parent, scene.nodes[parent].world_from_node.inverse() * node.world_from_node)
        });
        // What hangs below a flattened parent has no finite place relative to it, so it
        // moves to the root.
        let (parent, local) = match relative {
            Some((parent, local)) if local.is_finite() => (Some(parent), local),
            _ => (None, node.world_from_node),
        };
        let mut json = transform(&local);
        json.insert("name".into(), json!(node.name));
        if let Some(mesh) = mesh_of_node.get(&idx) {
            json.insert("mesh".into(), json!(mesh));
        }
        WrittenNode { parent, json }
    };
    scene.nodes.iter().enumerate().map(write).collect()
}

/// A transform in its shortest form: nothing, translation and scale, or a matrix.
fn transform(local: &DAffine3) -> Map<String, Value> {
    let mut json = Map::new();
    let linear = local.matrix3;
    let diagonal = glam::DVec3::new(linear.x_axis.x, linear.y_axis.y, linear.z_axis.z);
    if linear != glam::DMat3::from_diagonal(diagonal) {
        json.insert("matrix".into(), json!(DMat4::from(*local).to_cols_array()));
        return json;
    }
    if local.translation != glam::DVec3::ZERO {
        json.insert("translation".into(), json!(local.translation.to_array()));
    }
    if diagonal != glam::DVec3::ONE {
        json.insert("scale".into(), json!(diagonal.to_array()));
    }
    json
}

/// Hands every node to its parent; the rest are the roots.
fn roots(nodes: &mut [WrittenNode]) -> Vec<usize> {
    let mut roots = Vec::new();
    for idx in 0..nodes.len() {
        match nodes[idx].parent {
            None => roots.push(idx),
            Some(parent) => {
                let children = nodes[parent].json.entry("children").or_insert_with(|| json!([]));
                children.as_array_mut().into_iter().for_each(|list| list.push(json!(idx)));
            }
        }
    }
    roots
}

fn cameras(scene: &Scene, nodes: &mut [WrittenNode]) -> Result<Vec<Value>, WriteError> {
    let mut cameras = Vec::new();
    for camera in &scene.cameras {
        let what = format!("camera `{}`", camera.name);
        let finite = |value: f64| match value.is_finite() {
            true => Ok(json!(value)),
            false => Err(WriteError::NotFinite { what: what.clone() }),
        };
        let mut json = Map::new();
        json.insert("name".into(), json!(camera.name));
        let mut lens = Map::new();
        let kind = match camera.lens {
            Lens::Perspective { yfov, aspect, near, far } => {
                lens.insert("yfov".into(), finite(yfov)?);
                lens.insert("znear".into(), finite(near)?);
                if let Some(aspect) = aspect {
                    lens.insert("aspectRatio".into(), finite(aspect)?);
                }
                if far != f64::INFINITY {
                    lens.insert("zfar".into(), finite(far)?);
                }
                "perspective"
            }
            Lens::Orthographic { xmag, ymag, near, far } => {
                for (key, value) in [("xmag", xmag), ("ymag", ymag), ("znear", near), ("zfar", far)]
                {
                    lens.insert(key.into(), finite(value)?);
                }
                "orthographic"
            }
        };
        json.insert("type".into(), json!(kind));
        json.insert(kind.into(), Value::Object(lens));
        nodes[camera.node].json.insert("camera".into(), json!(cameras.len()));
        cameras.push(Value::Object(json));
    }
    Ok(cameras)
}

fn material_json(
    material: &Material,
    used: &mut BTreeSet<&'static str>,
) -> Result<Value, WriteError> {
    let mut surface = Map::new();
    let factor: Value = material.base_color.to_array().into_iter().map(float).collect();
    surface.insert("baseColorFactor".into(), factor);
    surface.insert("metallicFactor".into(), json!(0.0));
    if let Some(texture) = &material.base_color_texture {
        let sheared = || WriteError::Sheared { material: material.name.clone() };
        let texture = texture_json(texture, used).ok_or_else(sheared)?;
        surface.insert("baseColorTexture".into(), texture);
    }
    let mut json = Map::new();
    json.insert("name".into(), json!(material.name));
    json.insert("pbrMetallicRoughness".into(), Value::Object(surface));
    match material.alpha {
        AlphaMode::Opaque => {}
        AlphaMode::Blend => drop(json.insert("alphaMode".into(), json!("BLEND"))),
        AlphaMode::Mask { cutoff } => {
            json.insert("alphaMode".into(), json!("MASK"));
            json.insert("alphaCutoff".into(), float(cutoff));
        }
    }
    if material.double_sided {
        json.insert("doubleSided".into(), json!(true));
    }
    if material.unlit {
        used.insert("KHR_materials_unlit");
        json.insert("extensions".into(), json!({ "KHR_materials_unlit": {} }));
    }
    Ok(Value::Object(json))
}

/// `None` when the transform is sheared.
fn texture_json(texture: &TextureRef, used: &mut BTreeSet<&'static str>) -> Option<Value> {
    let mut json = json!({ "index": texture.texture });
    if texture.uv_set != 0 {
        json["texCoord"] = json!(texture.uv_set);
    }
    if let Some(transform) = texture.transform {
        used.insert("KHR_texture_transform");
        json["extensions"] = json!({ "KHR_texture_transform": uv_transform(transform)? });
    }
    Some(json)
}

/// The transform as offset, rotation and scale. A positive rotation of the extension turns
/// coordinates from v towards u, which is negative here.
fn uv_transform(transform: Affine2) -> Option<Value> {
    let pair = |v: Vec2| json!([float(v.x), float(v.y)]);
    let offset = pair(transform.translation);
    let (u, v) = (transform.matrix2.x_axis, transform.matrix2.y_axis);
    if u.y == 0.0 && v.x == 0.0 {
        return Some(json!({ "offset": offset, "scale": pair(Vec2::new(u.x, v.y)) }));
    }
    if u.dot(v).abs() > 1e-6 * u.length() * v.length() {
        return None;
    }
    let rotation = libm::atan2f(-u.y, u.x);
    let mirrored = u.perp_dot(v).signum();
    let scale = pair(Vec2::new(u.length(), mirrored * v.length()));
    Some(json!({ "offset": offset, "rotation": float(rotation), "scale": scale }))
}

/// The glTF textures and the samplers that they share.
fn textures(scene: &Scene) -> (Vec<Value>, Vec<Value>) {
    let mut samplers: Vec<Sampler> = Vec::new();
    let mut textures = Vec::new();
    for texture in &scene.textures {
        let known = samplers.iter().position(|sampler| *sampler == texture.sampler);
        let sampler = known.unwrap_or_else(|| {
            samplers.push(texture.sampler);
            samplers.len() - 1
        });
        textures.push(json!({ "source": texture.image, "sampler": sampler }));
    }
    (textures, samplers.iter().map(sampler_json).collect())
}

/// The numbers are those of OpenGL.
fn sampler_json(sampler: &Sampler) -> Value {
    let wrap = |wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    };
    json!({
        "wrapS": wrap(sampler.wrap_u),
        "wrapT": wrap(sampler.wrap_v),
        "magFilter": if sampler.nearest_mag { 9728 } else { 9729 },
        "minFilter": if sampler.nearest_min { 9728 } else { 9987 },
    })
}

/// The binary chunk as it grows, with the views and accessors into it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

/// What the vertex shader of a GPU would read.
const ARRAY_BUFFER: u32 = 34962;
/// What it would be fed with.
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

impl Buffer {
    /// A primitive without its material.
    fn geometry(&mut self, mesh: &Mesh) -> Result<Map<String, Value>, WriteError> {
        let n = mesh.positions.len();
        let mut attributes = Map::new();
        let (low, high) = bounds(mesh)?;
        let positions = self.floats(mesh.positions.iter().map(Vec3::to_array));
        self.accessors[positions]["min"] = low.to_array().into_iter().map(float).collect();
        self.accessors[positions]["max"] = high.to_array().into_iter().map(float).collect();
        attributes.insert("POSITION".into(), json!(positions));
        if let Some(normals) = &mesh.normals {
            attributes
                .insert("NORMAL".into(), json!(self.floats(normals.iter().map(Vec3::to_array))));
        }
        // Sets must be numbered without gaps, so a lonely second set gets a blank first.
        let blank = mesh.uvs[1].as_ref().map(|_| vec![Vec2::ZERO; n]);
        let sets = [mesh.uvs[0].as_ref().or(blank.as_ref()), mesh.uvs[1].as_ref()];
        for (set, uvs) in sets.into_iter().flatten().enumerate() {
            let accessor = self.floats(uvs.iter().map(Vec2::to_array));
            attributes.insert(format!("TEXCOORD_{set}"), json!(accessor));
        }
        if let Some(colors) = &mesh.colors {
            attributes.insert("COLOR_0".into(), json!(self.colors(colors)));
        }
        let indices = mesh.triangles.as_flattened();
        let (bytes, component): (Vec<u8>, _) = if n <= usize::from(u16::MAX) {
            (indices.iter().flat_map(|i| (*i as u16).to_le_bytes()).collect(), UNSIGNED_SHORT)
        } else {
            (indices.iter().flat_map(|i| i.to_le_bytes()).collect(), UNSIGNED_INT)
        };
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        let indices = self.accessor((view, component), indices.len(), "SCALAR");
        let mut primitive = Map::new();
        primitive.insert("attributes".into(), Value::Object(attributes));
        primitive.insert("indices".into(), json!(indices));
        Ok(primitive)
    }

    /// Four bytes when that loses nothing, else four floats.
    fn colors(&mut self, colors: &[Vec4]) -> usize {
        let byte = |value: f32| (value * 255.0).round().clamp(0.0, 255.0) as u8;
        let bytes: Vec<[u8; 4]> = colors.iter().map(|color| color.to_array().map(byte)).collect();
        let exact = colors
            .iter()
            .zip(&bytes)
            .all(|(color, bytes)| color.to_array() == bytes.map(|byte| f32::from(byte) / 255.0));
        if !exact {
            return self.floats(colors.iter().map(Vec4::to_array));
        }
        let view = self.view(bytes.as_flattened(), Some(ARRAY_BUFFER));
        let accessor = self.accessor((view, UNSIGNED_BYTE), colors.len(), "VEC4");
        self.accessors[accessor]["normalized"] = json!(true);
        accessor
    }

    fn floats<const N: usize>(&mut self, items: impl ExactSizeIterator<Item = [f32; N]>) -> usize {
        let count = items.len();
        let bytes: Vec<u8> = items.flatten().flat_map(f32::to_le_bytes).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        self.accessor((view, FLOAT), count, &format!("VEC{N}"))
    }

    fn accessor(&mut self, (view, component): (usize, u32), count: usize, shape: &str) -> usize {
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": shape,
        }));
        self.accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    /// As PNG; opaque pictures lose their alpha channel.
    fn image(&mut self, image: &Image) -> Result<Value, WriteError> {
        if image.rgba.is_empty() {
            return Err(WriteError::NoPixels { name: image.name.clone() });
        }
        let opaque = image.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255);
        let rgb: Vec<u8>;
        let (pixels, kind) = if opaque {
            rgb = image
                .rgba
                .chunks_exact(4)
                .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
                .collect();
            (&rgb, ExtendedColorType::Rgb8)
        } else {
            (&image.rgba, ExtendedColorType::Rgba8)
        };
        let mut png = Cursor::new(Vec::new());
        PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive)
            .write_image(pixels, image.width, image.height, kind)
            .map_err(|error| WriteError::Image {
                name: image.name.clone(),
                problem: error.to_string(),
            })?;
        let view = self.view(png.get_ref(), None);
        Ok(json!({ "name": image.name, "mimeType": "image/png", "bufferView": view }))
    }
}

fn bounds(mesh: &Mesh) -> Result<(Vec3, Vec3), WriteError> {
    let finite = mesh.positions.iter().all(|position| position.is_finite());
    if !finite {
        return Err(WriteError::NotFinite { what: format!("mesh `{}`", mesh.name) });
    }
    let bound = |fold: fn(Vec3, Vec3) -> Vec3| mesh.positions.iter().copied().reduce(fold);
    Ok((bound(Vec3::min).unwrap_or_default(), bound(Vec3::max).unwrap_or_default()))
}

/// The shortest decimal that reads back as `value`.
fn float(value: f32) -> Value {
    json!(value.to_string().parse::<f64>().unwrap_or(f64::from(value)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{NAMES, synth};
    use crate::{LoadOptions, load_glb_bytes};

    #[track_caller]
    fn check_round_trip(spec: &str) {
        let written = synth(spec).unwrap();
        let bytes = write_glb(&written).unwrap();
        let read = load_glb_bytes(bytes, spec, &LoadOptions::default()).unwrap();
        assert_eq!(read.warnings, Vec::<String>::new(), "{spec}");
        assert_eq!(read.nodes.len(), written.nodes.len(), "{spec}");
        assert_eq!(read.objects.len(), written.objects.len(), "{spec}");
        for (a, b) in written.objects.iter().zip(&read.objects) {
            assert_eq!((&a.name, a.material), (&b.name, b.material), "{spec}");
            assert_same_place(&a.world_from_model, &b.world_from_model);
            assert_same_mesh(&written.meshes[a.mesh], &read.meshes[b.mesh]);
        }
        for (a, b) in written.nodes.iter().zip(&read.nodes) {
            assert_eq!((&a.name, a.parent), (&b.name, b.parent), "{spec}");
        }
        assert_eq!(written.materials.len(), read.materials.len(), "{spec}");
        for (a, b) in written.materials.iter().zip(&read.materials).skip(1) {
            assert_same_material(a, b);
        }
        assert_eq!(written.textures, read.textures, "{spec}");
        for (a, b) in written.images.iter().zip(&read.images) {
            assert!(a.rgba == b.rgba && a.width == b.width && !b.placeholder, "{spec}: {}", a.name);
        }
        for (a, b) in written.cameras.iter().zip(&read.cameras) {
            assert_same_place(&a.world_from_camera, &b.world_from_camera);
        }
    }

    #[track_caller]
    fn assert_same_place(a: &DAffine3, b: &DAffine3) {
        let largest = a.to_cols_array().into_iter().fold(1.0, |m: f64, v| m.max(v.abs()));
        assert!(a.abs_diff_eq(*b, 1e-7 * largest), "{a} is not {b}");
    }

    #[track_caller]
    fn assert_same_mesh(a: &Mesh, b: &Mesh) {
        assert_eq!(a.positions, b.positions, "{}", a.name);
        assert_eq!(a.triangles, b.triangles, "{}", a.name);
        assert_eq!((&a.normals, &a.uvs, &a.colors), (&b.normals, &b.uvs, &b.colors), "{}", a.name);
    }

    #[track_caller]
    fn assert_same_material(a: &Material, b: &Material) {
        assert_eq!((&a.name, a.base_color, a.alpha), (&b.name, b.base_color, b.alpha));
        assert_eq!((a.double_sided, a.unlit), (b.double_sided, b.unlit));
        let transform = |material: &Material| {
            material.base_color_texture.as_ref().and_then(|texture| texture.transform)
        };
        match (transform(a), transform(b)) {
            (Some(a), Some(b)) => assert!(a.abs_diff_eq(b, 1e-6), "{a} is not {b}"),
            (a, b) => assert_eq!(a, b),
        }
        let texture = |material: &Material| {
            material.base_color_texture.as_ref().map(|texture| (texture.texture, texture.uv_set))
        };
        assert_eq!(texture(a), texture(b), "{}", a.name);
    }

    #[test]
    fn every_synthetic_scene_reads_back_as_it_was() {
        for (name, _) in NAMES.iter().filter(|(name, _)| *name != "box-grid") {
            check_round_trip(name);
        }
        check_round_trip("box-grid:4");
    }

    #[test]
    fn the_same_scene_gives_the_same_bytes() {
        let bytes = || write_glb(&synth("masks").unwrap()).unwrap();
        assert!(bytes() == bytes());
    }

    #[test]
    fn showpieces_are_small_enough_to_ship() {
        for name in ["showpiece", "city", "knots", "masks", "interior", "spheres"] {
            let n_bytes = write_glb(&synth(name).unwrap()).unwrap().len();
            assert!(n_bytes <= 1_500_000, "{name}: {n_bytes} bytes");
        }
    }

    #[test]
    fn an_empty_scene_is_a_valid_file() {
        let bytes = write_glb(&Scene::default()).unwrap();
        assert_eq!(&bytes[..4], b"glTF");
        assert_eq!(bytes.len() % 4, 0);
        assert_eq!(
            bytes.len(),
            u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize
        );
    }

    #[test]
    fn what_gltf_cannot_express_is_an_error() {
        let mut scene = synth("sphere:8").unwrap();
        scene.meshes[0].positions[3].y = f32::NAN;
        assert!(matches!(write_glb(&scene), Err(WriteError::NotFinite { .. })));
        let mut scene = synth("masks").unwrap();
        scene.images[0].rgba.clear();
        assert!(matches!(write_glb(&scene), Err(WriteError::NoPixels { .. })));
    }

    #[test]
    fn texture_transforms_split_into_move_turn_and_scale() {
        let build = Affine2::from_scale_angle_translation;
        let json = |transform| uv_transform(transform);
        let moved = json(build(Vec2::new(2.0, -3.0), 0.0, Vec2::new(0.5, 0.0)));
        assert_eq!(moved, Some(json!({ "offset": [0.5, 0.0], "scale": [2.0, -3.0] })));
        let turned = json(build(Vec2::ONE, 0.5, Vec2::ZERO)).unwrap();
        assert!((turned["rotation"].as_f64().unwrap() + 0.5).abs() < 1e-6);
        let sheared = Affine2::from_mat2(glam::Mat2::from_cols(Vec2::X, Vec2::ONE));
        assert_eq!(json(sheared), None);
    }
}
