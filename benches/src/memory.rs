//! How fast this machine reads memory, for figures that end there.

use std::hint::black_box;
use std::time::Instant;

/// More than caches hold.
const BYTES: usize = 192 << 20;

/// Memory to be read from end to end; reading it leaves nothing else in the caches.
pub struct Memory {
    words: Vec<u64>,
    /// The best so far.
    seconds: f64,
}

impl Default for Memory {
    fn default() -> Self {
        Memory { words: vec![1; BYTES / 8], seconds: f64::INFINITY }
    }
}

impl Memory {
    /// Reads all of it, on one core.
    pub fn read(&mut self) {
        let start = Instant::now();
        black_box(self.words.iter().fold(0, |sum: u64, word| sum.wrapping_add(*word)));
        self.seconds = self.seconds.min(start.elapsed().as_secs_f64());
    }

    /// Gigabytes per second, the best of all readings.
    pub fn gb_per_s(&self) -> f64 {
        1e-9 * BYTES as f64 / self.seconds
    }
}
