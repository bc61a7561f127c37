//! Which clusters each tile has to draw: lists of numbers, tile after tile in one buffer.

use crate::Region;

/// The tiles of a grid over the whole picture that a region needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Grid {
    /// Pixels along a side of a tile.
    pub side: u32,
    /// First column and row of tiles.
    pub first: [u32; 2],
    /// Tiles across and down.
    pub size: [u32; 2],
}

impl Grid {
    pub fn new(region: Region, side: u32) -> Self {
        let first = [region.x / side, region.y / side];
        let end =
            [(region.x + region.width).div_ceil(side), (region.y + region.height).div_ceil(side)];
        Grid { side, first, size: [end[0] - first[0], end[1] - first[1]] }
    }

    pub fn len(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Columns, then rows, of the grid's own tiles that pixels `x` and `y` touch; may be none.
    fn tiles(&self, x: [i32; 2], y: [i32; 2]) -> [std::ops::Range<u32>; 2] {
        let range = |[start, end]: [i32; 2], axis: usize| {
            if start >= end {
                return 0..0;
            }
            let (start, end) =
                (start.max(0) as u32 / self.side, (end.max(0) as u32).div_ceil(self.side));
            let first = self.first[axis];
            start.saturating_sub(first)..end.saturating_sub(first).min(self.size[axis])
        };
        [range(x, 0), range(y, 1)]
    }
}

/// Numbers by tile, in the order in which they were put in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bins {
    starts: Vec<u32>,
    numbers: Vec<u32>,
}

impl Bins {
    /// Puts number `i` into all tiles that rectangle `i` touches.
    pub fn fill(
        &mut self,
        grid: &Grid,
        rectangles: impl Iterator<Item = ([i32; 2], [i32; 2])> + Clone,
    ) {
        let Bins { starts, numbers } = self;
        starts.clear();
        starts.resize(grid.len() + 2, 0);
        for (x, y) in rectangles.clone() {
            let [columns, rows] = grid.tiles(x, y);
            for row in rows {
                for column in columns.clone() {
                    starts[(row * grid.size[0] + column) as usize + 2] += 1;
                }
            }
        }
        for i in 2..starts.len() {
            starts[i] += starts[i - 1];
        }
        numbers.clear();
        numbers.resize(starts[starts.len() - 1] as usize, 0);
        // `starts[tile + 1]` moves from the beginning of the tile's list to its end.
        for (number, (x, y)) in (0..).zip(rectangles) {
            let [columns, rows] = grid.tiles(x, y);
            for row in rows {
                for column in columns.clone() {
                    let next = &mut starts[(row * grid.size[0] + column) as usize + 1];
                    numbers[*next as usize] = number;
                    *next += 1;
                }
            }
        }
    }

    /// The numbers in a tile.
    pub fn of(&self, tile: usize) -> &[u32] {
        &self.numbers[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }

    /// How many numbers there are in the tiles from the first to before the second.
    pub fn count(&self, tiles: std::ops::Range<usize>) -> usize {
        (self.starts[tiles.end] - self.starts[tiles.start]) as usize
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        4 * (self.starts.capacity() + self.numbers.capacity())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_get_what_touches_them() {
        let grid = Grid::new(Region { x: 70, y: 10, width: 100, height: 100 }, 64);
        assert_eq!((grid.first, grid.size), ([1, 0], [2, 2]));
        let rectangles = [
            ([0, 200], [0, 200]),
            ([64, 128], [0, 64]),
            ([0, 64], [0, 64]),
            ([128, 129], [63, 65]),
            ([90, 90], [0, 9]),
            ([192, 400], [128, 300]),
        ];
        let mut bins = Bins::default();
        for _ in 0..2 {
            bins.fill(&grid, rectangles.iter().copied());
            let lists: Vec<_> = (0..4).map(|tile| bins.of(tile)).collect();
            assert_eq!(lists, [&[0, 1][..], &[0, 3], &[0], &[0, 3]]);
        }
    }
}
