//! The viewer without a window: a script moves the hand.

use std::fs;
use std::path::Path;

use cullet_view::script::{Step, parse};
use cullet_view::{App, Request, picture_file};

use crate::{Failure, INPUT, OUTPUT, note, print, screenshot};

/// Reads a script.
pub fn read(path: &Path) -> Result<Vec<Step>, Failure> {
    let wrong = |what: String| Failure::new(INPUT, format!("{}: {what}", path.display()));
    let text = fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
    parse(&text).map_err(wrong)
}

/// Does what `steps` say, until they end.
pub fn run(mut app: App, steps: &[Step]) -> Result<(), Failure> {
    for step in steps {
        match step {
            Step::Quit => break,
            Step::Screenshot(path) => save(&mut app, path)?,
            Step::Input(input) => match app.input(*input) {
                None => {}
                Some(Request::Quit) => break,
                Some(Request::PrintCamera(file)) => print(&file),
                Some(Request::Screenshot) => {
                    note(screenshot(&mut app).map_err(|error| Failure::new(OUTPUT, error))?);
                }
            },
        }
    }
    Ok(())
}

fn save(app: &mut App, path: &Path) -> Result<(), Failure> {
    app.draw(false);
    let (width, height) = app.size();
    let saved =
        picture_file::png(app.pixels(), width, height).and_then(|file| fs::write(path, file));
    saved.map_err(|error| Failure::new(OUTPUT, format!("{}: {error}", path.display())))
}
