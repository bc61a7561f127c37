use std::io::Read;
use std::process::Stdio;

use crate::run::{Folder, Ran};

const SMALL: &str = "render synth:sphere:8 --size 16x12";

#[test]
fn a_dash_is_a_png_on_standard_output() {
    let folder = Folder::new();
    let ran = folder.ok(&format!("{SMALL} -o -"));
    folder.ok(&format!("{SMALL} -o x.png"));
    assert_eq!(ran.stdout, folder.read("x.png"));
    let image = image::load_from_memory(&ran.stdout).unwrap();
    assert_eq!((image.width(), image.height()), (16, 12));
}

#[test]
fn words_go_to_standard_error_only() {
    let folder = Folder::new();
    let ran = folder.ok(&format!("{SMALL} -o x.png --passes color,depth --stats -"));
    assert!(ran.stderr.contains("x.depth.png: black is"), "{}", ran.stderr);
    let stats: serde_json::Value = serde_json::from_slice(&ran.stdout).unwrap();
    assert_eq!(stats["schema"], 1);
}

#[test]
fn a_closed_reader_is_no_error() {
    let folder = Folder::new();
    for line in [
        "render synth:sphere:8 --size 512x512 -o -",
        "synth box-grid:2",
        "synth --list",
        "--help",
        "--version",
    ] {
        let mut command = folder.command(line);
        let mut run = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(run.stdout.take());
        let mut words = String::new();
        run.stderr.take().unwrap().read_to_string(&mut words).unwrap();
        assert_eq!(run.wait().unwrap().code(), Some(0), "{line}: {words}");
        assert!(words.is_empty(), "{line}: {words}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_directly() {
    let folder = Folder::new();
    folder.ok(&format!("{SMALL} -o /dev/null"));
    folder.ok(&format!("{SMALL} -o x.png --stats /dev/null"));
    folder.fails(6, "/dev/full", &format!("{SMALL} -o /dev/full"));
    folder.fails(2, "/dev/null", &format!("{SMALL} -o /dev/null --passes color,depth"));
    for line in ["--help", "--version", "render --help", "synth --list"] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let ran = Ran::from(folder.command(line).stdout(full).output().unwrap());
        assert_eq!(ran.code, Some(6), "{line}: {}", ran.stderr);
        assert!(ran.stderr.contains("standard output"), "{line}: {}", ran.stderr);
    }
    let stdout = folder.ok(&format!("{SMALL} -o /dev/stdout")).stdout;
    assert_eq!(stdout, folder.read("x.png"));
    assert_eq!(folder.names(), ["x.png"]);
}

#[cfg(unix)]
#[test]
fn pipes_and_links_stay_what_they_are() {
    use std::os::unix::fs::FileTypeExt;
    let folder = Folder::new();
    let made = std::process::Command::new("mkfifo").arg(folder.path("p.png")).status().unwrap();
    assert!(made.success());
    let pipe = folder.path("p.png");
    let reader = std::thread::spawn(move || std::fs::read(pipe).unwrap());
    folder.ok(&format!("{SMALL} -o p.png"));
    std::os::unix::fs::symlink("x.png", folder.path("link.png")).unwrap();
    folder.ok(&format!("{SMALL} -o link.png"));
    assert_eq!(reader.join().unwrap(), folder.read("x.png"));
    assert!(std::fs::metadata(folder.path("p.png")).unwrap().file_type().is_fifo());
    assert!(std::fs::symlink_metadata(folder.path("link.png")).unwrap().is_symlink());
}

#[test]
fn a_failed_run_keeps_the_old_picture() {
    let folder = Folder::new();
    folder.write("x.png", "old");
    folder.write(".x.png.cullet-tmp", "left by a killed run");
    folder.fails(3, "none.glb", "render none.glb -o x.png");
    assert_eq!(folder.read("x.png"), b"old");
    folder.ok(&format!("{SMALL} -o x.png"));
    assert_eq!(folder.names(), ["x.png"]);
    assert!(folder.read("x.png").starts_with(b"\x89PNG"));
}

#[test]
fn a_scene_goes_through_a_file_and_a_pipe() {
    let folder = Folder::new();
    folder.ok("synth spheres -o s.glb");
    let render = "--size 48x32 --camera 0 -o";
    folder.ok(&format!("render s.glb {render} file.png"));
    folder.ok(&format!("render synth:spheres {render} direct.png"));
    let mut command = folder.command(&format!("render - {render} -"));
    command.stdin(std::fs::File::open(folder.path("s.glb")).unwrap());
    let piped = Ran::from(command.output().unwrap());
    assert_eq!(piped.code, Some(0), "{}", piped.stderr);
    assert_eq!(piped.stdout, folder.read("file.png"));
    folder.ok("diff file.png direct.png --fail-above max=1");
    assert_eq!(folder.ok("synth spheres").stdout, folder.read("s.glb"));
}
