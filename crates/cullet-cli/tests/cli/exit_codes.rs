use crate::run::{Folder, TRIANGLE};

const SMALL: &str = "render synth:sphere:8 --size 16x12";

#[test]
fn done_is_0() {
    let folder = Folder::new();
    folder.ok("--version");
    folder.ok("--help");
    folder.ok("render --help");
    folder.ok("synth --list");
    folder.ok(&format!("{SMALL} -o x.png"));
    assert_eq!(folder.names(), ["x.png"]);
}

#[test]
fn wrong_usage_is_2() {
    let folder = Folder::new();
    folder.fails(2, "", "");
    folder.fails(2, "", "frobnicate");
    folder.fails(2, "", "render");
    folder.fails(2, "extension", &format!("{SMALL} -o x.gif"));
    folder.fails(2, "extension", &format!("{SMALL} -o x"));
    folder.fails(2, "size", "render synth:sphere:8 -o x.png --size 0x5");
    folder.fails(2, "teapot", "render synth:teapot -o x.png");
    folder.fails(2, "no camera `7`", &format!("{SMALL} -o x.png --camera 7"));
    folder.fails(2, "no camera `left`", &format!("{SMALL} -o x.png --camera left"));
    folder.fails(2, "msaa3", &format!("{SMALL} -o x.png --aa msaa3"));
    folder.fails(2, "pbr", &format!("{SMALL} -o x.png --shading pbr"));
    folder.fails(2, "--time", &format!("{SMALL} -o x.png --time 1"));
    folder.fails(2, "direction", &format!("{SMALL} -o x.png --sun 0,0,0"));
    folder.fails(2, "ambient", &format!("{SMALL} -o x.png --ambient -1"));
    folder.fails(2, "0..=1024", &format!("{SMALL} -o x.png --threads -1"));
    folder.fails(2, "1..=65535", &format!("{SMALL} -o x.png --frames -1"));
    folder.fails(2, "1..=65535", &format!("{SMALL} -o x.png --frames 0"));
    folder.fails(2, "--region", &format!("{SMALL} -o x.png --region 10,0,7,2"));
    folder.fails(2, "--bits", &format!("{SMALL} -o x.jpg --bits 16"));
    folder.fails(2, "transparent", &format!("{SMALL} -o x.jpg --background transparent"));
    folder.fails(2, "two outputs", &format!("{SMALL} -o - --stats -"));
    folder.fails(2, "standard output", &format!("{SMALL} -o - --passes color,id"));
    folder.fails(2, "same file", &format!("{SMALL} -o x.png --stats ./x.png"));
    folder.fails(2, "synthetic", "synth teapot -o x.glb");
    folder.fails(2, "NAME", "synth");
    assert!(folder.names().is_empty());
}

#[test]
fn bad_input_is_3() {
    let folder = Folder::new();
    folder.write("text.glb", "this is no scene");
    folder.write("lost.gltf", TRIANGLE.replace("data:;base64,", "lost.bin?"));
    folder.fails(3, "none.glb", "render none.glb -o x.png");
    folder.fails(3, "did you mean synth:city:3", "render city:3 -o x.png");
    folder.fails(3, "did you mean synth:extreme:far", "render extreme:far -o x.png");
    folder.fails(3, "text.glb", "render text.glb -o x.png");
    folder.fails(3, "lost", "render lost.gltf -o x.png");
    folder.fails(3, "standard input", "render - -o x.png");
    folder.fails(3, "none.glb", "info none.glb");
    folder.fails(3, "a.png", "diff a.png b.png");
    folder.fails(3, "cam.json", &format!("{SMALL} -o x.png --camera cam.json"));
    folder.write(
        "cam.json",
        r#"{"eye":["nan",0,0],"target":[0,0,0],"up":[0,1,0],"yfov_deg":45,"znear":1,"zfar":null}"#,
    );
    folder.fails(3, "eye", &format!("{SMALL} -o x.png --camera cam.json"));
    assert_eq!(folder.names(), ["cam.json", "lost.gltf", "text.glb"]);
}

#[test]
fn unsupported_is_4() {
    let folder = Folder::new();
    let required = r#"{"extensionsRequired":["EXT_alien"],"extensionsUsed":["EXT_alien"],"#;
    folder.write("alien.gltf", TRIANGLE.replacen('{', required, 1));
    folder.fails(4, "EXT_alien", "render alien.gltf -o x.png");
    folder.fails(4, "EXT_alien", "info alien.gltf");
}

#[test]
fn limits_are_5_and_name_the_option() {
    let folder = Folder::new();
    folder.write("one.gltf", TRIANGLE);
    folder.fails(5, "32768", "render one.gltf -o x.png --size 32769x1");
    folder.fails(5, "--max-pixels", "render one.gltf -o x.png --size 100x100 --max-pixels 9999");
    folder.fails(5, "--max-file-bytes", "render one.gltf -o x.png --max-file-bytes 10");
    folder.fails(5, "--max-nodes", "render one.gltf -o x.png --max-nodes 1");
    folder.fails(5, "--max-triangles", "info one.gltf --max-triangles 0");
    let depth = "render one.gltf -o x.png --size 100x100 --passes depth --region 0,0,2,2";
    folder.fails(5, "--max-pixels", &format!("{depth} --max-pixels 9999"));
    folder.ok(&format!("{} --max-pixels 9999", depth.replace("x.png", "x.f32")));
    std::fs::remove_file(folder.path("x.f32")).unwrap();
    folder.fails(5, "16383", "render one.gltf -o x.webp --size 16384x1");
    assert_eq!(folder.names(), ["one.gltf"]);
}

#[test]
fn more_triangles_than_24_bits_is_5() {
    let folder = Folder::new();
    let n_bytes = 4096 * 36;
    let text = TRIANGLE.replacen("[0]", &format!("{:?}", (0..4096).collect::<Vec<_>>()), 1);
    let text = text.replace(r#"{"mesh":0,"name":"only"}"#, &[r#"{"mesh":0}"#; 4096].join(","));
    let start = text.find("AAAA").unwrap();
    let end = start + text[start..].find('"').unwrap();
    let text = format!("{}{}{}", &text[..start], "A".repeat(n_bytes / 3 * 4), &text[end..]);
    let text = text.replace(r#""byteLength":36"#, &format!(r#""byteLength":{n_bytes}"#));
    folder.write("many.gltf", text.replace(r#""count":3"#, &format!(r#""count":{}"#, 3 * 4096)));
    let line = "render many.gltf --size 8x8 --passes triangle --max-triangles 99999999";
    folder.fails(5, "16777216 triangles", &format!("{line} -o x.png"));
    assert_eq!(folder.names(), ["many.gltf"]);
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_not_there_is_5() {
    let folder = Folder::new();
    let command = folder.command("render synth:sphere:8 --size 16384x16384 --threads 1 -o x.png");
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", r#"ulimit -v 2000000; exec "$0" "$@""#]).arg(command.get_program());
    let ran = shell.args(command.get_args()).current_dir(folder.path("")).output().unwrap();
    let words = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(5), "{words}");
    assert!(words.contains("6144 MiB"), "{words}");
    assert!(folder.names().is_empty());
}

#[test]
fn outputs_that_cannot_be_written_are_6() {
    let folder = Folder::new();
    folder.write("locked.png", "mine");
    let mut permissions = std::fs::metadata(folder.path("locked.png")).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(folder.path("locked.png"), permissions).unwrap();
    folder.fails(6, "no folder `none`", &format!("{SMALL} -o none/x.png"));
    std::fs::create_dir(folder.path("d")).unwrap();
    folder.fails(6, "is a folder", &format!("{SMALL} -o d"));
    std::fs::remove_dir(folder.path("d")).unwrap();
    folder.fails(6, "none/s.json", &format!("{SMALL} -o x.png --stats none/s.json"));
    folder.fails(6, "read-only", &format!("{SMALL} -o locked.png"));
    // Said before the scene is even looked for.
    folder.fails(6, "none/x.png", "render none.glb -o none/x.png");
    assert_eq!(folder.names(), ["locked.png"]);
    assert_eq!(folder.read("locked.png"), b"mine");
}

#[test]
fn inputs_are_no_outputs() {
    let folder = Folder::new();
    folder.write("k.gltf", TRIANGLE);
    folder.write("cam.json", "{}");
    for options in
        ["-o x.png --stats k.gltf", "-o x.png --legend ./k.gltf", "-o x.png --stats ../cam.json"]
    {
        let parent = folder.path("").file_name().unwrap().to_string_lossy().into_owned();
        let options = options.replace("..", &format!("../{parent}"));
        let line = format!("render k.gltf --camera cam.json {options}");
        folder.fails(2, "is an input", &line);
    }
    assert_eq!(folder.read("k.gltf"), TRIANGLE.as_bytes());
    assert_eq!(folder.names(), ["cam.json", "k.gltf"]);
}

#[cfg(unix)]
mod signals {
    use std::process::{Child, Command, ExitStatus, Stdio};
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use crate::run::Folder;

    const LONG: Duration = Duration::from_secs(60);

    /// Rendering frames without end, its unfinished outputs in the folder.
    fn busy(folder: &Folder, mut command: Command) -> Child {
        let run = command.stderr(Stdio::null()).spawn().unwrap();
        let begun = Instant::now();
        while folder.names().len() < 2 && begun.elapsed() < LONG {
            sleep(Duration::from_millis(5));
        }
        assert_eq!(folder.names(), [".s.json.cullet-tmp", ".x.png.cullet-tmp"]);
        run
    }

    fn send(signal: &str, run: &Child) {
        let kill = Command::new("kill").args(["-s", signal, &run.id().to_string()]).status();
        assert!(kill.unwrap().success());
    }

    /// How `run` ended, if it did within `patience`.
    fn end(run: &mut Child, patience: Duration) -> Option<ExitStatus> {
        let begun = Instant::now();
        loop {
            let status = run.try_wait().unwrap();
            if status.is_some() || begun.elapsed() > patience {
                return status;
            }
            sleep(Duration::from_millis(5));
        }
    }

    fn ends_with(code: i32, run: &mut Child, folder: &Folder) {
        let status = end(run, LONG);
        if status.is_none() {
            run.kill().unwrap();
        }
        assert_eq!(status.expect("the run goes on").code(), Some(code));
        assert!(folder.names().is_empty());
    }

    const FRAMES: &str =
        "render synth:sphere:8 --size 2048x2048 --frames 60000 -o x.png --stats s.json";

    #[test]
    fn they_have_their_codes_and_leave_nothing() {
        // A test run under nohup hands HUP on ignored; the test below holds what then happens.
        let hang_up = (!super::hang_up_is_ignored()).then_some(("HUP", 129));
        for (signal, code) in [("INT", 130), ("TERM", 143)].into_iter().chain(hang_up) {
            let folder = Folder::new();
            let mut run = busy(&folder, folder.command(FRAMES));
            send(signal, &run);
            ends_with(code, &mut run, &folder);
        }
    }

    #[test]
    fn hang_up_stays_ignored_under_nohup() {
        let folder = Folder::new();
        let plain = folder.command(FRAMES);
        let mut shell = Command::new("sh");
        shell.args(["-c", r#"trap "" HUP; exec "$0" "$@""#]).arg(plain.get_program());
        shell.args(plain.get_args()).current_dir(plain.get_current_dir().unwrap());
        let mut run = busy(&folder, shell);
        send("HUP", &run);
        assert_eq!(end(&mut run, Duration::from_millis(300)), None);
        send("TERM", &run);
        ends_with(143, &mut run, &folder);
    }
}

/// Whether this test run was told to ignore SIGHUP, which its children then inherit.
#[cfg(unix)]
fn hang_up_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() & 1 == 1)
}
