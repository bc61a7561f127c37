//! Separable convolution with replicated borders: one kernel along rows, one along columns.

/// One f64 per pixel, row-major, `width * height` of them, neither side 0.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<f64>,
}

impl Plane {
    /// A plane of the same size, each value made from the two at its place.
    pub(crate) fn zip(&self, other: &Plane, f: impl Fn(f64, f64) -> f64) -> Plane {
        let values = self.values.iter().zip(&other.values).map(|(&a, &b)| f(a, b)).collect();
        Plane { values, ..*self }
    }

    /// The plane filtered by `kernel_x` along rows and `kernel_y` along columns.
    ///
    /// Kernels have odd lengths, their middle on the pixel; they are laid on unmirrored
    /// (correlation), so a kernel that rises to the right answers positively to values
    /// that do. Beyond the border the border pixel repeats.
    pub(crate) fn filtered(&self, kernel_x: &[f64], kernel_y: &[f64]) -> Plane {
        debug_assert!(kernel_x.len() % 2 == 1 && kernel_y.len() % 2 == 1, "no middle tap");
        self.filtered_along_rows(kernel_x).filtered_along_columns(kernel_y)
    }

    fn filtered_along_rows(&self, kernel: &[f64]) -> Plane {
        let radius = kernel.len() / 2;
        let mut values = vec![0.0; self.values.len()];
        let mut padded = Vec::with_capacity(self.width + 2 * radius);
        for (y, row) in self.values.chunks_exact(self.width).enumerate() {
            padded.clear();
            padded.resize(radius, row[0]);
            padded.extend_from_slice(row);
            padded.resize(self.width + 2 * radius, row[self.width - 1]);
            // Tap by tap over the whole row: eight pixels at a time, which one by one cannot be.
            let sums = &mut values[y * self.width..][..self.width];
            for (i, tap) in kernel.iter().enumerate() {
                sums.iter_mut().zip(&padded[i..]).for_each(|(sum, value)| *sum += value * tap);
            }
        }
        Plane { values, ..*self }
    }

    fn filtered_along_columns(&self, kernel: &[f64]) -> Plane {
        let radius = kernel.len() / 2;
        let mut values = vec![0.0; self.values.len()];
        for (y, sums) in values.chunks_exact_mut(self.width).enumerate() {
            for (i, tap) in kernel.iter().enumerate() {
                let from = (y + i).saturating_sub(radius).min(self.height - 1);
                let row = &self.values[from * self.width..][..self.width];
                sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value * tap);
            }
        }
        Plane { values, ..*self }
    }
}

/// A Gaussian of standard deviation `sigma` (pixels, > 0) with `2 * radius + 1` taps of
/// sum 1.
pub(crate) fn gaussian(sigma: f64, radius: usize) -> Vec<f64> {
    let taps: Vec<f64> =
        offsets(radius).map(|x| libm::exp(-x * x / (2.0 * sigma * sigma))).collect();
    let sum: f64 = taps.iter().sum();
    taps.into_iter().map(|tap| tap / sum).collect()
}

/// Pixel distances from the middle tap: `-radius ..= radius`.
pub(crate) fn offsets(radius: usize) -> impl Iterator<Item = f64> {
    (0..=2 * radius).map(move |i| i as f64 - radius as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_repeat_and_kernels_are_not_mirrored() {
        let plane = Plane { width: 3, height: 2, values: vec![1.0, 2.0, 4.0, 8.0, 16.0, 32.0] };
        let rise_x = plane.filtered(&[-1.0, 0.0, 1.0], &[1.0]);
        assert_eq!(rise_x.values, [1.0, 3.0, 2.0, 8.0, 24.0, 16.0]);
        let rise_y = plane.filtered(&[1.0], &[-1.0, 0.0, 1.0]);
        assert_eq!(rise_y.values, [7.0, 14.0, 28.0, 7.0, 14.0, 28.0]);
    }

    #[test]
    fn a_kernel_may_be_wider_than_the_plane() {
        let plane = Plane { width: 1, height: 1, values: vec![3.0] };
        let blurred = plane.filtered(&gaussian(2.0, 6), &gaussian(2.0, 6));
        assert!((blurred.values[0] - 3.0).abs() < 1e-14);
    }
}
