//! The corners of a matrix that keeps them in doubt, found without rounding.
//!
//! Two kinds of matrix need it. In some a near distance is next to nothing beside the numbers of
//! the eye: the corners of the near plane are apart by less than rounding is. In others it is gone:
//! row z has become row w, or zero, by rounding, or because the sky is drawn with `z = w`, or a flat
//! picture with `z = 0`. Such a matrix has no inverse. It sends one point of projective space, its
//! apex, to zero, so that all six planes pass through the apex: near and far cut nothing off
//! that their own tests do not tell.
//!
//! ```text
//!     \       /        a point: the near corners are all in it,
//!      \     /         the far ones are directions
//!       \   /
//!         .
//!
//!       |   |          at infinity, with parallel sides: there are no corners,
//!       |   |          the volume has no end on either side
//! ```

use core::cmp::Ordering::{Equal, Greater, Less};

use crate::FrustumError;
use crate::implied::{self, Row};
use crate::number::{Expansion, Interval, Number};

/// All eight corners; `[0, 0, 0, -1]` where there is none.
pub(crate) fn corners(planes: &[Row<Expansion>; 6]) -> Result<[Row<Interval>; 8], FrustumError> {
    let [left, right, bottom, _, near, far] = planes;
    let apex = implied::meeting([left, right, bottom]);
    if apex.iter().all(is_zero) {
        return Err(FrustumError::Singular);
    }
    if [near, far].into_iter().any(|plane| !is_zero(&implied::at(plane, &apex))) {
        return with_a_point(each(|i| implied::corner(planes, i))?);
    }
    let point = match apex[3].sign() {
        Some(Greater) => apex,
        Some(Less) => apex.map(|n| n.negated()),
        _ => return without_corners(planes, apex),
    };
    let mut planes = planes.clone();
    planes[5] = [0.0, 0.0, 0.0, 1.0].map(|n| Expansion::from_sum([n]));
    each(|i| if i < 4 { Some(point.clone()) } else { implied::corner(&planes, i) })
}

/// Whether none of these is surely a point, and one may be.
pub(crate) fn is_in_doubt(corners: &[Row<Interval>; 8]) -> bool {
    let signs = corners.each_ref().map(|[.., w]| w.sign());
    !signs.contains(&Some(Greater)) && signs.contains(&None)
}

/// The same corners, unless none is a point: then the volume is empty.
pub(crate) fn with_a_point(
    corners: [Row<Interval>; 8],
) -> Result<[Row<Interval>; 8], FrustumError> {
    let is_point = |[.., w]: &Row<Interval>| w.sign() == Some(Greater);
    if corners.iter().any(is_point) { Ok(corners) } else { Err(FrustumError::Empty) }
}

/// For parallel sides, along `direction`.
fn without_corners(
    planes: &[Row<Expansion>; 6],
    direction: Row<Expansion>,
) -> Result<[Row<Interval>; 8], FrustumError> {
    // Where a plane across cuts the sides' edges: the volume has a point if one of these is one.
    let mut planes = planes.clone();
    planes[4] = direction;
    let is_point = |i| {
        let cut = implied::corner(&planes, i);
        cut.is_some_and(|cut| cut[3].sign() == Some(Greater))
    };
    if !(0..4).any(is_point) {
        return Err(FrustumError::Empty);
    }
    let [zero, one] = [0.0, -1.0].map(|value| Interval { value, error: 0.0 });
    Ok([[zero, zero, zero, one]; 8])
}

fn each(
    corner: impl Fn(usize) -> Option<Row<Expansion>>,
) -> Result<[Row<Interval>; 8], FrustumError> {
    let mut corners = [[Interval::zero(); 4]; 8];
    for (i, rounded) in corners.iter_mut().enumerate() {
        *rounded = self::rounded(&corner(i).ok_or(FrustumError::Singular)?);
    }
    Ok(corners)
}

/// Times a power of two, so that the largest is about 1.
fn rounded(corner: &Row<Expansion>) -> Row<Interval> {
    let values = corner.each_ref().map(Expansion::value);
    let largest = values.iter().fold(0.0, |most: f64, n| most.max(n.abs()));
    values.map(|n| {
        let value = libm::scalbn(n, -libm::ilogb(largest));
        Interval { value, error: 2.0 * f64::EPSILON * value.abs() }
    })
}

fn is_zero(n: &Expansion) -> bool {
    n.sign() == Some(Equal)
}
