//! Work that may be done side by side. Loading starts no threads; who calls it may.

use std::fmt;

/// An independent piece of work that borrows for `'t`.
pub struct Task<'t> {
    /// What it is about, for statistics.
    pub kind: TaskKind,
    work: Box<dyn FnOnce() + Send + 't>,
}

/// What a [`Task`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskKind {
    /// Vertices and triangles.
    Geometry,
    /// The pixels of one image.
    Image,
}

impl<'t> Task<'t> {
    /// A task that does `work`.
    pub(crate) fn new(kind: TaskKind, work: impl FnOnce() + Send + 't) -> Task<'t> {
        Task { kind, work: Box::new(work) }
    }

    /// Does it.
    pub fn run(self) {
        (self.work)();
    }
}

impl fmt::Debug for Task<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Task").field("kind", &self.kind).finish_non_exhaustive()
    }
}

/// Does every task once, in any order and on any threads, and returns when all are done.
///
/// Tasks touch disjoint data, so order and number of threads cannot show in what is loaded.
pub type Run<'r> = &'r (dyn for<'t> Fn(Vec<Task<'t>>) + Sync);

/// A [`Run`] without threads: one task after the other.
pub fn in_turn(tasks: Vec<Task<'_>>) {
    tasks.into_iter().for_each(Task::run);
}
