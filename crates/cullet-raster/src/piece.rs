//! Clipped and large triangles beside a tile: where they may show, and what of them lies there.

use crate::assembly::BITS;
use crate::depth::reversed_key;
use crate::depth8::{greatest, least};
use crate::fill::{TileDepth, TileTriangle};
use crate::fixed::Fixed;
use crate::samples::Samples;
use crate::setup::{ScreenTriangle, doubled_area};
use crate::tile::{BLOCK, TileBuffer, TileRect};

/// Where a screen triangle may show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PieceBox {
    /// Pixels of the picture that may have samples in it: the first and the one after the last.
    pub x: [i32; 2],
    pub y: [i32; 2],
    /// Key of its nearest corner.
    pub nearest: i32,
}

impl PieceBox {
    pub fn new(piece: &ScreenTriangle, samples: Samples) -> Self {
        let [a, b, c] = piece.corners;
        let reach = 16 * i64::from(samples.reach());
        let along = |corners| {
            let [first, end] = pixels::<BITS>(corners, reach);
            let (least, most) = (i64::from(i32::MIN), i64::from(i32::MAX));
            [first.clamp(least, most) as i32, end.clamp(least, most) as i32]
        };
        PieceBox {
            x: along([a.x, b.x, c.x]),
            y: along([a.y, b.y, c.y]),
            nearest: reversed_key(piece.nearest() as f32),
        }
    }
}

/// Pixels along an axis that may have samples between corners: the first and the one after the last.
#[inline(always)]
fn pixels<const BITS: u32>([a, b, c]: [i64; 3], reach: i64) -> [i64; 2] {
    let unit = 1i64 << BITS;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    [(low - unit / 2 - reach + unit - 1) >> BITS, ((high - unit / 2 + reach) >> BITS) + 1]
}

/// The plane of [`crate::cover`], from edges per pixel in subpixel units.
#[inline(always)]
pub(crate) fn depth_plane(
    [a, b, c]: [f64; 3],
    left: [i64; 3],
    down: [i64; 3],
    area: f64,
    corner: [i64; 2],
) -> TileDepth {
    let inverse_area = 1.0 / area;
    let unit = f64::from(1u32 << BITS);
    let [ab, ac] = [b - a, c - a];
    let [dx1, dx2] = [(-left[1] << BITS) as f64, (-left[2] << BITS) as f64];
    let [dy1, dy2] = [(down[1] << BITS) as f64, (down[2] << BITS) as f64];
    TileDepth {
        depth: a,
        origin: [corner[0] as f64 / unit - 0.5, corner[1] as f64 / unit - 0.5],
        ddx: (ab * dx1 + ac * dx2) * inverse_area,
        ddy: (ab * dy1 + ac * dy2) * inverse_area,
        low: least(least(a, b), c),
        high: greatest(greatest(a, b), c),
    }
}

/// The pixels of a tile, along one axis, whose samples may lie between corners.
#[inline(always)]
pub(crate) fn pixels_in_tile<const BITS: u32>(
    corners: [i64; 3],
    origin: i32,
    reach: i64,
    side: i64,
) -> [i64; 2] {
    let [first, end] = pixels::<BITS>(corners, reach);
    let origin = i64::from(origin);
    [(first - origin).max(0), (end - origin).min(side)]
}

/// A screen triangle beside a tile.
pub(crate) enum Place {
    Outside,
    Inside(TileTriangle),
    /// Its edges do not fit 32 bits.
    TooLarge(TileRect),
}

/// What of a screen triangle may lie in `tile`. Edges that all samples there are inside of have
/// nothing to say any more; of the others, what is left fits 32 bits but for triangles of more than
/// 57 000 px.
pub(crate) fn in_tile(tile: &TileBuffer, triangle: &ScreenTriangle) -> Place {
    let unit = 1i64 << BITS;
    let reach = 16 * i64::from(tile.samples().reach());
    let side = tile.side() as i64;
    let [a, b, c] = triangle.corners;
    let [left_px, top_px] = tile.origin();
    let x = pixels_in_tile::<BITS>([a.x, b.x, c.x], left_px, reach, side);
    let y = pixels_in_tile::<BITS>([a.y, b.y, c.y], top_px, reach, side);
    if x[0] >= x[1] || y[0] >= y[1] {
        return Place::Outside;
    }
    // Whole blocks are drawn across, so all of them must be inside an edge that is dropped.
    let block = BLOCK as i64;
    let x = [x[0] / block * block, (x[1] + block - 1) / block * block];
    let mut out = TileTriangle {
        id: triangle.id,
        rect: TileRect { x: [x[0] as usize, x[1] as usize], y: [y[0] as usize, y[1] as usize] },
        value: [0; 3],
        rest: [0; 3],
        left: [0; 3],
        down: [0; 3],
        depth: TileDepth { depth: 0.0, origin: [0.0; 2], ddx: 0.0, ddy: 0.0, low: 0.0, high: 0.0 },
    };
    let (px, py) = (
        (x[0] + i64::from(left_px)) * unit + unit / 2,
        (y[0] + i64::from(top_px)) * unit + unit / 2,
    );
    let (mut left, mut down) = ([0; 3], [0; 3]);
    for edge in 0..3 {
        let (from, to) = (triangle.corners[(edge + 1) % 3], triangle.corners[(edge + 2) % 3]);
        let (run, drop) = (to.x - from.x, to.y - from.y);
        (left[edge], down[edge]) = (drop, run);
        let least = i64::from(!(drop < 0 || (drop == 0 && run > 0)));
        let value = run * (py - from.y) - drop * (px - from.x) - least;
        // Between the first sample and the last one of the rectangle.
        let (columns, rows) = ((x[1] - x[0] - 1) * unit, (y[1] - y[0] - 1) * unit);
        let (way_x, way_y) = (-drop * columns, run * rows);
        let spread = (drop.abs() + run.abs()) * reach;
        if value + spread + way_x.max(0) + way_y.max(0) < 0 {
            return Place::Outside;
        }
        if value - spread + way_x.min(0) + way_y.min(0) >= 0 {
            continue;
        }
        // Lanes of a group may lie a group's width beside the rectangle.
        if (run.abs() + drop.abs()) * (side + 2 * 8) >= 1 << 31 {
            return Place::TooLarge(out.rect);
        }
        out.value[edge] = (value >> BITS) as i32;
        out.rest[edge] = (value & (unit - 1)) as i32;
        out.left[edge] = drop as i32;
        out.down[edge] = run as i32;
    }
    let area = doubled_area(triangle.corners) as f64;
    let Fixed { x, y } = triangle.corners[0];
    out.depth = depth_plane(triangle.depth, left, down, area, [x, y]);
    Place::Inside(out)
}
