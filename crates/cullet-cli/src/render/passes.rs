//! Which picture goes to which file?

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use cullet::Pass;

use super::args::RenderArgs;
use crate::exit::Failure;
use crate::output::{Target, is_device};
use crate::picture_file::Format;

/// A kind of picture on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PassName {
    /// Shaded colour; floats are linear, with alpha
    Color,
    /// Distance along the view axis, scene units; integers span the nearest to the farthest
    /// thing in the whole picture, and white is also nothing
    Depth,
    /// Unit normal in world space; integers hold n / 2 + 1/2
    Normal,
    /// Base colour without light; floats are linear, with alpha
    Albedo,
    /// Texture coordinates; integers hold what is behind the point, in red and green
    Uv,
    /// World-space position; integers span the bounds of the scene, and nothing is black
    Position,
    /// Object number + 1, 0 for nothing; integers hold 24 bits, red highest
    Id,
    /// Triangle number + 1 over all objects in scene order, 0 for nothing; stored like `id`
    Triangle,
}

impl PassName {
    /// As it stands in file names.
    fn name(self) -> &'static str {
        match self {
            PassName::Color => "color",
            PassName::Depth => "depth",
            PassName::Normal => "normal",
            PassName::Albedo => "albedo",
            PassName::Uv => "uv",
            PassName::Position => "position",
            PassName::Id => "id",
            PassName::Triangle => "triangle",
        }
    }

    /// Where nothing is, shows the background.
    fn shows_background(self) -> bool {
        matches!(self, PassName::Color | PassName::Albedo)
    }

    /// Holds numbers of things: 24 bits as integers, which must not be blurred.
    pub fn is_number(self) -> bool {
        matches!(self, PassName::Id | PassName::Triangle)
    }
}

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bits {
    /// 8-bit integers.
    U8,
    /// 16-bit integers.
    U16,
    /// Floats.
    F32,
}

/// One picture to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// What it shows.
    pub pass: PassName,
    /// Where it goes.
    pub target: Target,
    /// In which format.
    pub format: Format,
    /// How it stores numbers.
    pub bits: Bits,
    /// It keeps the alpha of a transparent background.
    pub alpha: bool,
}

impl Picture {
    /// The renderer's pass that it is made from.
    pub fn source(&self) -> Pass {
        match self.pass {
            PassName::Color if self.bits == Bits::U8 => Pass::Color,
            PassName::Color => Pass::Linear,
            PassName::Depth => Pass::Depth,
            PassName::Normal => Pass::Normal,
            PassName::Albedo => Pass::Albedo,
            PassName::Uv => Pass::Uv,
            PassName::Position => Pass::Position,
            PassName::Id => Pass::Id,
            PassName::Triangle => Pass::Triangle,
        }
    }
}

/// The pictures that the options ask for, in the order asked; refuses what no file can hold.
pub fn plan(args: &RenderArgs) -> Result<Vec<Picture>, Failure> {
    let out = &args.output;
    let format = format(out)?;
    let bits = match (format.is_float(), args.bits.as_str()) {
        (true, _) => Bits::F32,
        (false, "16") if format.has_16_bits() => Bits::U16,
        (false, "16") => {
            return Err(Failure::usage(format!(
                "--bits 16 needs .png or .ppm, not {}",
                out.display()
            )));
        }
        (false, _) => Bits::U8,
    };
    let transparent = args.background.w < 1.0;
    let shows_background = args.passes.iter().any(|pass| pass.shows_background());
    if transparent && shows_background && !format.has_alpha() {
        let out = out.display();
        return Err(Failure::usage(format!(
            "{out} cannot hold a transparent background; write a .png, .webp or .exr"
        )));
    }
    if format == Format::Jpeg
        && let Some(pass) = args.passes.iter().find(|pass| pass.is_number())
    {
        let (out, pass) = (out.display(), pass.name());
        return Err(Failure::usage(format!("{out} would blur {pass} numbers; write a .png")));
    }
    let alpha = (transparent && format.has_alpha()) || format.is_float();
    let picture = |pass, target| Picture { pass, target, format, bits, alpha };
    match *args.passes.as_slice() {
        [pass] => Ok(vec![picture(pass, Target::from(out.as_path()))]),
        _ if Target::from(out.as_path()) == Target::Stdout => {
            Err(Failure::usage("several passes cannot share standard output; name a file for them"))
        }
        _ if is_device(out) => Err(Failure::usage(format!(
            "several passes cannot share {}; name a file for them",
            out.display()
        ))),
        ref passes => Ok(passes
            .iter()
            .map(|pass| picture(*pass, Target::File(with_pass(out, *pass))))
            .collect()),
    }
}

/// What the extension says; PNG for standard output and for devices.
fn format(out: &Path) -> Result<Format, Failure> {
    if let Some(format) = Format::of(out) {
        return Ok(format);
    }
    if Target::from(out) == Target::Stdout || is_device(out) {
        return Ok(Format::Png);
    }
    if out.is_dir() {
        return Err(Failure::output(format!("{}: is a folder; name a file", out.display())));
    }
    let exr = if cfg!(feature = "exr") { ".exr, " } else { "" };
    Err(Failure::usage(format!(
        "{}: the extension names no format; use .png, .jpg, .webp, {exr}.ppm or .f32",
        out.display()
    )))
}

/// `x.png` to `x.depth.png`.
fn with_pass(out: &Path, pass: PassName) -> PathBuf {
    let mut name = out.file_stem().map_or_else(OsString::new, OsString::from);
    name.push(".");
    name.push(pass.name());
    if let Some(extension) = out.extension() {
        name.push(".");
        name.push(extension);
    }
    out.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pass_stands_before_the_extension() {
        let named = |out: &str| with_pass(Path::new(out), PassName::Id);
        assert_eq!(named("x.png"), Path::new("x.id.png"));
        assert_eq!(named("a.b/x.y.exr"), Path::new("a.b/x.y.id.exr"));
    }

    #[test]
    fn names_in_files_are_names_on_the_command_line() {
        for pass in PassName::value_variants() {
            assert_eq!(pass.to_possible_value().unwrap().get_name(), pass.name());
        }
    }
}
