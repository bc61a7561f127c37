//! The program as it is shipped: what it draws, and what the compiler made of it.
//!
//! `CULLET_RELEASE` names a release build of `cullet` with symbols; `.ci/run` sets it to the one
//! that the README's first command has just built. Without it these tests say so and pass, since
//! an old build would judge the wrong code.

use std::path::{Path, PathBuf};
use std::process::Command;

use cullet::{Antialias, Pass, Passes, Settings, Shading};
use cullet_tests::{own_cameras, prepare_synth, render};

/// The build to look at.
fn release() -> Option<PathBuf> {
    let path = std::env::var_os("CULLET_RELEASE").map(PathBuf::from);
    if path.is_none() {
        eprintln!("skipped: CULLET_RELEASE does not name a release build of cullet");
    }
    path
}

/// Debug and release: all optimisations draw what this build draws, to the last bit of every float.
#[test]
fn a_release_build_draws_the_same() {
    let Some(cullet) = release() else { return };
    let size = [200, 137];
    let aa = [("none", Antialias::None), ("msaa4", Antialias::Msaa4)];
    for (spec, (aa, antialias)) in
        ["city:2", "masks", "sphere:96"].into_iter().flat_map(|spec| aa.map(|aa| (spec, aa)))
    {
        let prepared = prepare_synth(spec);
        let camera = own_cameras(&prepared).swap_remove(0);
        let passes = Passes::COLOR.with(Pass::Linear);
        let shading = Shading::Lambert;
        let settings = Settings { shading, passes, antialias, ..Settings::default() };
        let frame = render(&prepared, &camera, size, &settings);
        let floats = frame.linear.iter().flat_map(|color| color.to_array());
        let here: Vec<u8> = floats.flat_map(f32::to_le_bytes).collect();
        let there = drawn_by(&cullet, spec, aa, size);
        assert!(here.iter().any(|&byte| byte != 0), "{spec}: nothing to see");
        assert!(here == there, "{spec}, {aa}: a release build draws something else");
    }
}

/// The linear colours that a program draws.
fn drawn_by(cullet: &Path, spec: &str, aa: &str, [width, height]: [u32; 2]) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = folder.join(format!("release-{}-{aa}.f32", spec.replace(':', "-")));
    let status = Command::new(cullet)
        .args(["render", &format!("synth:{spec}"), "--camera", "0", "--shading", "lambert"])
        .args(["--aa", aa, "--size", &format!("{width}x{height}"), "-o"])
        .arg(&file)
        .status()
        .unwrap_or_else(|e| panic!("{}: {e}", cullet.display()));
    assert!(status.success(), "{spec}: {status}");
    std::fs::read(&file).unwrap()
}

/// LLVM 22 folds a load, a float select and a store to one address into `vmaskmovps` on AVX2, which
/// is microcode on AMD and holds up the load after it: a filled picture took 5.7 times as long.
/// Selecting as integers avoids it. (`vpmaskmovd` is no better.)
///
/// Of loops of eight it makes gathers where the places are words, as bytes or with a length of their own they stay
/// eight loads: with gathers a depth pass took 1.05 of the time on average (AVX-512, Intel).
#[test]
fn no_masked_moves_or_gathers_in_kernels() {
    let Some(cullet) = release() else { return };
    let output = Command::new("objdump")
        .args(["--disassemble", "--demangle", "--no-show-raw-insn", "--no-addresses"])
        .arg(&cullet)
        .output();
    let Ok(output) = output else {
        eprintln!("skipped: there is no objdump (binutils)");
        return;
    };
    assert!(output.status.success(), "objdump: {}", output.status);
    let text = String::from_utf8_lossy(&output.stdout);
    let kernels = kernels(&text);

    // Not blind: there are kernels, and 256-bit code in them (on x86).
    assert!(kernels.len() > 20, "{} functions of the stages", kernels.len());
    let wide = kernels.iter().filter(|(_, body)| body.contains("%ymm")).count();
    assert!(wide > 0 || !cfg!(target_arch = "x86_64"), "no function uses 256-bit registers");

    let masked: Vec<_> = kernels
        .iter()
        .filter(|(_, body)| slow_moves(body) > 0)
        .map(|(name, body)| format!("{name}: {}", slow_moves(body)))
        .collect();
    assert!(masked.is_empty(), "masked moves or gathers in\n{}", masked.join("\n"));
}

/// Functions of this project's stages in a disassembly, with their code.
fn kernels(text: &str) -> Vec<(&str, &str)> {
    let functions = text.split("\n\n").filter_map(|function| {
        let (head, body) = function.trim_start().split_once('\n')?;
        let name = head.strip_suffix(">:")?.split_once('<')?.1;
        Some((name, body))
    });
    let ours = |name: &str| {
        // What is compiled for an instruction set is inlined into the function that switches to it.
        let homes = ["cull", "raster", "shade", "transform"].map(|s| format!("cullet_{s}::"));
        let others = ["cullet::", "fearless_simd::"];
        homes.iter().map(String::as_str).chain(others).any(|home| name.contains(home))
    };
    functions.filter(|(name, _)| ours(name)).collect()
}

fn slow_moves(body: &str) -> usize {
    const SLOW: [&str; 4] = ["vmaskmov", "vpmaskmov", "vgather", "vpgather"];
    let mnemonics = body.lines().filter_map(|line| line.split_whitespace().next());
    mnemonics.filter(|name| SLOW.iter().any(|slow| name.starts_with(slow))).count()
}

#[test]
fn a_slow_move_would_be_found() {
    let text = "\n<cullet_raster::cover::fill>:\n\tvmovaps %ymm0,%ymm1\n\tvmaskmovps %ymm0,%ymm1,(%rdi)\n\tret\n\n\
                <cullet_shade::srgb::encode>:\n\tvmovaps %ymm0,%ymm1\n\tret\n\n\
                <cullet_raster::draw::draw>:\n\tvpgatherdd 0x60(%rcx,%ymm2,4),%ymm4{%k2}\n\tret\n\n\
                <memchr::find>:\n\tvpmaskmovd %ymm0,%ymm1,(%rdi)\n";
    let kernels = kernels(text);
    let found: Vec<_> = kernels.iter().map(|(name, body)| (*name, slow_moves(body))).collect();
    let wanted = [
        ("cullet_raster::cover::fill", 1),
        ("cullet_shade::srgb::encode", 0),
        ("cullet_raster::draw::draw", 1),
    ];
    assert_eq!(found, wanted);
}
