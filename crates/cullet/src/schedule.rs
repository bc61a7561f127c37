//! The only place where threads start.
//!
//! Work is a list of jobs that touch disjoint data; which thread takes which job, and in what
//! order, can therefore not show in the result.

use std::sync::{Mutex, PoisonError};
use std::thread;

/// The number of threads that `setting` means: 0 is one per core.
pub(crate) fn thread_count(setting: usize) -> usize {
    match setting {
        0 => thread::available_parallelism().map_or(1, |n| n.get()),
        n => n,
    }
}

/// Calls `work` on every job, on `threads` threads, this one included. Returns when all are done.
pub(crate) fn for_each<T, I>(threads: usize, jobs: I, work: impl Fn(T) + Sync)
where
    I: ExactSizeIterator<Item = T> + Send,
{
    let threads = threads.min(jobs.len());
    if threads <= 1 {
        return jobs.for_each(work);
    }
    let jobs = Mutex::new(jobs);
    let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
    let drain = || {
        while let Some(job) = next() {
            work(job);
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            // Where the system gives no more threads, those there are do the work.
            if thread::Builder::new().spawn_scoped(scope, drain).is_err() {
                break;
            }
        }
        drain();
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_is_done_once_on_any_number_of_threads() {
        for threads in [1, 2, 7, 100] {
            let mut jobs = [0; 50];
            for_each(threads, jobs.iter_mut(), |job| *job += 1);
            assert!(jobs.iter().all(|&n| n == 1), "{threads}");
        }
        for_each(4, std::iter::empty::<u8>(), |_| unreachable!());
        assert!(thread_count(0) >= 1);
        assert_eq!(thread_count(3), 3);
    }
}
