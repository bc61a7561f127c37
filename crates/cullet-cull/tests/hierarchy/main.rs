//! The wide tests and the tree, against flat and scalar twins.

mod edit;
mod queries;
mod walk;
mod wide;
mod worlds;
