//! A cluster assembled and drawn triangle by triangle and sample by sample: what other than the usual
//! [`Precision`](crate::Precision) takes, and machines without wide registers.
//!
//! [`crate::set_up`] decides what is drawn, 64-bit integers what it covers.

use glam::Vec3;

use crate::assembly::{Assembly, Cluster, Object};
use crate::cover::{DepthPlane, Edges};
use crate::depth::{DepthFormat, ReversedF32, StandardF32, StandardU16, StandardU24};
use crate::fill::KeepSample;
use crate::piece::pixels_in_tile;
use crate::precision::{DepthKind, SubpixelBits};
use crate::setup::{Placer, ScreenTriangle, SetupCounters, Triangles, Vertex, set_up};
use crate::tile::{TileBuffer, TileRect};

/// Appends the screen triangles of `cluster` to `out`, and the ids of those that were clipped to `clipped`;
/// `vertices` is scratch.
pub(crate) fn assemble(
    cluster: &Cluster<'_>,
    object: &Object,
    vertices: &mut Vec<Vertex>,
    out: &mut Vec<ScreenTriangle>,
    clipped: &mut Vec<u32>,
) -> SetupCounters {
    match object.precision.subpixel_bits {
        SubpixelBits::Four => assemble_on::<4>(cluster, object, vertices, out, clipped),
        SubpixelBits::Eight => assemble_on::<8>(cluster, object, vertices, out, clipped),
        SubpixelBits::Twelve => assemble_on::<12>(cluster, object, vertices, out, clipped),
        SubpixelBits::Sixteen => assemble_on::<16>(cluster, object, vertices, out, clipped),
    }
}

fn assemble_on<const BITS: u32>(
    cluster: &Cluster<'_>,
    object: &Object,
    vertices: &mut Vec<Vertex>,
    out: &mut Vec<ScreenTriangle>,
    clipped: &mut Vec<u32>,
) -> SetupCounters {
    let transforms = object.precision.transforms;
    let placer = Placer::<BITS>::with(transforms, object.viewport, object.planes);
    let [x, y, z] = cluster.positions;
    vertices.clear();
    vertices.extend((0..x.len()).map(|i| {
        placer.place(transforms.clip(&object.clip_from_model, Vec3::new(x[i], y[i], z[i])))
    }));
    let mut counters = SetupCounters::default();
    for (corners, id) in cluster.corners.iter().zip(cluster.ids) {
        let [a, b, c, _] = corners.map(u32::from);
        let input = Triangles {
            vertices,
            triangles: &[[a, b, c]],
            first_vertex: 0,
            first_id: object.first_id + id,
            facing: object.facing,
        };
        let own = set_up(&placer, &input, out);
        if own.n_clipped > 0 {
            clipped.push(input.first_id);
        }
        counters += own;
    }
    counters
}

/// Draws the screen triangles of `assembly`, as [`crate::draw()`] does.
pub(crate) fn draw(
    tile: &mut TileBuffer,
    assembly: &Assembly,
    keep: Option<&mut KeepSample<'_>>,
) -> u64 {
    match assembly.precision.subpixel_bits {
        SubpixelBits::Four => draw_on::<4>(tile, assembly, keep),
        SubpixelBits::Eight => draw_on::<8>(tile, assembly, keep),
        SubpixelBits::Twelve => draw_on::<12>(tile, assembly, keep),
        SubpixelBits::Sixteen => draw_on::<16>(tile, assembly, keep),
    }
}

fn draw_on<const BITS: u32>(
    tile: &mut TileBuffer,
    assembly: &Assembly,
    keep: Option<&mut KeepSample<'_>>,
) -> u64 {
    match assembly.precision.depth {
        DepthKind::ReversedF32 => draw_all::<ReversedF32, BITS>(tile, assembly, keep),
        DepthKind::StandardF32 => draw_all::<StandardF32, BITS>(tile, assembly, keep),
        DepthKind::StandardU24 => draw_all::<StandardU24, BITS>(tile, assembly, keep),
        DepthKind::StandardU16 => draw_all::<StandardU16, BITS>(tile, assembly, keep),
    }
}

fn draw_all<D: DepthFormat, const BITS: u32>(
    tile: &mut TileBuffer,
    assembly: &Assembly,
    mut keep: Option<&mut KeepSample<'_>>,
) -> u64 {
    let mut n_won = 0;
    for triangle in &assembly.pieces {
        if let Some(rect) = rect_of::<BITS>(tile, triangle) {
            let won = fill_plain::<D, BITS>(tile, triangle, rect, keep.as_deref_mut());
            n_won += u64::from(won);
        }
    }
    n_won
}

/// The pixels of a tile whose samples may lie in a triangle, if there are any.
fn rect_of<const BITS: u32>(tile: &TileBuffer, triangle: &ScreenTriangle) -> Option<TileRect> {
    let reach = (i64::from(tile.samples().reach()) << BITS) / 16;
    let [left, top] = tile.origin();
    let side = tile.side() as i64;
    let [a, b, c] = triangle.corners;
    let x = pixels_in_tile::<BITS>([a.x, b.x, c.x], left, reach, side);
    let y = pixels_in_tile::<BITS>([a.y, b.y, c.y], top, reach, side);
    let holds = x[0] < x[1] && y[0] < y[1];
    holds.then(|| TileRect { x: x.map(|at| at as usize), y: y.map(|at| at as usize) })
}

/// Draws a screen triangle sample by sample, in 64-bit integers: for triangles that do not fit the
/// wide code, and for every other grid of positions and format of depth.
pub(crate) fn fill_plain<D: DepthFormat, const BITS: u32>(
    tile: &mut TileBuffer,
    triangle: &ScreenTriangle,
    rect: TileRect,
    mut keep: Option<&mut KeepSample<'_>>,
) -> u32 {
    tile.touch(rect, i32::MAX);
    let (stride, n_samples) = (tile.stride_px(), tile.samples().count());
    let [left, top] = tile.origin().map(i64::from);
    let mut written = 0;
    let centre = Edges::new::<BITS>(triangle, [0, 0]);
    let depth = DepthPlane::new::<BITS>(triangle, &centre);
    for (sample, offset) in tile.samples().offsets().iter().enumerate() {
        // Sixteenths are whole units from four subpixel bits on.
        let units = offset.map(|sixteenths| (i64::from(sixteenths) << BITS) / 16);
        let edges = Edges::new::<BITS>(triangle, units);
        let [x_shift, y_shift] = offset.map(|sixteenths| f64::from(sixteenths) / 16.0);
        for row in rect.y[0]..rect.y[1] {
            let y = top + row as i64;
            let columns = rect.x.map(|column| left + column as i64);
            let (first, last) = edges.row::<BITS>(y).covered(columns[0], columns[1]);
            let in_row = depth.row(y as f64 + y_shift);
            for x in first..last {
                let at = (row * stride + (x - left) as usize) * n_samples + sample;
                let (key_at, id_at) = (tile.starts[0] + at, tile.starts[1] + at);
                let key = D::key(D::encode(depth.at(in_row, x as f64 + x_shift)));
                let old = (tile.keys[key_at], tile.ids[id_at]);
                let wins = key > old.0 || (key == old.0 && triangle.id < old.1);
                let place = [16 * x as i32 + 8 + offset[0], 16 * y as i32 + 8 + offset[1]];
                if wins
                    && keep.as_deref_mut().is_none_or(|keep| keep(triangle.id, place, 1) & 1 == 1)
                {
                    (tile.keys[key_at], tile.ids[id_at]) = (key, triangle.id);
                    written += 1;
                }
            }
        }
    }
    written
}
