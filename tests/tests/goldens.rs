//! Every shipped scene still looks as it was blessed.

use cullet_tests::golden::{TOLERANCE, all, save};

#[test]
fn shipped_scenes_look_as_blessed() {
    let mut differing = Vec::new();
    for golden in all() {
        let frame = golden.render();
        let kept = image::open(golden.path())
            .unwrap_or_else(|e| panic!("{}: {e}; run `cargo bless`", golden.path().display()))
            .into_rgb8();
        let same_size = kept.dimensions() == (frame.width, frame.height);
        let off = kept
            .pixels()
            .zip(&frame.rgba8)
            .map(|(a, b)| (0..3).map(|i| a.0[i].abs_diff(b[i])).max().unwrap_or(0));
        let (n, worst) = off.filter(|d| *d > TOLERANCE).fold((0, 0), |(n, w), d| (n + 1, d.max(w)));
        if !same_size || n > 0 {
            save(&frame, &golden.actual_path());
            let shown = golden.actual_path();
            differing.push(format!("{}: {n} px, by up to {worst}: {shown:?}", golden.name));
        }
    }
    assert!(differing.is_empty(), "run `cargo bless` and look:\n{}", differing.join("\n"));
}
