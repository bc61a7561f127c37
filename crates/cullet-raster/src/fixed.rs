//! Fixed point: where a vertex really is, once and for all.
//!
//! Everything after the snap is integer arithmetic on multiples of `1 / 2^BITS` px, so two
//! triangles that share an edge agree about it to the last bit. Widths: with 24.8 and a guard
//! band of 2^14 px beyond a side of at most 2^15 px, a difference of two coordinates needs 24
//! bits, an edge value 50; i64 holds them with room for 12 bits of subpixel position. Beyond
//! that the guard band shrinks.

use cullet_transform::{ClipPoint, MAX_SIDE, Viewport};

/// How far beyond each side of the viewport triangles are not clipped, px.
pub const GUARD_BAND: u32 = 1 << 14;

/// A snapped screen position in units of `1 / 2^BITS` px, y down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fixed {
    /// To the right of the left border.
    pub x: i64,
    /// Below the upper border.
    pub y: i64,
}

/// The guard band beyond a viewport side of `side` px, in px: the largest, up to
/// [`GUARD_BAND`], for which two products of coordinate differences still fit an i64.
pub const fn guard_band(side: u32, subpixel_bits: u32) -> u32 {
    debug_assert!(side <= MAX_SIDE && subpixel_bits >= 1 && subpixel_bits <= 16);
    // Each of two products below 2^62: differences of at most 2^31 units.
    let span = 1u64 << (31 - subpixel_bits);
    let room = span.saturating_sub(side as u64) / 2;
    if room < GUARD_BAND as u64 { room as u32 } else { GUARD_BAND }
}

/// Snaps a clip-space point with `w > 0` to the grid, rounding half to even. A position beyond
/// the guard band (only possible by rounding, after clipping) is moved to its border.
pub fn snap<const BITS: u32>(viewport: Viewport, point: &ClipPoint) -> Fixed {
    let screen = viewport.screen_from_ndc(point.ndc());
    Fixed {
        x: snap_coordinate::<BITS>(screen.x, viewport.width()),
        y: snap_coordinate::<BITS>(screen.y, viewport.height()),
    }
}

fn snap_coordinate<const BITS: u32>(px: f64, side: u32) -> i64 {
    let guard = f64::from(guard_band(side, BITS));
    let (low, high) = (-guard, f64::from(side) + guard);
    // Compare and select: NaN (never seen here) would land on the low border.
    let inside = if px > low { px } else { low };
    let inside = if inside < high { inside } else { high };
    let units = inside * f64::from(1u32 << BITS); // a power of two: exact
    round_half_even(units)
}

/// The integer nearest to `x`, ties to even, for |x| < 2^51: a sum with 1.5 * 2^52 has no bits left
/// for a fraction, and its last bits are the integer (Hacker's Delight, 2012, section 17.1). Targets
/// without a rounding instruction would call a function for it.
fn round_half_even(x: f64) -> i64 {
    (x + SNAP_SHIFT).to_bits().wrapping_sub(SNAP_SHIFT.to_bits()) as i64
}

/// 1.5 * 2^52, whose last 32 bits are 0.
pub(crate) const SNAP_SHIFT: f64 = 6_755_399_441_055_744.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check<const BITS: u32>(px: f64, expected: i64) {
        assert_eq!(snap_coordinate::<BITS>(px, 640), expected, "{px} px");
    }

    #[test]
    fn halves_round_to_even() {
        check::<8>(0.5 / 256.0, 0);
        check::<8>(1.5 / 256.0, 2);
        check::<8>(2.5 / 256.0, 2);
        check::<8>(-0.5 / 256.0, 0);
        check::<8>(-1.5 / 256.0, -2);
        check::<8>(1.25, 320);
        check::<4>(1.0 / 32.0, 0);
        check::<16>(1.0, 65536);
    }

    #[test]
    fn nothing_leaves_the_guard_band() {
        check::<8>(1e300, (640 + 16384) * 256);
        check::<8>(f64::NEG_INFINITY, -16384 * 256);
    }

    #[test]
    fn edge_values_fit_i64_at_every_depth_of_subpixels() {
        for bits in 1..=16 {
            for side in [1, 640, 8192, MAX_SIDE] {
                let span = u128::from(side) + 2 * u128::from(guard_band(side, bits));
                let units = span << bits;
                assert!(2 * units * units <= 1 << 63, "{bits} bits, {side} px");
            }
        }
        assert_eq!(guard_band(MAX_SIDE, 12), GUARD_BAND);
        assert_eq!(guard_band(16384, 16), 8192);
    }

    #[test]
    fn rounding_is_that_of_the_instruction() {
        let halves = (-9..9).map(|i| f64::from(i) + 0.5);
        let large = [1e12 + 0.5, -1e12 - 1.5, 2f64.powi(50) + 0.5, 1.0 - 2f64.powi(51), 0.1, -0.0];
        for x in halves.chain(large).flat_map(|x| [x.next_down(), x, x.next_up()]) {
            assert_eq!(round_half_even(x), x.round_ties_even() as i64, "{x}");
        }
    }
}
