//! Work that may be done side by side. Loading starts no threads; who calls it may.

/// An independent piece of work that borrows for `'t`.
pub type Task<'t> = Box<dyn FnOnce() + Send + 't>;

/// Does every task once, in any order and on any threads, and returns when all are done.
///
/// Tasks touch disjoint data, so order and number of threads cannot show in what is loaded.
pub type Run<'r> = &'r (dyn for<'t> Fn(Vec<Task<'t>>) + Sync);

/// A [`Run`] without threads: one task after the other.
pub fn in_turn(tasks: Vec<Task<'_>>) {
    tasks.into_iter().for_each(|task| task());
}
