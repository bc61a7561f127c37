//! Colours from several samples per pixel: one where they agree, a mean where they do not.
//!
//! A pixel is shaded once per triangle seen in it: at its centre where the triangle covers that,
//! else at the first of its samples seen. Colours are averaged in linear light, weighted by samples, with
//! alpha counted in (Porter & Duff 1984, "Compositing Digital Images"), so nothing of a
//! transparent background shows.

use cullet_raster::{CENTRE_COVERED, NO_TRIANGLE, TileBuffer};
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

    /// Sorts the pixels of a row into those of one triangle and others.
    fn row(
        &mut self,
        tile: &TileBuffer,
        [column, row]: [usize; 2],
        y: u32,
        x: u32,
        out: usize,
        width: usize,
    ) {
        let n_samples = tile.samples().count();
        let mut rows: [&[u32]; MAX_SAMPLES] = [&[]; MAX_SAMPLES];
        for (sample, ids) in rows.iter_mut().enumerate().take(n_samples) {
            *ids = &tile.ids(sample, row)[column..column + width];
        }
        let start = self.whole.len();
        self.whole.extend_from_slice(rows[0]);
        let whole = &mut self.whole[start..];
        let mut differences = 0;
        for ids in &rows[1..n_samples] {
            for (whole, (id, first)) in whole.iter_mut().zip(ids.iter().zip(rows[0])) {
                let differs = (id ^ first) & !CENTRE_COVERED != 0;
                *whole = if differs { MIXED } else { *whole };
                differences += u32::from(differs);
            }
        }
        for (i, whole) in whole.iter_mut().enumerate() {
            if *whole != MIXED || differences == 0 {
                *whole = if *whole == NO_TRIANGLE { *whole } else { *whole & !CENTRE_COVERED };
                continue;
            }
            *whole = NO_TRIANGLE;
            let mut ids = [NO_TRIANGLE; MAX_SAMPLES];
            for (id, ids) in ids.iter_mut().zip(&rows[..n_samples]) {
                *id = ids[i];
            }
            let n_before = self.wanted.len();
            for sample in 0..n_samples {
                let seen = ids[sample];
                if seen == NO_TRIANGLE {
                    continue;
                }
                // This and all later samples of the triangle.
                let mut weight = 0;
                for id in &mut ids[sample..n_samples] {
                    let same = (*id ^ seen) & !CENTRE_COVERED == 0;
                    weight += u32::from(same);
                    *id = if same { NO_TRIANGLE } else { *id };
                }
                let [dx, dy] = match seen & CENTRE_COVERED {
                    0 => tile.samples().offsets()[sample],
                    _ => [0, 0],
                };
                let (x, y) = ((x as i32 + i as i32) * 16 + 8 + dx, y as i32 * 16 + 8 + dy);
                self.wanted.push(Wanted { id: seen & !CENTRE_COVERED, x, y });
                self.weights.push(weight as f32);
            }
            let n_wanted = (self.wanted.len() - n_before) as u32;
            self.edges.push(Edge { out: (out + i) as u32, n_wanted });
        }
    }
}

/// The most samples of a pixel.
const MAX_SAMPLES: usize = 8;

/// No triangle has this id.
const MIXED: u32 = NO_TRIANGLE - 1;

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
        for i in 0..rect.height {
            let at = [place[0] as usize, (place[1] + i) as usize];
            scratch.row(tile, at, rect.y + i, rect.x, i as usize * out.stride, width);
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
