//! The viewer without its window: a camera to turn, lines and text over a picture, and a state
//! machine that ties them together, all of it testable.
//!
//! ```
//! use cullet::{Prepared, Viewport, scene::synth::synth};
//! use cullet_view::{App, Input, Key};
//!
//! let prepared = Prepared::new(synth("box-grid:3")?)?;
//! let mut app = App::new(prepared, None, Viewport::new(160, 90)?);
//! app.input(Input::Key(Key::Space)); // freeze the frustum
//! app.input(Input::Turn { right: 40.0, down: 20.0 }); // and look at it from outside
//! app.draw(false);
//! assert_eq!(app.pixels().len(), 160 * 90);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod app;
mod camera_file;
mod orbit;

pub mod hud;
pub mod marks;
pub mod overlay;
pub mod picture_file;
pub mod script;

pub use app::{App, HELP, Input, Key, Request};
pub use camera_file::camera_file;
pub use orbit::Orbit;
