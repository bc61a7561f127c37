//! A replay: what a hand would do, one thing per line.
//!
//! ```text
//! size 640 360         the picture's sides, px
//! key space            b c f h p r space home escape 0 .. 5
//! drag 100 -20         left drag, px to the right and down
//! pan 0 30             right drag
//! wheel -3             steps, towards the scene
//! screenshot out.png   save the picture
//! quit
//! ```
//!
//! Empty lines and what follows a `#` are passed over.

use std::path::PathBuf;

use crate::app::{Input, Key};

/// One line of a script.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Something a hand could do.
    Input(Input),
    /// Save the picture under this name.
    Screenshot(PathBuf),
    /// Stop here.
    Quit,
}

/// The steps of a script, or what is wrong with which line.
pub fn parse(text: &str) -> Result<Vec<Step>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let lines = lines.enumerate().filter(|(_, line)| !line.is_empty());
    let steps = lines.map(|(i, line)| {
        step(line).ok_or_else(|| format!("line {}: `{line}` is no step of a script", i + 1))
    });
    steps.collect()
}

fn step(line: &str) -> Option<Step> {
    let (verb, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let words: Vec<&str> = rest.split_whitespace().collect();
    let number = |word: &str| word.parse().ok().filter(|n: &f64| n.is_finite());
    let step = match (verb, words.as_slice()) {
        ("size", [width, height]) => Input::Resize(width.parse().ok()?, height.parse().ok()?),
        ("key", [name]) => Input::Key(key(name)?),
        ("drag", [right, down]) => Input::Turn { right: number(right)?, down: number(down)? },
        ("pan", [right, down]) => Input::Pan { right: number(right)?, down: number(down)? },
        ("wheel", [steps]) => Input::Zoom(number(steps)?),
        ("screenshot", [_, ..]) => return Some(Step::Screenshot(rest.trim().into())),
        ("quit", []) => return Some(Step::Quit),
        _ => return None,
    };
    Some(Step::Input(step))
}

fn key(name: &str) -> Option<Key> {
    let key = match name.to_ascii_lowercase().as_str() {
        "b" => Key::B,
        "c" => Key::C,
        "f" | "home" => Key::F,
        "h" => Key::H,
        "p" => Key::P,
        "r" => Key::R,
        "space" => Key::Space,
        "escape" => Key::Escape,
        digit => Key::Digit(digit.parse().ok().filter(|&digit| digit <= 5)?),
    };
    Some(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_understood() {
        let text = "size 64 48\n\n# look\nkey Space # freeze\ndrag 100 -20.5\npan 0 3\nwheel -3\n\
            key 5\nscreenshot my picture.png\nquit\n";
        let expected = [
            Step::Input(Input::Resize(64, 48)),
            Step::Input(Input::Key(Key::Space)),
            Step::Input(Input::Turn { right: 100.0, down: -20.5 }),
            Step::Input(Input::Pan { right: 0.0, down: 3.0 }),
            Step::Input(Input::Zoom(-3.0)),
            Step::Input(Input::Key(Key::Digit(5))),
            Step::Screenshot("my picture.png".into()),
            Step::Quit,
        ];
        assert_eq!(parse(text).unwrap(), expected);
        assert_eq!(parse("").unwrap(), []);
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        for line in
            ["jump", "key", "key 6", "key space b", "drag 1", "drag 1 nan", "size -1 2", "quit now"]
        {
            let error = parse(&format!("quit\n{line}")).unwrap_err();
            assert!(error.starts_with("line 2: "), "{error}");
        }
    }
}
