//! Do two pictures of numbers show the same things? A pixel with another number is wholly wrong,
//! however near the numbers are.

use crate::error::MeasureError;

/// Pixels whose number differs, out of a million.
///
/// # Errors
/// When there are no pixels, or not equally many.
pub fn ids_differ_ppm(reference: &[u32], candidate: &[u32]) -> Result<f64, MeasureError> {
    let n = reference.len();
    if n == 0 || n != candidate.len() {
        return Err(MeasureError::SizesDiffer {
            reference: (n, 1),
            candidate: (candidate.len(), 1),
        });
    }
    let differ = reference.iter().zip(candidate).filter(|(a, b)| a != b).count();
    Ok(differ as f64 / n as f64 * 1e6)
}

/// The error that a fraction `q` in [0, 1] of pixels does not exceed, relative to the reference,
/// over the pixels where both are finite and the reference is not 0; `None` without any.
pub fn relative_quantile(reference: &[f32], candidate: &[f32], q: f64) -> Option<f64> {
    let pairs = reference.iter().zip(candidate).map(|(r, c)| (f64::from(*r), f64::from(*c)));
    let errors = pairs
        .filter(|(r, c)| r.is_finite() && c.is_finite() && *r != 0.0)
        .map(|(r, c)| ((c - r) / r).abs());
    let sorted = crate::summary::sorted(&errors.collect::<Vec<f64>>());
    (!sorted.is_empty()).then(|| crate::summary::quantile_of_sorted(&sorted, q))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_numbers_differ_like_far_ones() {
        assert_eq!(ids_differ_ppm(&[1, 2, 3, 4], &[1, 3, 3, 400]), Ok(5e5));
        assert_eq!(ids_differ_ppm(&[7], &[7]), Ok(0.0));
        assert!(ids_differ_ppm(&[], &[]).is_err());
        assert!(ids_differ_ppm(&[1], &[1, 2]).is_err());
    }

    #[test]
    fn quantiles_pass_over_what_is_not_there() {
        let inf = f32::INFINITY;
        let (reference, candidate) = ([1.0, 2.0, 0.0, inf, 4.0], [1.0, 3.0, 9.0, 1.0, inf]);
        assert_eq!(relative_quantile(&reference, &candidate, 1.0), Some(0.5));
        assert_eq!(relative_quantile(&reference, &candidate, 0.0), Some(0.0));
        assert_eq!(relative_quantile(&[inf], &[1.0], 0.5), None);
    }
}
