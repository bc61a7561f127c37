//! The viewer without its window.
