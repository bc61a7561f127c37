//! Which document do these bytes describe?
//!
//! The types and checks of the `gltf` crate are used where they help. They are stricter
//! than the format in some places and stricter than drawing needs in others, so the JSON is
//! mended first and the complaints are sifted afterwards. What is tolerated here is handled
//! where it is used; indices are always checked.

use ::gltf::json::mesh::Semantic;
use ::gltf::json::validation::{Checked, Error as Complaint, Validate};
use ::gltf::json::{Path, Root};
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};
use serde::Deserialize;
use serde_json::{Number, Value, json};

use super::{container, extensions};
use crate::{Extension, LoadError};

/// A checked document.
#[derive(Debug)]
pub(super) struct Document<'a> {
    /// The document; every index in it is in range, except the `source` of a texture.
    pub root: Root,
    /// The binary chunk of a `.glb`.
    pub blob: Option<&'a [u8]>,
    /// Node to parent, for each node of `root`, in the full precision of the text.
    /// Not necessarily finite.
    pub parent_from_node: Vec<DAffine3>,
    /// Extensions and their treatment.
    pub extensions: Vec<Extension>,
    /// Names of the animations, which are not in `root`.
    pub animations: Vec<String>,
}

/// Reads and checks a document; `name` is for messages.
pub(super) fn read<'a>(bytes: &'a [u8], name: &str) -> Result<Document<'a>, LoadError> {
    let invalid = |place: &str, problem: String| {
        LoadError::invalid(name, place, problem, "check the file with a glTF validator")
    };
    let parts = container::split(bytes).map_err(|problem| invalid("", problem))?;
    let Parsed { root, parent_from_node, animations } = match parse(parts.json) {
        Some(parsed) => parsed,
        None => mend_and_parse(parts.json, name)?,
    };
    let extensions = extensions::treat(name, &root.extensions_used, &root.extensions_required)?;
    extensions::check_textures(name, &root, &extensions)?;
    if let Some((path, complaint)) = first_complaint(&root) {
        return Err(invalid(&path, complaint));
    }
    Ok(Document { root, blob: parts.blob, parent_from_node, extensions, animations })
}

/// What the text says.
#[derive(Debug)]
struct Parsed {
    root: Root,
    parent_from_node: Vec<DAffine3>,
    animations: Vec<String>,
}

/// Reads a text that needs no mending, straight into its types. `None`: it does, or is wrong, and
/// [`mend_and_parse`] says what. That builds a tree of the whole text first, takes longer, and
/// rounds numbers to f64 on their way to f32, which may cost their last bit.
fn parse(json: &[u8]) -> Option<Parsed> {
    #[derive(Deserialize)]
    struct Rest {
        asset: Asset,
        #[serde(default)]
        nodes: Vec<Transform>,
        #[serde(default)]
        animations: Vec<Animation>,
    }
    #[derive(Deserialize)]
    #[serde(rename_all = "camelCase")]
    struct Asset {
        version: String,
        min_version: Option<String>,
    }
    #[derive(Deserialize)]
    struct Animation {
        name: Option<String>,
    }

    // Strings that are skipped would not be looked at.
    let text = std::str::from_utf8(json).ok()?;
    let mut root: Root = serde_json::from_str(text).ok()?;
    root.animations.clear();
    let rest: Rest = serde_json::from_str(text).ok()?;
    check_version(Some(&rest.asset.version), rest.asset.min_version.as_deref()).ok()?;
    let named = |(i, animation): (usize, Animation)| match animation.name {
        Some(name) if !name.is_empty() => name,
        _ => format!("animation {i}"),
    };
    Some(Parsed {
        root,
        parent_from_node: rest.nodes.into_iter().map(Transform::parent_from_node).collect(),
        animations: rest.animations.into_iter().enumerate().map(named).collect(),
    })
}

/// Reads any text that can be read at all.
fn mend_and_parse(json: &[u8], name: &str) -> Result<Parsed, LoadError> {
    let invalid = |place: &str, problem: String| {
        LoadError::invalid(name, place, problem, "check the file with a glTF validator")
    };
    let mut value: Value = serde_json::from_slice(json)
        .map_err(|error| invalid("", format!("is not glTF: {error}")))?;
    check_asset(&value).map_err(|problem| {
        LoadError::invalid(name, "asset", problem, "convert the file to glTF 2.0")
    })?;
    make_whole_numbers_integers(&mut value);
    let animations = take_animations(&mut value);
    add_empty_node_lists(&mut value);
    let parent_from_node =
        read_transforms(&value).map_err(|(place, problem)| invalid(&place, problem))?;
    let root = read_root(value).map_err(|(place, problem)| invalid(&place, problem))?;
    Ok(Parsed { root, parent_from_node, animations })
}

fn check_asset(value: &Value) -> Result<(), String> {
    let asset = value.get("asset").ok_or("is missing")?;
    let text = |key| asset.get(key).and_then(Value::as_str);
    check_version(text("version"), text("minVersion"))
}

fn check_version(version: Option<&str>, minimum: Option<&str>) -> Result<(), String> {
    let version = version.filter(|text| !text.is_empty()).ok_or("has no version")?;
    let minimum = minimum.filter(|text| !text.is_empty()).unwrap_or("2.0");
    if version.split('.').next() != Some("2") {
        return Err(format!("has version `{version}`, and only 2.x is read"));
    }
    if minimum != "2.0" {
        return Err(format!("needs version `{minimum}`, and only 2.0 is known"));
    }
    Ok(())
}

/// `1.0` is a legal integer in glTF.
fn make_whole_numbers_integers(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(make_whole_numbers_integers),
        Value::Object(fields) => fields.values_mut().for_each(make_whole_numbers_integers),
        Value::Number(number) if number.is_f64() => {
            let exact = 0.0..9_007_199_254_740_992.0; // below 2^53
            if let Some(float) = number.as_f64()
                && float.fract() == 0.0
                && float.is_sign_positive()
                && exact.contains(&float)
            {
                *number = Number::from(float as u64);
            }
        }
        _ => {}
    }
}

/// The whole number that an extension holds, which may be written `1.0`.
pub(super) fn whole_number(value: &Value) -> Option<u64> {
    let mut value = value.clone();
    make_whole_numbers_integers(&mut value);
    value.as_u64()
}

/// Nothing in the rest pose depends on animations, so they cannot spoil it either.
fn take_animations(value: &mut Value) -> Vec<String> {
    let animations = value.as_object_mut().and_then(|root| root.remove("animations"));
    let animations = animations.as_ref().and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let named = |(i, animation): (usize, &Value)| match animation.get("name") {
        Some(Value::String(name)) if !name.is_empty() => name.clone(),
        _ => format!("animation {i}"),
    };
    animations.iter().enumerate().map(named).collect()
}

/// A scene may have no nodes.
fn add_empty_node_lists(value: &mut Value) {
    let scenes = value.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten().filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
}

/// The transform of a node. The crate would round it to f32, which is too coarse far from the
/// origin.
#[derive(Deserialize)]
struct Transform {
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

impl Transform {
    fn parent_from_node(self) -> DAffine3 {
        match self.matrix {
            Some(matrix) => affine(&matrix),
            None => DAffine3::from_scale_rotation_translation(
                self.scale.map_or(DVec3::ONE, DVec3::from_array),
                self.rotation.map_or(DQuat::IDENTITY, rotation),
                self.translation.map_or(DVec3::ZERO, DVec3::from_array),
            ),
        }
    }
}

fn read_transforms(value: &Value) -> Result<Vec<DAffine3>, (String, String)> {
    let nodes = value.get("nodes").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let read_one = |(i, node): (usize, &Value)| {
        let transform = Transform::deserialize(node)
            .map_err(|error| (format!("nodes[{i}]"), format!("has a bad transform: {error}")))?;
        Ok(transform.parent_from_node())
    };
    nodes.iter().enumerate().map(read_one).collect()
}

/// The rotation of a quaternion in file order (x, y, z, w), which need not be unit.
/// All zeros: none.
pub(super) fn rotation(quaternion: [f64; 4]) -> DQuat {
    let quaternion = DVec4::from_array(quaternion);
    match quaternion.try_normalize() {
        Some(unit) => DQuat::from_vec4(unit),
        None if quaternion == DVec4::ZERO => DQuat::IDENTITY,
        None => DQuat::from_vec4(DVec4::NAN),
    }
}

/// An affine transform from a column-major matrix, whose last row is taken to be 0 0 0 1.
fn affine(matrix: &[f64; 16]) -> DAffine3 {
    DAffine3::from_mat4(DMat4::from_cols_array(&{
        let mut affine = *matrix;
        [affine[3], affine[7], affine[11], affine[15]] = [0.0, 0.0, 0.0, 1.0];
        affine
    }))
}

/// On an error says where the first fault is.
fn read_root(value: Value) -> Result<Root, (String, String)> {
    let error = match Root::deserialize(&value) {
        Ok(root) => return Ok(root),
        Err(error) => error,
    };
    let fault = value.as_object().into_iter().flatten().find_map(|(key, part)| fault(key, part));
    let (place, error) = fault.unwrap_or((String::new(), error));
    Err((place, format!("is not as glTF wants it: {error}")))
}

/// What is wrong with a part of the document, and in which item of it if it is a list. Every
/// part is read alone, so that the time is that of reading the document a few times.
fn fault(key: &str, part: &Value) -> Option<(String, serde_json::Error)> {
    let read_alone = |part: Value| {
        let asset = json!({ "version": "2.0" });
        // The asset comes first, because it may be the part.
        Root::deserialize(json!({ "asset": asset, key: part })).err()
    };
    let error = read_alone(part.clone())?;
    let item_fault = |(i, item): (usize, &Value)| {
        read_alone(json!([item])).map(|error| (format!("{key}[{i}]"), error))
    };
    let mut items = part.as_array().into_iter().flatten().enumerate();
    items.find_map(item_fault).or(Some((key.to_string(), error)))
}

/// The first complaint of the crate that matters.
fn first_complaint(root: &Root) -> Option<(String, String)> {
    // The crate's own check would index out of bounds for these.
    for (i, mesh) in root.meshes.iter().enumerate() {
        for (j, primitive) in mesh.primitives.iter().enumerate() {
            let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if position.is_some_and(|index| index.value() >= root.accessors.len()) {
                let place = format!("meshes[{i}].primitives[{j}].attributes.POSITION");
                return Some((place, "names an accessor that does not exist".into()));
            }
        }
    }
    let mut first = None;
    root.validate(root, Path::new, &mut |path, complaint| {
        if first.is_none() && !is_tolerated(path().as_str(), complaint) {
            first = Some((path().to_string(), in_words(complaint).to_string()));
        }
    });
    first
}

fn is_tolerated(path: &str, complaint: Complaint) -> bool {
    let ends_with = |suffixes: &[&str]| suffixes.iter().any(|suffix| path.ends_with(suffix));
    match complaint {
        // Judged by the table of extensions.
        Complaint::Unsupported => true,
        // Zeros, a missing image, recomputed bounds, a primitive to leave out, no lens.
        Complaint::Missing => {
            ends_with(&[".bufferView", ".source", ".min", ".max", "[\"POSITION\"]"])
                || path.starts_with("cameras[")
        }
        // Bounds again, attributes nobody knows, a lens nobody knows.
        Complaint::Invalid => {
            ends_with(&[".min", ".max"])
                || path.contains(".attributes[")
                || path.starts_with("cameras[")
        }
        Complaint::IndexOutOfBounds | Complaint::Oversize => false,
    }
}

fn in_words(complaint: Complaint) -> &'static str {
    match complaint {
        Complaint::IndexOutOfBounds => "names something that does not exist",
        Complaint::Invalid => "has an impossible value",
        Complaint::Missing => "is missing",
        Complaint::Oversize => "is too large for this machine",
        Complaint::Unsupported => "is not supported",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(rest: &str) -> String {
        format!(r#"{{"asset":{{"version":"2.0"}}{rest}}}"#)
    }

    #[track_caller]
    fn accepts(rest: &str) {
        read(with(rest).as_bytes(), "t.gltf").unwrap();
    }

    #[track_caller]
    fn refuses(rest: &str, words: &str) {
        let error = read(with(rest).as_bytes(), "t.gltf").unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }

    #[test]
    fn legal_files_that_the_crate_refuses_are_read() {
        accepts("");
        accepts(r#","scenes":[{}],"scene":0.0"#);
        accepts(r#","accessors":[{"count":1,"componentType":5126.0,"type":"VEC3"}]"#);
        accepts(r#","textures":[{}]"#);
        accepts(r#","animations":[{"channels":"?"}]"#);
        accepts(r#","extensionsRequired":["KHR_mesh_quantization"]"#);
    }

    /// Whether `mended` is `direct` by way of f64, which may cost the last bit, or an integer.
    fn is_rounded_twice(direct: &str, mended: &str) -> bool {
        let bits = |word: &str| word.parse::<f32>().ok().map(|number| i64::from(number.to_bits()));
        matches!((bits(direct), bits(mended)), (Some(a), Some(b)) if (a - b).abs() <= 1)
    }

    /// Plain twin: [`mend_and_parse`].
    #[test]
    fn what_needs_no_mending_reads_the_same_directly() {
        let mut texts: Vec<Vec<u8>> = crate::synth::NAMES
            .iter()
            .map(|(name, _)| {
                let scene = crate::synth::synth(name).unwrap();
                let bytes = crate::write_glb(&scene).unwrap();
                container::split(&bytes).unwrap().json.to_vec()
            })
            .collect();
        let extras = r#","extras":{"deep":[[[1.5,"x"]]]},"unknown":{"a":[1e9,null]}"#;
        let nodes = r#","nodes":[{"matrix":[1,0,0,0,0,1.0,0,0,0,0,1,0,1e20,-0.0,0.1,1]},{}]"#;
        let animations = r#","animations":[{"name":"a","channels":[],"samplers":[]},
            {"channels":[],"samplers":[]}]"#;
        let text = r#","extensionsUsed":["X"],"materials":[{"name":"m","alphaCutoff":0.3,
            "extensions":{"X":{"a":1.0,"b":[2]}}}]"#;
        texts.push(with(extras).into_bytes());
        texts.push(with(&[nodes, animations, text].concat()).into_bytes());
        for text in texts {
            let direct = parse(&text).expect("needs no mending");
            let mended = mend_and_parse(&text, "t.gltf").unwrap();
            assert_eq!(direct.parent_from_node, mended.parent_from_node);
            assert_eq!(direct.animations, mended.animations);
            let (direct, mended) = (format!("{:?}", direct.root), format!("{:?}", mended.root));
            let words = |root: &str| -> Vec<String> {
                root.split([' ', ',', '(', ')', '[', ']']).map(str::to_owned).collect()
            };
            let (direct, mended) = (words(&direct), words(&mended));
            assert_eq!(direct.len(), mended.len());
            for (direct, mended) in direct.iter().zip(&mended) {
                assert!(direct == mended || is_rounded_twice(direct, mended), "{direct} {mended}");
            }
        }
        for rest in [r#","scenes":[{}]"#, r#","scene":0.0"#, r#","meshes":[{}]"#, r#","a":tru"#] {
            assert!(parse(with(rest).as_bytes()).is_none(), "{rest}");
        }
    }

    #[test]
    fn whole_numbers_of_extensions() {
        for (text, expected) in [("3", Some(3)), ("3.0", Some(3)), ("3.5", None), ("-1", None)] {
            assert_eq!(whole_number(&serde_json::from_str(text).unwrap()), expected, "{text}");
        }
    }

    #[test]
    fn lies_are_refused_with_their_place() {
        refuses(r#","scenes":[{"nodes":[7]}]"#, "scenes[0].nodes[0]");
        refuses(r#","nodes":[{"translation":[1,2]}]"#, "nodes[0]");
        refuses(r#","meshes":{}"#, "meshes: is not as glTF wants it");
        refuses(r#","nodes":[{},{"mesh":"x"}]"#, "nodes[1]: is not as glTF wants it");
        refuses(r#","accessors":[{}],"meshes":[{}]"#, "accessors[0]: is not as glTF wants it");
        refuses(
            r#","meshes":[{"primitives":[{"attributes":{"POSITION":9}}]}]"#,
            "meshes[0].primitives[0].attributes.POSITION",
        );
    }

    /// Quadratic work on this takes minutes.
    #[test]
    fn faults_are_found_among_many_unknown_keys() {
        let keys: String = (0..20_000).map(|i| format!(r#","a{i}":[]"#)).collect();
        refuses(&(keys + r#","meshes":{},"nodes":{}"#), "t.gltf: meshes: ");
    }

    #[test]
    fn an_empty_version_is_none() {
        let error = read(br#"{"asset":{"version":""}}"#, "t.gltf").unwrap_err().to_string();
        assert!(error.contains("asset: has no version;"), "{error}");
    }

    #[test]
    fn other_versions_are_refused() {
        for asset in [
            "{}",
            r#"{"asset":{}}"#,
            r#"{"asset":{"version":"1.0"}}"#,
            r#"{"asset":{"version":"3.0"}}"#,
            r#"{"asset":{"version":"2.1","minVersion":"2.1"}}"#,
            "[]",
        ] {
            assert!(read(asset.as_bytes(), "t.gltf").is_err(), "{asset}");
        }
        assert!(read(br#"{"asset":{"version":"2.1"}}"#, "t.gltf").is_ok());
    }

    #[test]
    fn transforms_keep_the_precision_of_the_text() {
        let text = with(r#","nodes":[{"translation":[134217728.5,0,0]},{"scale":[2,0,-1]}]"#);
        let document = read(text.as_bytes(), "t.gltf").unwrap();
        assert_eq!(document.parent_from_node[0].translation.x, 134217728.5);
        assert_eq!(document.parent_from_node[1].matrix3.z_axis.z, -1.0);
    }

    #[test]
    fn quaternions_become_rotations() {
        assert_eq!(rotation([0.0; 4]), DQuat::IDENTITY);
        assert_eq!(rotation([0.0, 0.0, 0.0, 3.0]), DQuat::IDENTITY);
        assert!(rotation([f64::INFINITY, 0.0, 0.0, 1.0]).is_nan());
    }
}
