//! The shipped scenes are what the commands in `scenes/README.md` make.

use cullet::scene::{synth, write_glb};
use cullet_tests::{root, shipped_scenes};

#[test]
fn shipped_scenes_are_remade_byte_for_byte() {
    let readme = std::fs::read_to_string(root().join("scenes/README.md")).unwrap();
    for path in shipped_scenes() {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let command = format!("`cullet synth {name} -o scenes/{name}.glb`");
        assert!(readme.contains(&command), "scenes/README.md does not say {command}");
        let made = write_glb(&synth::synth(name).unwrap()).unwrap();
        assert!(made == std::fs::read(&path).unwrap(), "{name} differs from what is shipped");
    }
}
