//! Asking memory for what will be read soon.
//!
//! A load that misses the caches holds up all that comes after it; a hint does not. Where places to read are known
//! well ahead, as those of texels are, sending for them first is worth up to a seventh of a frame.

use std::ops::Range;

/// Asks for the line of memory with the element at `index`, if there is one: a hint, which changes nothing but
/// time, and nothing at all on machines that have no such instruction.
#[inline(always)]
pub fn prefetch<T>(slice: &[T], index: usize) {
    #[cfg(all(target_arch = "x86_64", target_feature = "sse"))]
    if let Some(element) = slice.get(index) {
        safe_arch::prefetch_t0(element);
    }
    #[cfg(not(all(target_arch = "x86_64", target_feature = "sse")))]
    let _ = (slice, index);
}

/// [`prefetch`] every 64 bytes, which is a line on most machines, along a part of `slice`. What of the part lies beyond
/// it is passed over.
#[inline(always)]
pub fn prefetch_all<T>(slice: &[T], part: Range<usize>) {
    for index in part.step_by((64 / size_of::<T>().max(1)).max(1)) {
        prefetch(slice, index);
    }
}
