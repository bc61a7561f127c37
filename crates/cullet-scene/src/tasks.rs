//! Work that may be done side by side. Loading starts no threads; who calls it may.

use std::fmt;

use crate::Image;

/// An independent piece of work that borrows for `'t`.
pub struct Task<'t> {
    /// What it is about, for statistics.
    pub kind: TaskKind,
    work: Box<dyn FnOnce(Finish<'_>) + Send + 't>,
}

/// What is done to an image once it is decoded.
pub type Finish<'f> = &'f dyn Fn(&mut Image);

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
        Task { kind, work: Box::new(|_| work()) }
    }

    /// A task that decodes an image, and has it finished before it goes anywhere.
    pub(crate) fn image(work: impl FnOnce(Finish<'_>) + Send + 't) -> Task<'t> {
        Task { kind: TaskKind::Image, work: Box::new(work) }
    }

    /// Does it.
    pub fn run(self) {
        self.run_with(&|_| ());
    }

    /// Does it; an image that could be decoded is given to `finish` at once, so that what is to be made of it need
    /// not wait for the rest of the scene. `finish` may move its pixels into [`Image::derived`]; it has no name yet.
    pub fn run_with(self, finish: Finish<'_>) {
        (self.work)(finish);
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
