//! The whole viewer, moved by a script instead of a hand.

use std::path::Path;
use std::process::{Command, Output};

use image::{Rgb, RgbImage};

fn viewer(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet-view"));
    command.current_dir(folder).args(args).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command.output().expect("the viewer starts")
}

/// Replays `script` in a folder of its own.
fn replay(script: &str) -> (tempfile::TempDir, Output) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("script"), script).expect("a script");
    let output = viewer(folder.path(), &["synth:box-grid:5", "--script", "script"]);
    (folder, output)
}

#[track_caller]
fn picture(folder: &tempfile::TempDir, name: &str) -> RgbImage {
    let picture = image::open(folder.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    picture.to_rgb8()
}

/// Pixels of about this colour.
fn count(picture: &RgbImage, color: [u8; 3]) -> usize {
    let near = |&Rgb(pixel): &Rgb<u8>| {
        pixel.iter().zip(color).all(|(&found, expected)| found.abs_diff(expected) < 26)
    };
    picture.pixels().filter(|pixel| near(pixel)).count()
}

const GREEN: [u8; 3] = [0x40, 0xe0, 0x60];
const YELLOW: [u8; 3] = [0xff, 0xe6, 0x40];

#[test]
fn a_frustum_is_frozen_and_seen_from_outside() {
    let (folder, output) = replay(
        "size 960 640\n\
         wheel 9\n\
         screenshot before.png\n\
         key space\n\
         wheel -13\n\
         drag 120 80\n\
         screenshot frozen.png\n\
         key b\n\
         screenshot without-boxes.png\n\
         key b\n\
         key h\n\
         screenshot help.png\n\
         key h\n\
         key p\n\
         key p\n\
         key space\n\
         drag -120 -80\n\
         wheel 13\n\
         key c\n\
         screenshot after.png\n\
         quit\n\
         screenshot never.png\n",
    );
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");

    let [before, frozen, plain] =
        ["before.png", "frozen.png", "without-boxes.png"].map(|name| picture(&folder, name));
    assert_eq!(before.dimensions(), (960, 640));
    assert_eq!([GREEN, YELLOW].map(|color| count(&before, color)), [0; 2]);
    for color in [GREEN, YELLOW] {
        // Words of the legend have these colours too.
        let n_of_boxes = count(&frozen, color).saturating_sub(count(&plain, color));
        assert!(n_of_boxes > 100, "{n_of_boxes} pixels of {color:?}");
    }
    assert_ne!(picture(&folder, "help.png"), frozen);
    let numbered = [1, 2].map(|n| picture(&folder, &format!("cullet-view-000{n}.png")));
    assert_eq!(numbered, [frozen.clone(), frozen]);
    assert!(stderr.contains("cullet-view-0002.png"), "{stderr}");

    // There and back again, but for rounding at the edges of things.
    let after = picture(&folder, "after.png");
    let n_changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count();
    assert!(n_changed < 50, "{n_changed} pixels changed");
    assert!(!folder.path().join("never.png").exists());
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(stdout.starts_with("{\"eye\": [") && stdout.lines().count() == 1, "{stdout}");
}

#[test]
fn the_same_script_gives_the_same_pixels() {
    let script = "size 160 90\nwheel 7\nkey space\ndrag 20 9\nwheel -9\nscreenshot a.png\n";
    let [a, b] = [replay(script), replay(script)].map(|(folder, _)| picture(&folder, "a.png"));
    assert_eq!(a, b);
}

#[test]
fn mistakes_are_one_line_and_a_code() {
    let here = Path::new(".");
    for (args, code, says) in [
        (&["synth:box-grid:2"][..], 6, "cullet render"),
        (&["no-such.glb"], 3, "no-such.glb"),
        (&["synth:no-such"], 2, "no-such"),
        (&["synth:box-grid:2", "--camera", "7"], 2, "camera `7`"),
        (&["synth:box-grid:2", "--size", "99999x1"], 2, "99999"),
        (&["synth:box-grid:2", "--script", "no-such"], 3, "no-such"),
    ] {
        let output = viewer(here, args);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {stderr}");
        assert!(stderr.contains(says), "{args:?}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{args:?}: {stderr}");
        assert!(output.stdout.is_empty());
    }
    let (_folder, output) = replay("key space\njump");
    assert_eq!(output.status.code(), Some(3));
    let (_folder, output) = replay("screenshot no/such/folder.png");
    assert_eq!(output.status.code(), Some(6));
}
