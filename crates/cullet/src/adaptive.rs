//! Sixteen colours for 64 pixels, where that does not show.
//!
//! Visibility is found in full. Of a cell of 8 x 8 pixels that shows one triangle, 4 x 4 are shaded at
//! first: columns and rows 0, 2, 5 and 7. Where neighbours among them differ by few codes, all
//! others are blended from those around them, across and then down; else they are shaded too, so
//! no pixel is shaded twice. Cells of several triangles, or cut by the picture's border, are shaded whole:
//! edges are those of the full picture. What is missed is what falls between the sixteen.
//!
//! It pays where surfaces are even. Where textures vary in most cells there is little to spare, and
//! places one by one instead of in runs, and the looking, make it 1.4 times the instructions of the
//! full picture (city and interior of the frame benches).
//!
//! Cells lie on the grid of the whole picture, and tiles and blocks hold whole ones, so that neither
//! shows; nor do regions, which are drawn in whole cells ([`whole_cells`]).

use cullet_raster::NO_TRIANGLE;
use cullet_shade::wide::{Out, Run};
use glam::Vec4;

use crate::Region;
use crate::frame::Target;
use crate::shading::{encode, fill_background_from};
use crate::tile_shader::{TileShader, part_in};

/// Pixels along a side of a cell.
const CELL: usize = 8;

/// Columns and rows of a cell that are shaded at first.
const SAMPLES: [usize; 4] = [0, 2, 5, 7];

/// Neighbours among them differ if any of their 8-bit codes differ by more.
const CODES: u8 = 8;

/// A cell of one triangle.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Its upper left pixel: where that goes, and its place in the block.
    out: usize,
    x: u32,
    y: u32,
    /// Of the triangle.
    record: u32,
}

/// Memory for a block.
#[derive(Debug, Default)]
pub(crate) struct AdaptiveScratch {
    cells: Vec<Cell>,
}

impl AdaptiveScratch {
    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        self.cells.capacity() * size_of::<Cell>()
    }
}

/// `region`, up to the borders of the cells that it reaches, within a picture of these sides.
pub(crate) fn whole_cells(region: Region, width: u32, height: u32) -> Region {
    let span = |start: u32, len: u32, side: u32| {
        let cell = CELL as u32;
        let first = start - start % cell;
        (first, (start + len).next_multiple_of(cell).min(side) - first)
    };
    let ((x, width), (y, height)) =
        (span(region.x, region.width, width), span(region.y, region.height, height));
    Region { x, y, width, height }
}

impl TileShader<'_> {
    /// Colours the part of `rect`, which holds whole cells, that lies in a block, from ids as
    /// [`TileShader::blocks`] gets them.
    pub(crate) fn adaptive_block(
        &mut self,
        rect: Region,
        block: [u32; 2],
        ids: &[u32],
        stride: usize,
        out: &mut Target<'_>,
    ) -> u64 {
        let mut cells = std::mem::take(&mut self.scratch.adaptive.cells);
        cells.clear();
        let [left, top, right, bottom] = part_in(rect, block);
        let batch = &mut self.scratch.batch;
        batch.begin();
        for y in (top..bottom).step_by(CELL) {
            for x in (left..right).step_by(CELL) {
                let (row, column) = ((y - rect.y) as usize, (x - rect.x) as usize);
                let ids = &ids[row * stride + column..];
                let first = row * out.stride + column;
                let [x, y, right, bottom] =
                    [x - block[0], y - block[1], right - block[0], bottom - block[1]];
                let size = [CELL.min((right - x) as usize), CELL.min((bottom - y) as usize)];
                if size == [CELL; 2] && shows_one_triangle(ids, stride) {
                    let cell = Cell { out: first, x, y, record: batch.record_of(ids[0]) };
                    for [i, j] in sampled() {
                        batch.put(cell.pixel(i, j, out.stride));
                    }
                    cells.push(cell);
                    continue;
                }
                for j in 0..size[1] {
                    for (i, &id) in ids[j * stride..][..size[0]].iter().enumerate() {
                        let place = (first + j * out.stride + i) as u32;
                        batch.push(id, 1, place, [centre(x, i), centre(y, j)]);
                    }
                }
            }
        }
        let n_seen = batch.n_pixels() + (CELL * CELL - SAMPLES.len().pow(2)) * cells.len();
        let size = [right - left, bottom - top];
        if n_seen < (size[0] * size[1]) as usize {
            let first = (top - rect.y) as usize * out.stride + (left - rect.x) as usize;
            fill_background_from(self.scene.settings, size, first, out);
        }
        let stride = out.stride;
        if out.linear.is_empty() {
            let codes = &mut *out.rgba8;
            self.paint(block, &mut Out::Bytes(codes));
            cells.retain(|cell| {
                let samples = cell.samples(codes, stride);
                let is_even = is_even(&samples);
                if is_even {
                    cell.fill(&blended(&samples, mean_of_codes), codes, stride);
                }
                !is_even
            });
        } else {
            let (colors, encoding) = (&mut *out.linear, self.scene.settings.encoding);
            self.paint(block, &mut Out::Linear(colors));
            cells.retain(|cell| {
                let samples = cell.samples(colors, stride);
                let codes = samples.map(|row| row.map(|color| encode(encoding, color)));
                let is_even = is_even(&codes);
                if is_even {
                    cell.fill(&blended(&samples, mean_of_colors), colors, stride);
                }
                !is_even
            });
        }
        if !cells.is_empty() {
            let batch = &mut self.scratch.batch;
            batch.begin_more();
            for cell in &cells {
                for [i, j] in others() {
                    batch.put(cell.pixel(i, j, stride));
                }
            }
            let mut out = match out.linear.is_empty() {
                true => Out::Bytes(&mut *out.rgba8),
                false => Out::Linear(&mut *out.linear),
            };
            self.paint_more(block, &mut out);
        }
        self.scratch.adaptive.cells = cells;
        n_seen as u64
    }
}

/// Whether the cell at the start of `ids` shows the same triangle all over.
fn shows_one_triangle(ids: &[u32], stride: usize) -> bool {
    let first = ids[0];
    let mut differences = 0;
    for row in 0..CELL {
        for id in &ids[row * stride..][..CELL] {
            differences |= id ^ first;
        }
    }
    differences == 0 && first != NO_TRIANGLE
}

/// The centre of pixel `i` of a cell that begins at `first`, sixteenths of a pixel from the corner of
/// the block.
fn centre(first: u32, i: usize) -> u32 {
    16 * (first + i as u32) + 8
}

/// Column and row of the pixels that are shaded at first.
fn sampled() -> impl Iterator<Item = [usize; 2]> {
    SAMPLES.into_iter().flat_map(|j| SAMPLES.map(|i| [i, j]))
}

/// Column and row of all others.
fn others() -> impl Iterator<Item = [usize; 2]> {
    let all = (0..CELL * CELL).map(|i| [i % CELL, i / CELL]);
    all.filter(|[i, j]| !(SAMPLES.contains(i) && SAMPLES.contains(j)))
}

impl Cell {
    fn pixel(&self, i: usize, j: usize, stride: usize) -> Run {
        let out = (self.out + j * stride + i) as u32;
        Run::new(self.record, [centre(self.x, i), centre(self.y, j)], 1, out)
    }

    /// What was shaded, row by row.
    fn samples<T: Copy>(&self, colors: &[T], stride: usize) -> [[T; 4]; 4] {
        SAMPLES.map(|j| SAMPLES.map(|i| colors[self.out + j * stride + i]))
    }

    fn fill<T: Copy>(&self, cell: &[[T; CELL]; CELL], colors: &mut [T], stride: usize) {
        for (j, row) in cell.iter().enumerate() {
            colors[self.out + j * stride..][..CELL].copy_from_slice(row);
        }
    }
}

/// Whether neighbours across and down differ little.
fn is_even(codes: &[[[u8; 4]; 4]; 4]) -> bool {
    let mut largest = 0;
    for j in 0..4 {
        let row = codes[j].as_flattened();
        for i in 0..12 {
            largest = largest.max(row[i].abs_diff(row[i + 4]));
        }
        if j < 3 {
            let below = codes[j + 1].as_flattened();
            for i in 0..16 {
                largest = largest.max(row[i].abs_diff(below[i]));
            }
        }
    }
    largest <= CODES
}

/// Columns 0, 2, 5 and 7 to all eight, the same for rows; `mean` takes how many parts of three or two
/// come from the second.
fn blended<T: Copy>(samples: &[[T; 4]; 4], mean: impl Fn(T, T, Share) -> T) -> [[T; CELL]; CELL] {
    let along = |[a, b, c, d]: [T; 4]| {
        let (one, two) = (mean(b, c, Share::Third), mean(c, b, Share::Third));
        [a, mean(a, b, Share::Half), b, one, two, c, mean(c, d, Share::Half), d]
    };
    let rows = samples.map(along);
    let mut cell = [rows[0]; CELL];
    for i in 0..CELL {
        let column = along(rows.map(|row| row[i]));
        for j in 0..CELL {
            cell[j][i] = column[j];
        }
    }
    cell
}

/// How much of a mean is its second.
#[derive(Clone, Copy)]
enum Share {
    Half,
    Third,
}

/// Rounded up from a half.
fn mean_of_codes(a: [u8; 4], b: [u8; 4], share: Share) -> [u8; 4] {
    let mut mean = [0; 4];
    for channel in 0..4 {
        let (a, b) = (u32::from(a[channel]), u32::from(b[channel]));
        mean[channel] = match share {
            Share::Half => (a + b).div_ceil(2),
            Share::Third => (2 * a + b + 1) / 3,
        } as u8;
    }
    mean
}

fn mean_of_colors(a: Vec4, b: Vec4, share: Share) -> Vec4 {
    let share = match share {
        Share::Half => 0.5,
        Share::Third => 1.0 / 3.0,
    };
    a + (b - a) * share
}
