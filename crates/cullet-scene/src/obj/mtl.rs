//! What do the materials of an OBJ file look like?
//!
//! `Kd` is the base colour, as linear values as they stand, the way common viewers take
//! it; `map_Kd` multiplies it, `d` or `Tr` is its alpha. Exporters that write a map with
//! `Kd 0 0 0` mean the map alone. Materials are double-sided: OBJ cannot say which faces
//! have a back, and the winding of its models is often careless.
//!
//! As in `clean`, statements are put into a form in which `tobj` neither fails nor panics;
//! those without effect on the picture are dropped here.
//!
//! Source: Wavefront, "MTL material format", Advanced Visualizer manual, appendix B2.

use std::collections::BTreeMap;
use std::fmt::Write;

use glam::{Affine2, Vec2, Vec3};

use super::clean::{UNNAMED, statements, text_of};
use super::notes::Notes;
use super::pictures::Pictures;
use crate::files::Root;
use crate::{AlphaMode, LoadError, Material, Sampler, TextureRef, Wrap};

/// A material as `tobj` has it, and the library that it stands in.
pub(super) struct Found {
    material: tobj::Material,
    library: String,
}

/// Reads material libraries. Those that cannot be read cost a warning; of several
/// materials of one name the last counts.
pub(super) fn read_libraries(
    libraries: &[String],
    files: &Root,
    notes: &mut Notes,
) -> Result<BTreeMap<String, Found>, LoadError> {
    let mut found = BTreeMap::new();
    for library in libraries {
        // One name with blanks, or several names: the file system knows.
        let whole = files.read_path(library);
        let read: Vec<(&str, _)> = match whole {
            Err(LoadError::Read { .. }) if library.contains(char::is_whitespace) => {
                library.split_whitespace().map(|name| (name, files.read_path(name))).collect()
            }
            whole => vec![(library, whole)],
        };
        for (name, bytes) in read {
            match bytes {
                Ok(bytes) => found.extend(parse(name, &bytes, notes)),
                Err(error @ LoadError::Limit { .. }) => return Err(error),
                Err(error) => {
                    notes.warn_each(format!("material library {error}; its materials are white"));
                }
            }
        }
    }
    Ok(found)
}

/// The material of that name; white and with a warning if there is none.
pub(super) fn material(
    name: &str,
    found: &BTreeMap<String, Found>,
    pictures: &mut Pictures<'_>,
    notes: &mut Notes,
) -> Result<Material, LoadError> {
    let mut material = Material { name: name.into(), double_sided: true, ..Material::default() };
    let Some(Found { material: source, library }) = found.get(name) else {
        notes.warn_each(format!("material `{name}` is in no material library; white is used"));
        return Ok(material);
    };
    let color = Vec3::from(source.diffuse.unwrap_or([1.0; 3]));
    let dissolve = source.dissolve.or_else(|| {
        let transparency: f32 = source.unknown_param.get("Tr")?.parse().ok()?;
        Some(1.0 - transparency)
    });
    material.base_color = color.extend(dissolve.unwrap_or(1.0).clamp(0.0, 1.0));
    if material.base_color.w < 1.0 {
        material.alpha = AlphaMode::Blend;
        notes.warn_each(format!("material `{name}`: is meant to be blended; drawn as opaque"));
    }
    if source.dissolve_texture.is_some() {
        notes.leave_out(OTHER_MAPS);
    }
    if let Some(statement) = &source.diffuse_texture {
        let map = Map::parse(statement);
        let texture = pictures.texture(&map.path, library, map.sampler, notes)?;
        let transform = Some(map.transform).filter(|transform| *transform != Affine2::IDENTITY);
        material.base_color_texture = Some(TextureRef { texture, uv_set: 0, transform });
        if color == Vec3::ZERO {
            material.base_color = Vec3::ONE.extend(material.base_color.w);
            let text = format!("material `{name}`: has a texture and a black Kd; white is used");
            notes.warn("black", text);
        }
    }
    Ok(material)
}

/// The materials of one library by name.
fn parse(library: &str, bytes: &[u8], notes: &mut Notes) -> BTreeMap<String, Found> {
    let text = strict(library, bytes, notes);
    let (materials, _) = tobj::load_mtl_buf(&mut text.as_bytes()).unwrap_or_default();
    let found = |material: tobj::Material| {
        (material.name.clone(), Found { material, library: library.to_owned() })
    };
    materials.into_iter().map(found).collect()
}

/// The statements that matter, as `tobj` wants them: everything it requires is there.
fn strict(library: &str, bytes: &[u8], notes: &mut Notes) -> String {
    let mut strict = String::new();
    for statement in statements(&text_of(bytes, notes)) {
        let rest = statement.rest();
        let numbers: Vec<f32> = statement.words().map_while(|word| word.parse().ok()).collect();
        let mut damage = |what: &str| {
            let text = format!("{library}, line {}: {what}", statement.line);
            notes.warn("mtl", text);
        };
        // Writing to a String cannot fail.
        let _ = match &*statement.keyword().to_ascii_lowercase() {
            "newmtl" if rest.is_empty() => {
                damage("a material has no name");
                writeln!(strict, "newmtl {UNNAMED}")
            }
            "newmtl" => writeln!(strict, "newmtl {rest}"),
            "kd" => match numbers.as_slice() {
                [r, g, b, ..] if [r, g, b].iter().all(|value| value.is_finite()) => {
                    writeln!(strict, "Kd {r} {g} {b}")
                }
                [grey] if grey.is_finite() => writeln!(strict, "Kd {grey} {grey} {grey}"),
                _ => {
                    damage("Kd is not a colour in numbers; white is used");
                    Ok(())
                }
            },
            "d" | "tr" => match statement.words().last().map(str::parse::<f32>) {
                Some(Ok(value)) if value.is_finite() => {
                    let keyword = if statement.keyword().len() == 1 { "d" } else { "Tr" };
                    writeln!(strict, "{keyword} {value}")
                }
                _ => {
                    damage("the opacity is not a number; 1 is used");
                    Ok(())
                }
            },
            "map_kd" | "map_d" if rest.is_empty() => Ok(()),
            "map_kd" => writeln!(strict, "map_Kd {rest}"),
            "map_d" => writeln!(strict, "map_d {rest}"),
            "bump" | "norm" | "disp" | "decal" | "refl" => {
                notes.leave_out(OTHER_MAPS);
                Ok(())
            }
            map if map.starts_with("map_") => {
                notes.leave_out(OTHER_MAPS);
                Ok(())
            }
            _ => Ok(()),
        };
    }
    strict
}

const OTHER_MAPS: &str = "maps other than map_Kd";

/// What a `map_Kd` statement asks for.
#[derive(Debug, PartialEq)]
struct Map {
    path: String,
    sampler: Sampler,
    /// Texture coordinates with v down to the same.
    transform: Affine2,
}

impl Map {
    /// Options stand before the path, or behind it in the files of some exporters; the path
    /// may hold blanks.
    fn parse(statement: &str) -> Map {
        let (mut scale, mut offset, mut clamp) = (Vec2::ONE, Vec2::ZERO, false);
        let mut path = "";
        let mut rest = statement.trim();
        while !rest.is_empty() {
            let (word, behind) = first_word(rest);
            let Some(n_values) = n_values_of(word) else {
                if !path.is_empty() {
                    break;
                }
                (path, rest) = split_path(rest);
                continue;
            };
            rest = behind;
            let mut values = Vec::new();
            for _ in 0..n_values {
                let (value, behind) = first_word(rest);
                let number = value.parse::<f32>().ok().filter(|number| number.is_finite());
                // The count of numbers is free for some options; the path needs a word.
                let optional = n_values == 3;
                if optional && (number.is_none() || (behind.is_empty() && path.is_empty())) {
                    break;
                }
                values.extend(number);
                clamp |= word == "-clamp" && value == "on";
                rest = behind;
            }
            match (word, values.as_slice()) {
                ("-s", [u]) => scale = Vec2::new(*u, 1.0),
                ("-s", [u, v, ..]) => scale = Vec2::new(*u, *v),
                ("-o", [u]) => offset = Vec2::new(*u, 0.0),
                ("-o", [u, v, ..]) => offset = Vec2::new(*u, *v),
                _ => {}
            }
        }
        let wrap = if clamp { Wrap::Clamp } else { Wrap::Repeat };
        // With v up, uv' = scale * uv + offset; here v counts from the other end.
        let translation = Vec2::new(offset.x, 1.0 - scale.y - offset.y);
        Map {
            path: path.trim_matches('"').to_owned(),
            sampler: Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() },
            transform: Affine2::from_scale_angle_translation(scale, 0.0, translation),
        }
    }
}

/// How many values follow an option, at most for those with three; `None` for other words.
fn n_values_of(word: &str) -> Option<usize> {
    match word {
        "-blendu" | "-blendv" | "-boost" | "-bm" | "-cc" | "-clamp" | "-imfchan" | "-texres"
        | "-type" => Some(1),
        "-mm" => Some(2),
        "-o" | "-s" | "-t" => Some(3),
        _ => None,
    }
}

/// A path and what follows it: all up to the next word that is an option.
fn split_path(text: &str) -> (&str, &str) {
    let mut end = 0;
    let mut rest = text;
    while !rest.is_empty() {
        let (word, behind) = first_word(rest);
        if n_values_of(word).is_some() {
            break;
        }
        rest = behind;
        end = text.len() - rest.len();
    }
    (text[..end].trim_end(), &text[end..])
}

fn first_word(text: &str) -> (&str, &str) {
    let text = text.trim_start();
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_map(statement: &str, path: &str, scale: [f32; 2], translation: [f32; 2], wrap: Wrap) {
        let expected = Map {
            path: path.into(),
            sampler: Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() },
            transform: Affine2::from_scale_angle_translation(scale.into(), 0.0, translation.into()),
        };
        assert_eq!(Map::parse(statement), expected);
    }

    #[test]
    fn map_options_stand_around_a_path_with_blanks() {
        let (one, none, tiled) = ([1.0; 2], [0.0; 2], Wrap::Repeat);
        check_map("a.png", "a.png", one, none, tiled);
        check_map("my wall 1.png", "my wall 1.png", one, none, tiled);
        check_map("\"my wall.png\"", "my wall.png", one, none, tiled);
        check_map("-clamp on a.png", "a.png", one, none, Wrap::Clamp);
        check_map("-clamp off -bm 0.5 a b.png", "a b.png", one, none, tiled);
        check_map("a.png -bm 1.5", "a.png", one, none, tiled);
        check_map("-s 2 2 2 a.png", "a.png", [2.0, 2.0], [0.0, -1.0], tiled);
        check_map("-s 4 a.png", "a.png", [4.0, 1.0], none, tiled);
        check_map("-o 0.1 0.25 2.png", "2.png", one, [0.1, -0.25], tiled);
        check_map("-s 1 3 -o 0.5 0.5 0 -mm 0 1 7", "7", [1.0, 3.0], [0.5, -2.5], tiled);
        check_map("-blendu on -texres 512 -type sphere a.png", "a.png", one, none, tiled);
        check_map("-s", "", one, none, tiled);
        check_map("-s nan a.png", "nan a.png", one, none, tiled);
    }

    #[track_caller]
    fn check_strict(text: &str, expected: &str, n_warnings: usize) {
        let mut notes = Notes::default();
        assert_eq!(strict("a.mtl", text.as_bytes(), &mut notes), expected);
        assert_eq!(notes.finish("a.obj").0.len(), n_warnings);
    }

    #[test]
    fn statements_become_what_tobj_can_read() {
        check_strict("newmtl\nKd 0.5", "newmtl unnamed\nKd 0.5 0.5 0.5\n", 1);
        check_strict(" newmtl a b \n  kd 1 0 0 # red", "newmtl a b\nKd 1 0 0\n", 0);
        check_strict("newmtl a\nKd spectral a.rfl 1\nNs x\nillum\nbump", "newmtl a\n", 1);
        check_strict("newmtl a\nd -halo 0.5\nTr 0.25\nd nan", "newmtl a\nd 0.5\nTr 0.25\n", 1);
        check_strict("\u{feff}newmtl a\nmap_Kd  x y.png", "newmtl a\nmap_Kd x y.png\n", 0);
    }
}
