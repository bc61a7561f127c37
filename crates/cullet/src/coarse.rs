//! One colour for two by two pixels.
//!
//! Squares are counted from the corner of the whole picture. Each triangle seen in a square is
//! shaded once, in its middle, and every pixel that shows it there gets that colour (as with the
//! coarse pixels of Direct3D's variable-rate shading; only that textures keep the level of detail
//! of single pixels). Which triangle a pixel shows is not touched.

use cullet_raster::NO_TRIANGLE;
use cullet_shade::wide::Out;
use glam::Vec4;

use crate::Region;
use crate::frame::Target;
use crate::tile_shader::{TileShader, part_in};

/// Memory for a block.
#[derive(Debug, Default)]
pub(crate) struct CoarseScratch {
    /// Where a pixel goes, and the number of its colour.
    places: Vec<(u32, u32)>,
    linear: Vec<Vec4>,
    bytes: Vec<[u8; 4]>,
}

impl CoarseScratch {
    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        8 * self.places.capacity() + 16 * self.linear.capacity() + 4 * self.bytes.capacity()
    }
}

impl TileShader<'_> {
    /// Colours the part of `rect` that lies in a block, from ids as [`TileShader::blocks`] gets them.
    pub(crate) fn coarse_block(
        &mut self,
        rect: Region,
        block: [u32; 2],
        ids: &[u32],
        stride: usize,
        out: &mut Target<'_>,
    ) -> u64 {
        let mut scratch = std::mem::take(&mut self.scratch.coarse);
        let CoarseScratch { places, linear, bytes } = &mut scratch;
        places.clear();
        let [left, top, right, bottom] = part_in(rect, block);
        let (columns, rows) = (left..right, top..bottom);
        let batch = &mut self.scratch.batch;
        batch.begin();
        let mut n_colors = 0;
        for y in (rows.start & !1..rows.end).step_by(2) {
            for x in (columns.start & !1..columns.end).step_by(2) {
                // The triangles of this square, from this number on.
                let first = n_colors;
                let mut seen = [NO_TRIANGLE; 4];
                for [x, y] in [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]] {
                    if !(columns.contains(&x) && rows.contains(&y)) {
                        continue;
                    }
                    let (row, column) = ((y - rect.y) as usize, (x - rect.x) as usize);
                    let id = ids[row * stride + column];
                    if id == NO_TRIANGLE {
                        continue;
                    }
                    let n_seen = (n_colors - first) as usize;
                    let known = seen[..n_seen].iter().position(|seen| *seen == id);
                    places.push((
                        (row * out.stride + column) as u32,
                        first + known.unwrap_or(n_seen) as u32,
                    ));
                    if known.is_none() {
                        seen[n_seen] = id;
                        let middle = [x, y].map(|at| 16 * (at & !1) + 16);
                        let place = [middle[0] - 16 * block[0], middle[1] - 16 * block[1]];
                        batch.push(id, 1, n_colors, place);
                        n_colors += 1;
                    }
                }
            }
        }
        let n_pixels = batch.n_pixels();
        if out.linear.is_empty() {
            bytes.resize(n_pixels, [0; 4]);
            self.paint(block, &mut Out::Bytes(bytes));
            for (place, color) in &*places {
                out.rgba8[*place as usize] = bytes[*color as usize];
            }
        } else {
            linear.resize(n_pixels, Vec4::ZERO);
            self.paint(block, &mut Out::Linear(linear));
            for (place, color) in &*places {
                out.linear[*place as usize] = linear[*color as usize];
            }
        }
        let n_pixels = places.len() as u64;
        self.scratch.coarse = scratch;
        n_pixels
    }
}
