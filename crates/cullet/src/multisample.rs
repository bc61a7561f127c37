//! Colours from several samples per pixel: one where they agree, a mean where they do not.
//!
//! A pixel is shaded once per triangle seen in it: at its centre where the triangle covers that,
//! else at the first of its samples seen. Colours are averaged in linear light, weighted by samples, with
//! alpha counted in (Porter & Duff 1984, "Compositing Digital Images"), so nothing of a
//! transparent background shows.

use cullet_raster::{CENTRE_COVERED, NO_TRIANGLE, Samples, TileBuffer};
use glam::Vec4;

use crate::Region;
use crate::frame::Target;
use crate::shading::encode;
use crate::tile_shader::{TileShader, Wanted};

/// Memory for pixels whose samples disagree.
#[derive(Debug, Default)]
pub(crate) struct EdgeScratch {
    /// Ids of a rectangle where all samples of a pixel agree, else [`NO_TRIANGLE`].
    whole: Vec<u32>,
    edges: Vec<Edge>,
    wanted: Vec<Wanted>,
    /// Samples that see each of `wanted`.
    weights: Vec<f32>,
    colors: Vec<Vec4>,
}

/// A pixel whose samples disagree.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// Where it goes.
    out: u32,
    /// How many of the places wanted are its own.
    n_wanted: u32,
}

impl EdgeScratch {
    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        4 * (self.whole.capacity() + self.weights.capacity())
            + self.edges.capacity() * size_of::<Edge>()
            + self.wanted.capacity() * size_of::<Wanted>()
            + self.colors.capacity() * size_of::<Vec4>()
    }

    /// Sorts the pixels of a row, from `x`, `y` in the picture on, into those of one triangle and others.
    /// `ids` are those of all samples; pixels go to `out` and on.
    fn row<const N: usize>(&mut self, ids: [&[u32]; N], offsets: &[[i32; 2]; N], place: Place) {
        let start = self.whole.len();
        self.whole.resize(start + ids[0].len(), NO_TRIANGLE);
        let width = ids[0].len();
        let mut first = 0;
        while first < width {
            let n = (width - first).min(8);
            let mut eight = [[NO_TRIANGLE; 8]; N];
            for sample in 0..N {
                eight[sample][..n].copy_from_slice(&ids[sample][first..first + n]);
            }
            let mut differs = [0; 8];
            for sample in 1..N {
                for lane in 0..8 {
                    differs[lane] |= (eight[sample][lane] ^ eight[0][lane]) & !CENTRE_COVERED;
                }
            }
            let whole = &mut self.whole[start + first..start + first + n];
            for (lane, whole) in whole.iter_mut().enumerate() {
                let id = eight[0][lane];
                let is_seen = id != NO_TRIANGLE && differs[lane] == 0;
                *whole = if is_seen { id & !CENTRE_COVERED } else { NO_TRIANGLE };
            }
            if differs != [0; 8] {
                for lane in (0..n).filter(|lane| differs[*lane] != 0) {
                    let ids = std::array::from_fn(|sample| eight[sample][lane]);
                    self.edge(ids, offsets, place.right(first + lane));
                }
            }
            first += n;
        }
    }

    /// A pixel whose samples see different triangles.
    #[inline(always)]
    fn edge<const N: usize>(&mut self, mut ids: [u32; N], offsets: &[[i32; 2]; N], place: Place) {
        let n_before = self.wanted.len();
        for sample in 0..N {
            let seen = ids[sample];
            if seen == NO_TRIANGLE {
                continue;
            }
            // This and all later samples of the triangle.
            let mut weight = 0;
            for id in &mut ids[sample..] {
                let same = (*id ^ seen) & !CENTRE_COVERED == 0;
                weight += u32::from(same);
                *id = if same { NO_TRIANGLE } else { *id };
            }
            let [dx, dy] = if seen & CENTRE_COVERED == 0 { offsets[sample] } else { [0, 0] };
            let (x, y) = (place.x as i32 * 16 + 8 + dx, place.y as i32 * 16 + 8 + dy);
            self.wanted.push(Wanted { id: seen & !CENTRE_COVERED, x, y });
            self.weights.push(weight as f32);
        }
        let n_wanted = (self.wanted.len() - n_before) as u32;
        self.edges.push(Edge { out: place.out as u32, n_wanted });
    }

    /// [`EdgeScratch::row`] for all rows of a rectangle, whose upper left pixel is at `column`, `row` in
    /// `tile`.
    fn rows<const N: usize>(
        &mut self,
        tile: &TileBuffer,
        rect: Region,
        [column, row]: [u32; 2],
        stride: usize,
    ) {
        let offsets: &[[i32; 2]; N] = tile.samples().offsets().first_chunk().expect("N samples");
        let columns = column as usize..(column + rect.width) as usize;
        for i in 0..rect.height {
            let ids = |sample| &tile.ids(sample, (row + i) as usize)[columns.clone()];
            let place = Place { x: rect.x, y: rect.y + i, out: i as usize * stride };
            self.row::<N>(std::array::from_fn(ids), offsets, place);
        }
    }
}

/// A pixel of the picture, and where it goes.
#[derive(Clone, Copy, Debug)]
struct Place {
    x: u32,
    y: u32,
    out: usize,
}

impl Place {
    /// `n` pixels to the right.
    fn right(self, n: usize) -> Self {
        Place { x: self.x + n as u32, out: self.out + n, ..self }
    }
}

impl TileShader<'_> {
    /// Colours `rect`, whose upper left pixel is at `place` in `tile`, and the background. Returns how
    /// many pixels show something.
    pub(crate) fn multisampled(
        &mut self,
        rect: Region,
        tile: &TileBuffer,
        place: [u32; 2],
        out: &mut Target<'_>,
    ) -> u64 {
        let mut scratch = std::mem::take(&mut self.scratch.edges);
        scratch.whole.clear();
        scratch.edges.clear();
        scratch.wanted.clear();
        scratch.weights.clear();
        let width = rect.width as usize;
        match tile.samples() {
            Samples::One => scratch.rows::<1>(tile, rect, place, out.stride),
            Samples::Two => scratch.rows::<2>(tile, rect, place, out.stride),
            Samples::Four => scratch.rows::<4>(tile, rect, place, out.stride),
            Samples::Eight => scratch.rows::<8>(tile, rect, place, out.stride),
        }
        let n_whole = self.blocks(rect, &scratch.whole, width, out);
        scratch.colors.clear();
        scratch.colors.resize(scratch.wanted.len(), Vec4::ZERO);
        self.colors(&scratch.wanted, &mut scratch.colors);
        let one_sample = 1.0 / tile.samples().count() as f32;
        let (background, encoding) = (self.scene.settings.background, self.scene.settings.encoding);
        let mut first = 0;
        for edge in &scratch.edges {
            let own = first..first + edge.n_wanted as usize;
            first = own.end;
            let colors = scratch.colors[own.clone()].iter().zip(&scratch.weights[own]);
            let color = blend(colors, one_sample, background);
            match out.linear.get_mut(edge.out as usize) {
                Some(linear) => *linear = color,
                None => out.rgba8[edge.out as usize] = encode(encoding, color),
            }
        }
        let n_edges = scratch.edges.len() as u64;
        self.scratch.edges = scratch;
        n_whole + n_edges
    }
}

/// The mean of colours of so many samples each; all other samples see the background.
fn blend<'a>(
    colors: impl Iterator<Item = (&'a Vec4, &'a f32)>,
    one_sample: f32,
    background: Vec4,
) -> Vec4 {
    let (mut sum, mut seen) = (Vec4::ZERO, 0.0);
    for (color, n) in colors {
        sum += (color.truncate() * color.w).extend(color.w) * (n * one_sample);
        seen += n * one_sample;
    }
    let unseen = 1.0 - seen; // exact: multiples of an eighth
    if unseen > 0.0 {
        sum += (background.truncate() * background.w).extend(background.w) * unseen;
    }
    let partly = sum.w > 0.0 && sum.w < 1.0;
    if partly { (sum.truncate() / sum.w).extend(sum.w) } else { sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_count_alpha_in() {
        let red = Vec4::new(1.0, 0.0, 0.0, 1.0);
        let green = Vec4::new(0.0, 1.0, 0.0, 1.0);
        let mean = blend([(&red, &1.0), (&green, &2.0)].into_iter(), 0.25, Vec4::ONE);
        assert_eq!(mean, Vec4::new(0.5, 0.75, 0.25, 1.0));
        let clear = Vec4::new(9.0, 9.0, 9.0, 0.0);
        let mean = blend([(&red, &1.0), (&green, &1.0)].into_iter(), 0.25, clear);
        assert_eq!(mean, Vec4::new(0.5, 0.5, 0.0, 0.5));
    }
}
