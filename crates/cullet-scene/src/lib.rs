//! What is there? Scene data, glTF and OBJ loading, synthetic scenes.
//!
//! The only Cullet crate that reads files. Loading may fail with a named error;
//! nothing after it can.

mod data;

pub use data::*;
