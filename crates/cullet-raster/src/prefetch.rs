//! Asking memory for what will be read soon.
//!
//! A load that misses the caches holds up all that comes after it; a hint does not. Where places to read are known
//! well ahead, as those of texels are, sending for them first is worth a tenth of a frame.

use std::ops::Range;

/// Asks for the line of memory with the element at `index`, if there is one: a hint, which changes nothing but
/// time, and nothing at all on machines that have no such instruction.
#[inline(always)]
pub fn prefetch<T>(slice: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(element) = slice.get(index) {
        safe_arch::prefetch_t0(element);
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (slice, index);
}

/// [`prefetch`] for all lines of a part of `slice`, which may reach beyond it.
#[inline(always)]
pub fn prefetch_all<T>(slice: &[T], part: Range<usize>) {
    // Bytes of a line, on most machines.
    for index in part.step_by((64 / size_of::<T>()).max(1)) {
        prefetch(slice, index);
    }
}
