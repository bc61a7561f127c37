//! What is there? Scene data, glTF and OBJ loading, synthetic scenes.
//!
//! The only Cullet crate that reads files. Loading may fail with a named error;
//! nothing after it can.

mod data;
mod derived;
mod error;
mod files;
mod gltf;
mod images;
mod load;
mod obj;
mod options;
pub mod synth;
mod tasks;
mod write;

pub use data::*;
pub use derived::Derived;
pub use error::{ErrorKind, LoadError};
pub use load::{load, load_glb_bytes, load_glb_bytes_with, load_with};
pub use options::{Images, LoadOptions};
pub use tasks::{Finish, Run, Task, TaskKind, in_turn};
pub use write::{WriteError, write_glb};
