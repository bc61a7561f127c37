//! Every real and bad file of the asset collection does what its manifest expects, as far
//! as loading goes. The collection lies beside the repository and is not part of it;
//! without it this test passes and says so.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use cullet_scene::{ErrorKind, LoadError, LoadOptions, Scene, load};
use serde_json::Value;

/// No file may take longer.
const PATIENCE: Duration = Duration::from_secs(10);

/// Where we think that the manifest is wrong, and why.
const DEVIATIONS: &[(&str, &str)] = &[
    ("bad/tinyobjloader/models/norm-texopt.obj", "lacks only a map without effect on the picture"),
    ("bad/tinyobjloader/models/pbr-mat-ext.obj", "lacks only maps without effect on the picture"),
];

#[test]
fn every_file_meets_its_expectation() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    let Ok(text) = std::fs::read_to_string(assets.join("MANIFEST.json")) else {
        println!("skipped: there is no asset collection beside the repository");
        return;
    };
    let manifest: Value = serde_json::from_str(&text).unwrap();
    let mut n_files = 0;
    let mut surprises = Vec::new();
    for entry in manifest["entries"].as_array().unwrap() {
        let file = entry["file"].as_str().unwrap();
        let expectation = entry["expect"].as_str().unwrap();
        n_files += 1;
        let outcome = load_in_time(assets.join(file));
        let surprise = match &outcome {
            Err(failure) => Some(failure.clone()),
            Ok(result) => judge(expectation, entry, result),
        };
        let excused = DEVIATIONS.iter().find(|(name, _)| *name == file);
        match (surprise, excused) {
            (Some(surprise), None) => surprises.push(format!("{file} [{expectation}]: {surprise}")),
            (None, Some(_)) => surprises.push(format!("{file}: no longer deviates")),
            (Some(_), Some((_, reason))) => println!("{file} [{expectation}]: {reason}"),
            (None, None) => {}
        }
        if std::env::var_os("CULLET_CORPUS_VERBOSE").is_some() {
            println!("{}", in_words(file, expectation, &outcome));
        }
    }
    println!("{n_files} files, {} surprises", surprises.len());
    assert!(surprises.is_empty(), "\n{}", surprises.join("\n"));
}

/// What is unexpected about a result.
fn judge(expectation: &str, entry: &Value, result: &Result<Scene, LoadError>) -> Option<String> {
    if let Ok(scene) = result
        && let Some(problem) = inconsistency(scene)
    {
        return Some(problem);
    }
    match (expectation, result) {
        ("no-crash", _) | ("fail", Err(_)) => None,
        ("ok" | "load", Ok(scene)) => wrong_triangles(entry, scene),
        ("render-warn", Ok(scene)) if !scene.warnings.is_empty() => None,
        ("render-or-name-extension", Ok(_)) => None,
        ("render-or-name-extension", Err(error)) if error.kind() == ErrorKind::Unsupported => None,
        (_, Ok(scene)) => Some(format!("loads with {} warnings", scene.warnings.len())),
        (_, Err(error)) => Some(error.to_string()),
    }
}

/// The manifest counts triangles as drawn, but not what the instancing extension adds.
fn wrong_triangles(entry: &Value, scene: &Scene) -> Option<String> {
    let expected = entry["triangles_scene"].as_u64()?;
    let instanced = scene.extensions.iter().any(|known| known.name == "EXT_mesh_gpu_instancing");
    if instanced
        || !scene.left_out.is_empty()
        || !scene.warnings.is_empty()
        || entry["expect"] != "ok"
    {
        return None;
    }
    let n_triangles: u64 =
        scene.objects.iter().map(|object| scene.meshes[object.mesh].triangles.len() as u64).sum();
    (n_triangles != expected).then(|| format!("{n_triangles} triangles, expected {expected}"))
}

/// What the documentation of the scene data promises and does not hold.
fn inconsistency(scene: &Scene) -> Option<String> {
    for mesh in &scene.meshes {
        let n = mesh.positions.len();
        let lengths = [
            mesh.normals.as_ref().map(Vec::len),
            mesh.uvs[0].as_ref().map(Vec::len),
            mesh.uvs[1].as_ref().map(Vec::len),
            mesh.colors.as_ref().map(Vec::len),
        ];
        if lengths.into_iter().flatten().any(|length| length != n) {
            return Some(format!("mesh {}: attribute lengths differ", mesh.name));
        }
        if mesh.triangles.as_flattened().iter().any(|&corner| corner as usize >= n) {
            return Some(format!("mesh {}: index out of range", mesh.name));
        }
        if mesh.name.is_empty() {
            return Some("a mesh has no name".into());
        }
    }
    for object in &scene.objects {
        let in_range = object.mesh < scene.meshes.len()
            && object.material < scene.materials.len()
            && object.node < scene.nodes.len();
        if !in_range || object.name.is_empty() || !object.world_from_model.is_finite() {
            return Some(format!("object `{}` is not right", object.name));
        }
    }
    for image in &scene.images {
        if image.rgba.len() != image.width as usize * image.height as usize * 4 {
            return Some(format!("image {} has a wrong size", image.name));
        }
    }
    None
}

fn load_in_time(file: PathBuf) -> Result<Arc<Result<Scene, LoadError>>, String> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || sender.send(Arc::new(load(&file, &LoadOptions::default()))));
    receiver.recv_timeout(PATIENCE).map_err(|error| match error {
        RecvTimeoutError::Timeout => "takes too long".to_string(),
        RecvTimeoutError::Disconnected => "panics".to_string(),
    })
}

fn in_words(
    file: &str,
    expectation: &str,
    outcome: &Result<Arc<Result<Scene, LoadError>>, String>,
) -> String {
    let result = match outcome.as_deref() {
        Err(failure) => failure.clone(),
        Ok(Err(error)) => error.to_string(),
        Ok(Ok(scene)) => format!(
            "{} objects, warnings {:?}, left out {:?}",
            scene.objects.len(),
            scene.warnings,
            scene.left_out
        ),
    };
    format!("{file} [{expectation}]: {result}")
}
