use crate::run::Folder;

/// A folder with a picture, one that differs in one pixel by 3, one
/// where that pixel is white, and a smaller one.
fn pictures() -> Folder {
    let folder = Folder::new();
    let mut image = image::RgbImage::from_fn(20, 10, |x, y| image::Rgb([x as u8, y as u8, 9]));
    image.save(folder.path("a.png")).unwrap();
    image::imageops::crop_imm(&image, 0, 0, 10, 10)
        .to_image()
        .save(folder.path("small.png"))
        .unwrap();
    image[(4, 4)].0[1] += 3;
    image.save(folder.path("b.png")).unwrap();
    image[(4, 4)].0 = [255; 3];
    image.save(folder.path("spot.png")).unwrap();
    folder
}

#[test]
fn equal_pictures_pass_everything() {
    let folder = pictures();
    folder.ok("diff a.png a.png");
    folder.ok("diff a.png a.png --fail-below psnr=40 --fail-above max=0 --fail-below ssim=1");
    let json = folder.ok("diff a.png a.png --json").stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!((&json["metrics"]["psnr"], &json["equal"]), (&"inf".into(), &true.into()));
    assert_eq!((&json["metrics"]["ssim"], &json["passed"]), (&1.0.into(), &true.into()));
}

#[test]
fn differences_are_1_unless_a_threshold_allows_them() {
    let folder = pictures();
    folder.fails(1, "differ", "diff a.png b.png");
    folder.ok("diff a.png b.png --fail-above max=3");
    folder.ok("diff a.png b.png --metric psnr --fail-above changed=1");
    folder.fails(1, "max 3 is above 2", "diff a.png b.png --fail-above max=2 --fail-below psnr=1");
    folder.fails(1, "psnr", "diff a.png b.png --fail-below psnr=inf");
    let json = folder.run("diff a.png b.png --json --metric max,changed").stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["metrics"], serde_json::json!({ "max": 3.0, "changed": 1.0 }));
    assert_eq!(json["equal"], false);
}

#[test]
fn sizes_that_differ_are_1_and_said() {
    let folder = pictures();
    folder.fails(1, "a.png is 20x10, small.png is 10x10", "diff a.png small.png");
}

#[test]
fn usage_and_input() {
    let folder = pictures();
    folder.write("text.png", "no picture");
    folder.fails(3, "text.png", "diff a.png text.png");
    folder.fails(2, "METRIC=VALUE", "diff a.png b.png --fail-above max");
    folder.fails(2, "nan", "diff a.png b.png --fail-above max=nan");
    folder.fails(2, "size", "diff a.png b.png --metric size");
    folder.fails(2, "heatmap", "diff a.png b.png --heatmap -");
    folder.fails(6, "none", "diff a.png b.png --heatmap none/h.png");
    folder.fails(2, "is an input", "diff a.png b.png --heatmap ./b.png");
    folder.fails(2, "changed", "diff a.png b.png --fail-above foo=1");
    folder.fails(2, "standard input", "diff a.png -");
    folder.fails(3, "cullet render k.glb", "diff a.png k.glb");
    folder.fails(3, ".exr", "diff a.f32 a.f32");
}

#[cfg(feature = "exr")]
#[test]
fn data_is_compared_as_it_is() {
    let folder = Folder::new();
    let render = "render synth:sphere:8 --size 16x12 --passes depth";
    let moved =
        r#"{"eye":[0,0,50],"target":[0,0,0],"up":[0,1,0],"yfov_deg":9,"znear":1,"zfar":null}"#;
    folder.write("near.json", moved);
    folder.write("far.json", moved.replace("50", "51"));
    folder.ok(&format!("{render} -o near.exr --camera near.json"));
    folder.ok(&format!("{render} -o far.exr --camera far.json"));
    folder.ok("diff near.exr near.exr --fail-above max=0"); // with inf where nothing is
    let json = folder.run("diff near.exr far.exr --json --metric max,psnr").stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["equal"], false);
    // A screen clamps both to white; the data differ by the step back.
    assert_eq!(json["metrics"]["psnr"], "inf");
    assert!(json["metrics"]["max"].as_f64().is_some_and(|max| (max - 1.0).abs() < 0.1), "{json}");
}

#[test]
fn the_heatmap_is_as_large_as_the_pictures() {
    let folder = pictures();
    folder.fails(1, "differ", "diff a.png spot.png --heatmap h.png");
    let heat = folder.image("h.png").to_rgb8();
    assert_eq!(heat.dimensions(), (20, 10));
    assert!(heat[(4, 4)].0.iter().any(|c| *c > 0));
}
