//! More pixels than asked for, averaged: every sample is shaded.
//!
//! The picture is drawn two or four times as wide and as high, tile by tile. Sides of tiles are
//! multiples of eight, so the pixels that make one of the asked size lie in one tile, and no more
//! than a tile of them is ever held. Means are taken in linear light with alpha counted in (Porter
//! & Duff 1984, "Compositing Digital Images"), row by row and left to right.

use cullet_shade::Encoding;
use cullet_transform::{View, Viewport};
use glam::Vec4;

use crate::Region;
use crate::frame::Target;
use crate::settings::Antialias;
use crate::shading::encode;

/// The colours of a tile before they are averaged, row-major.
#[derive(Debug, Default)]
pub(crate) struct FineTile {
    linear: Vec<Vec4>,
    width: usize,
}

/// How the colours of a picture are drawn: `per_side` pixels for each one along a side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supersampling {
    pub per_side: u32,
    pub view: View,
}

impl Supersampling {
    /// What `antialias` asks for, as far as the sides of a picture may grow; `None` if that is one
    /// pixel for each.
    pub fn new(view: &View, antialias: Antialias) -> Option<Self> {
        let mut per_side = antialias.per_side();
        while per_side > 1 {
            let [width, height] = [view.viewport().width(), view.viewport().height()];
            if let Ok(viewport) = Viewport::new(width * per_side, height * per_side) {
                return Some(Supersampling { per_side, view: View::new(view.camera(), viewport) });
            }
            per_side /= 2;
        }
        None
    }
}

/// The pixels that are drawn for those of `region`.
pub(crate) fn fine(Region { x, y, width, height }: Region, n: u32) -> Region {
    Region { x: n * x, y: n * y, width: n * width, height: n * height }
}

impl FineTile {
    /// Where `rect` is to be drawn.
    pub fn target(&mut self, rect: Region) -> Target<'_> {
        self.width = rect.width as usize;
        self.linear.clear();
        self.linear.resize(self.width * rect.height as usize, Vec4::ZERO);
        Target { stride: self.width, linear: &mut self.linear, ..Target::default() }
    }

    /// Averages `n` by `n` pixels for each of `out`.
    pub fn average(&self, n: u32, encoding: Encoding, out: &mut Target<'_>) {
        let n = n as usize;
        for (y, rows) in self.linear.chunks_exact(n * self.width).enumerate() {
            for x in 0..self.width / n {
                let color = mean(rows.chunks_exact(self.width).map(|row| &row[n * x..n * (x + 1)]));
                let at = y * out.stride + x;
                if let Some(linear) = out.linear.get_mut(at) {
                    *linear = color;
                }
                if let Some(bytes) = out.rgba8.get_mut(at) {
                    *bytes = encode(encoding, color);
                }
            }
        }
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        self.linear.capacity() * size_of::<Vec4>()
    }
}

/// The mean of a square of colours with straight alpha.
fn mean<'a>(rows: impl ExactSizeIterator<Item = &'a [Vec4]>) -> Vec4 {
    let n = rows.len();
    let share = 1.0 / (n * n) as f32; // a power of two: exact
    let mut sum = Vec4::ZERO;
    for color in rows.flatten() {
        sum += (color.truncate() * color.w).extend(color.w);
    }
    let sum = sum * share;
    let partly = sum.w > 0.0 && sum.w < 1.0;
    if partly { (sum.truncate() / sum.w).extend(sum.w) } else { sum }
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;

    use super::*;
    use crate::{Frame, Pass, Passes, Prepared, Renderer, Settings, frame_scene};

    fn draw(prepared: &Prepared, view: &View, settings: &Settings) -> Frame {
        let mut frame = Frame::default();
        Renderer::default().render(prepared, view, settings, &mut frame);
        frame
    }

    /// A scene and two views of it, the second with `n` times the pixels along a side.
    fn views(n: u32) -> (Prepared, [View; 2]) {
        let prepared = Prepared::new(synth("masks").unwrap()).unwrap();
        let viewport = Viewport::new(83, 61).unwrap();
        let camera = frame_scene(&prepared, viewport.aspect());
        let fine = Viewport::new(n * 83, n * 61).unwrap();
        (prepared, [View::new(&camera, viewport), View::new(&camera, fine)])
    }

    #[test]
    fn colours_are_means_of_a_larger_picture() {
        for (antialias, n) in [(Antialias::Ssaa4, 2), (Antialias::Ssaa16, 4)] {
            let (prepared, [view, large]) = views(n);
            let background = Vec4::new(0.3, 0.2, 0.1, 0.0);
            let passes = Passes::COLOR.with(Pass::Linear);
            let settings = Settings { antialias, passes, background, ..Settings::default() };
            let plain = Settings { antialias: Antialias::None, ..settings };
            let (frame, large) =
                (draw(&prepared, &view, &settings), draw(&prepared, &large, &plain));
            let mut n_partly = 0;
            for (i, color) in frame.linear.iter().enumerate() {
                let [x, y] = [i % 83, i / 83].map(|at| at * n as usize);
                let mut sum = glam::DVec4::ZERO;
                for at in (0..n * n).map(|i| [x + (i % n) as usize, y + (i / n) as usize]) {
                    let color = large.linear[at[1] * large.width as usize + at[0]].as_dvec4();
                    sum += (color.truncate() * color.w).extend(color.w) / f64::from(n * n);
                }
                let found = color.as_dvec4();
                let found = (found.truncate() * found.w).extend(found.w);
                assert!((found - sum).abs().max_element() < 1e-6, "pixel {i}");
                assert_eq!(frame.rgba8[i], encode(Encoding::Exact, *color));
                n_partly += u32::from(color.w > 0.0 && color.w < 1.0);
            }
            assert!(n_partly > 50, "{n_partly}");
        }
    }

    #[test]
    fn data_takes_one_sample_at_the_centre() {
        let (prepared, [view, _]) = views(2);
        let passes = Pass::ALL.into_iter().collect::<Passes>().data();
        let settings = Settings { passes, antialias: Antialias::Ssaa4, ..Settings::default() };
        let with_color = Settings { passes: passes.with(Pass::Color), ..settings };
        let plain = Settings { antialias: Antialias::None, ..settings };
        let plain = draw(&prepared, &view, &plain);
        for settings in [settings, with_color] {
            let frame = draw(&prepared, &view, &settings);
            assert!(frame.id == plain.id && frame.triangle == plain.triangle);
            assert!(frame.depth == plain.depth && frame.position == plain.position);
            assert!(frame.normal == plain.normal && frame.uv == plain.uv);
            assert!(frame.albedo == plain.albedo);
        }
    }

    #[test]
    fn neither_tiles_nor_regions_nor_threads_show() {
        let (prepared, [view, _]) = views(4);
        let passes = Passes::COLOR.with(Pass::Id);
        let settings = Settings { passes, antialias: Antialias::Ssaa16, ..Settings::default() };
        let whole = draw(&prepared, &view, &settings);
        for (tile_px, threads) in [(8, 1), (24, 3), (256, 2)] {
            let frame = draw(&prepared, &view, &Settings { tile_px, threads, ..settings });
            assert!(frame.rgba8 == whole.rgba8 && frame.id == whole.id, "{tile_px}");
        }
        for region in [
            Region { x: 3, y: 17, width: 1, height: 44 },
            Region { x: 15, y: 16, width: 60, height: 3 },
        ] {
            let part = draw(&prepared, &view, &Settings { region: Some(region), ..settings });
            for (y, row) in part.rgba8.chunks(region.width as usize).enumerate() {
                let start = (region.y as usize + y) * 83 + region.x as usize;
                assert!(row == &whole.rgba8[start..start + row.len()], "{region:?}, row {y}");
            }
        }
    }

    #[test]
    fn pictures_that_cannot_grow_are_drawn_as_they_are() {
        let (prepared, _) = views(1);
        let view = |width| {
            let viewport = Viewport::new(width, 1).unwrap();
            View::new(&frame_scene(&prepared, viewport.aspect()), viewport)
        };
        let per_side =
            |width| Supersampling::new(&view(width), Antialias::Ssaa16).map(|found| found.per_side);
        assert_eq!([8192, 8193, 16385].map(per_side), [Some(4), Some(2), None]);
        assert!(Supersampling::new(&view(10), Antialias::Msaa4).is_none());
    }

    #[test]
    fn means_count_alpha_in() {
        let (red, clear) = (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(9.0, 9.0, 9.0, 0.0));
        let rows = [[red, clear], [clear, red]];
        assert_eq!(mean(rows.iter().map(|row| &row[..])), Vec4::new(1.0, 0.0, 0.0, 0.5));
    }
}
