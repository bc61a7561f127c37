//! `cullet verify`: do the pictures have the bytes they should have, however they are drawn?

mod list;
mod pictures;

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cullet::cull::wide::levels;
use cullet::{Level, Settings};

use crate::exit::Failure;
use crate::message::note;
use crate::output::{Outputs, Target, print};
use crate::render::{SimdName, tile_size};
use list::{List, line};
use pictures::{Pictures, SHIPPED};

/// The hashes this version promises, re-made by
/// `cullet verify --bless crates/cullet-cli/src/verify/shipped.txt`.
const PROMISED: &str = include_str!("shipped.txt");

/// Draw the scenes Cullet ships and compare a hash of each with the list of this version.
///
/// Prints a line per scene, hash and name. The program brings the scenes and the list along. Any
/// other bytes than the listed ones, for any of the numbers of threads, instruction sets and tile
/// sizes asked for, end in exit code 1.
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Shipped scenes by name, files, or `synth:NAME` [default: every shipped scene]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Numbers of threads to draw with; 0 means one per core
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "1,3")]
    #[arg(allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: Vec<u16>,
    /// Instruction sets to draw with, or `all` that this machine has
    #[arg(long, value_name = "all|LEVEL,…", value_delimiter = ',', default_value = "all")]
    #[arg(value_parser = simd)]
    simd: Vec<Simd>,
    /// Sides of the tiles to draw in, px
    #[arg(long, value_name = "PX,…", value_delimiter = ',', default_value = "64,24")]
    #[arg(value_parser = tile_size)]
    tile_size: Vec<u32>,
    /// Compare with this list instead of the built-in one
    #[arg(long, value_name = "FILE")]
    list: Option<PathBuf>,
    /// Compare with nothing but each other, and write the list; `-` is standard output
    #[arg(long, value_name = "FILE", conflicts_with = "list")]
    bless: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug)]
enum Simd {
    All,
    One(SimdName),
}

fn simd(text: &str) -> Result<Simd, String> {
    if text == "all" {
        return Ok(Simd::All);
    }
    SimdName::from_str(text, false)
        .map(Simd::One)
        .map_err(|_| "give all, auto, fallback, sse2, sse4.2, avx2, avx512 or neon".into())
}

/// One way to draw, with its words.
struct Variant {
    name: String,
    settings: Settings,
}

/// Draws, prints and compares.
pub fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let variants = variants(args)?;
    let promised = promised(args)?;
    let target = args.bless.as_deref().map(Target::from);
    let mut outputs = Outputs::open(target.as_slice())?;
    let scenes: Vec<String> = match args.scenes.is_empty() {
        true => SHIPPED.map(String::from).to_vec(),
        false => args.scenes.clone(),
    };

    let mut blessed = List::default();
    let mut n_off = 0;
    for scene in &scenes {
        let hashes = hashes(scene, &variants)?;
        let (first, _) = &hashes[0];
        if target != Some(Target::Stdout) {
            print(line(first, scene).as_bytes())?;
        }
        blessed.set(scene, first);
        let problems = match &promised {
            None => differences(first, &hashes),
            Some(list) => match list.get(scene) {
                Some(expected) => differences(expected, &hashes),
                None => vec!["is not in the list".into()],
            },
        };
        n_off += usize::from(!problems.is_empty());
        for problem in problems {
            note(format_args!("{scene}: {problem}"));
        }
    }

    if n_off > 0 {
        return Err(Failure::differs(format!("{n_off} of {} scenes differ", scenes.len())));
    }
    if target.is_some() {
        outputs.write(0, blessed.text().as_bytes())?;
    }
    outputs.commit()?;
    note(format_args!("{} scenes, the same bytes in {} ways", scenes.len(), variants.len()));
    Ok(())
}

/// Every number of threads with every instruction set and every size of tiles.
fn variants(args: &VerifyArgs) -> Result<Vec<Variant>, Failure> {
    let mut simds: Vec<(String, Level)> = Vec::new();
    for simd in &args.simd {
        match simd {
            Simd::All => {
                let all = levels().into_iter().map(|(name, level)| (name.to_owned(), level));
                simds.extend(all);
            }
            Simd::One(one) => {
                let name = one.to_possible_value().map(|value| value.get_name().to_owned());
                simds.push((name.unwrap_or_default(), one.level()?));
            }
        }
    }
    let mut variants = Vec::new();
    for (name, simd) in simds {
        let name = name.replace("scalar", "fallback");
        for &threads in &args.threads {
            for &tile_px in &args.tile_size {
                let name = format!("--simd {name}, --threads {threads}, --tile-size {tile_px}");
                let threads = threads.into();
                let settings = Settings { simd, threads, tile_px, ..Settings::default() };
                variants.push(Variant { name, settings });
            }
        }
    }
    Ok(variants)
}

/// What to compare with, unless a new list is made.
fn promised(args: &VerifyArgs) -> Result<Option<List>, Failure> {
    if args.bless.is_some() {
        return Ok(None);
    }
    let (name, text) = match &args.list {
        None => (Path::new("the built-in list"), PROMISED.to_owned()),
        Some(path) => {
            let text = fs::read_to_string(path);
            let wrong =
                |error| Failure::input(format!("{}: cannot be read: {error}", path.display()));
            (path.as_path(), text.map_err(wrong)?)
        }
    };
    let list = List::parse(&text);
    list.map(Some).map_err(|problem| Failure::input(format!("{}: {problem}", name.display())))
}

/// The hash of a scene drawn each way, with the name of the way.
fn hashes<'a>(scene: &str, variants: &'a [Variant]) -> Result<Vec<(String, &'a str)>, Failure> {
    let pictures = Pictures::of(scene)?;
    let hash = |variant: &'a Variant| (pictures.hash(&variant.settings), variant.name.as_str());
    Ok(variants.iter().map(hash).collect())
}

/// A sentence per way that gave other bytes; one for all if all gave the same.
fn differences(expected: &str, hashes: &[(String, &str)]) -> Vec<String> {
    let (first, _) = &hashes[0];
    let agree = hashes.iter().all(|(hash, _)| hash == first);
    if agree && first != expected {
        return vec![format!("{first}, but {expected} is promised")];
    }
    let off = hashes.iter().filter(|(hash, _)| hash != expected);
    off.map(|(hash, way)| format!("{hash} with {way}, but {expected} is promised")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_list_names_the_shipped_scenes() {
        let list = List::parse(PROMISED).unwrap();
        for scene in SHIPPED {
            assert!(list.get(scene).is_some(), "{scene}");
        }
        assert_eq!(list.text(), PROMISED, "not as --bless writes it");
    }

    #[test]
    fn what_differs_is_said_once_or_by_the_way_it_was_drawn() {
        let [a, b, c] = ["a", "b", "c"].map(String::from);
        assert_eq!(differences("a", &[(a.clone(), "x"), (a.clone(), "y")]), [""; 0]);
        let all = differences("c", &[(a.clone(), "x"), (a.clone(), "y")]);
        assert_eq!(all, ["a, but c is promised"]);
        let some = differences("a", &[(a, "x"), (b, "y"), (c, "z")]);
        assert_eq!(some, ["b with y, but a is promised", "c with z, but a is promised"]);
    }
}
