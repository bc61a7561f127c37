//! What is true: pictures and counts that no knob touches.
//!
//! * The picture: 256 samples per pixel, on a grid of 4 x 4 in each of 16 shifted frames of four
//!   times the size, summed in f64; never less than 64, four in each cell of the grid, since 16 on that
//!   grid would be what `ssaa16` draws, and call it perfect. Either half of the samples is kept as a
//!   picture of its own: by how much the two disagree about an error is how far it can be trusted. Textures are looked at through sixteenths of pixels, so
//!   the mean is that of the finest levels. Cast by the f64 ray caster
//!   where the budget allows that; else drawn by the rasterizer with every short cut off, and one
//!   sample per pixel compared with the ray caster's.
//! * The triangles: cast in f64 against the true geometry, not snapped, one ray per pixel.
//! * The visible objects: by the exact test, box by box.
//! * For lights that end, the picture of one that does not: drawn as the default is, but without
//!   culling, so that the two differ in the light alone.

use std::time::{Duration, Instant};

use cullet::cull::{Frustum, Sat, Verdict};
use cullet::{
    Accumulation, Antialias, CullTest, Filter, Frame, Pass, Passes, Prepared, Renderer,
    RendererKind, Resolution, Settings, View, sample_place,
};
use cullet_measure::{PIXELS_PER_DEGREE, Perceived, Picture};
use glam::Vec4;

use super::metrics;
use crate::exit::Failure;

/// Frames that the picture is the mean of.
const FRAMES: u32 = 16;

/// Frames that are drawn whatever the budget.
const FEWEST_FRAMES: u32 = 4;

/// How much larger than the picture each frame is.
const FINER: u32 = 4;

/// Which of the [`sample_place`]s comes when. Four in a row that begin at a multiple of four lie in four
/// quarters of the pixel, as do those that are even in number, or odd: whenever time is over, the
/// pixel is covered evenly, and so it is by either half.
const ORDER: [u32; FRAMES as usize] = {
    let bases = [0b1011, 0b0101, 0b1010, 0b0011];
    let mut order = [0; FRAMES as usize];
    let mut i = 0;
    while i < order.len() {
        let mut bit = 0;
        while bit < bases.len() {
            if i >> bit & 1 == 1 {
                order[i] ^= bases[bit];
            }
            bit += 1;
        }
        i += 1;
    }
    order
};

/// The truth about one view of one scene.
pub struct Reference {
    /// The picture.
    pub picture: Picture,
    /// The same from every other of its frames alone, and from the rest.
    pub halves: [Picture; 2],
    /// Samples per pixel of `picture`.
    pub n_samples: u32,
    /// Who drew it and how finely.
    pub how: String,
    /// Triangle number + 1 by pixel, 0 where nothing is.
    pub triangles: Vec<u32>,
    /// Objects that are in the view.
    pub n_visible: u64,
    /// As the default draws it.
    pub default: Picture,
    /// The same, with a light at a point that never ends.
    pub lit: Picture,
    /// `picture`, `halves` and `lit` as FLIP perceives them.
    pub perceived: ReferencePerceived,
}

/// What FLIP compares with.
pub struct ReferencePerceived {
    pub whole: Perceived,
    pub halves: [Perceived; 2],
    pub lit: Perceived,
}

/// What finding it may take.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Wall time; a frame begun is finished.
    pub time: Duration,
    /// Rays; where it takes more, the rasterizer draws the picture.
    pub rays: u64,
}

impl Reference {
    /// Finds it. `settings` say what is shown: background,
    /// light, shading; `lit` are the same with a light that never ends.
    pub fn find(
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        lit: &Settings,
        room: Room,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Reference, Failure> {
        progress("casting rays");
        let truth = Settings { threads: 0, ..*settings };
        let begun = Instant::now();
        let exact = Settings {
            renderer: RendererKind::Raycast { snapped: false },
            passes: Passes::COLOR.with(Pass::Triangle),
            ..truth
        };
        let mut cast = Frame::default();
        Renderer::default().render(prepared, view, &exact, &mut cast);

        let linear = Passes::NONE.with(Pass::Linear);
        let filter = Filter::Oversampled(FRAMES.ilog2() as u8);
        let plain = Settings {
            passes: linear,
            filter,
            antialias: Antialias::None,
            accumulate: 1,
            resolution: Resolution::Full,
            cull: CullTest::None,
            hierarchy: false,
            occlusion: false,
            ..truth
        };
        let n_rays = cast.len() as u64 * u64::from(FRAMES * FINER * FINER);
        let rays_fit = n_rays <= room.rays;
        let one = if rays_fit { Settings { passes: linear, filter, ..exact } } else { plain };
        let finer = view
            .enlarged(FINER)
            .ok_or_else(|| Failure::limit("pictures four times the size would be too large"))?;
        let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
        let mut halves = [Accumulation::default(), Accumulation::default()];
        for (i, &place) in ORDER.iter().enumerate() {
            // In pairs, so that halves are halves.
            if i >= FEWEST_FRAMES as usize && i.is_multiple_of(2) && begun.elapsed() > room.time {
                break;
            }
            progress(&format!("reference {} of {FRAMES}", i + 1));
            let [x, y] = sample_place(place, FRAMES);
            renderer.render(prepared, &finer.shifted(x - 0.5, y - 0.5), &one, &mut frame);
            halves[i % 2].add(&shrunk(&frame, FINER as usize), 0);
        }
        let viewport = view.viewport();
        let (width, height) = (viewport.width() as usize, viewport.height() as usize);
        let picture = |colors: &dyn Fn(usize) -> Vec4| {
            let colors: Vec<[f32; 3]> =
                (0..width * height).map(|i| colors(i).truncate().to_array()).collect();
            Picture::from_linear(width, height, &colors).map_err(Failure::input)
        };
        let [even, odd] = &halves;
        let whole = picture(&|i| mean_of_two(even.mean(i), odd.mean(i)))?;
        let n_samples = 2 * even.n_pictures() * FINER * FINER;
        let halves = [picture(&|i| even.mean(i))?, picture(&|i| odd.mean(i))?];
        let how = if rays_fit {
            format!("{n_samples} samples per pixel by the f64 ray caster")
        } else {
            let same = same_as_rays(prepared, view, &plain, &cast);
            format!(
                "{n_samples} samples per pixel by the rasterizer, one triangle and one shading per \
                 sample, no short cuts; {same}"
            )
        };
        let lit = Settings { cull: CullTest::None, ..*lit };
        renderer.render(prepared, view, &lit, &mut frame);
        let lit = metrics::picture(&frame).map_err(Failure::input)?;
        renderer.render(prepared, view, settings, &mut frame);
        let perceived = |picture: &Picture| Perceived::of(picture, PIXELS_PER_DEGREE);
        let perceived = ReferencePerceived {
            whole: perceived(&whole),
            halves: [perceived(&halves[0]), perceived(&halves[1])],
            lit: perceived(&lit),
        };
        Ok(Reference {
            perceived,
            default: metrics::picture(&frame).map_err(Failure::input)?,
            lit,
            picture: whole,
            halves,
            n_samples,
            how,
            triangles: cast.triangle,
            n_visible: n_visible(prepared, view),
        })
    }
}

/// The mean of two colours with straight alpha.
fn mean_of_two(a: Vec4, b: Vec4) -> Vec4 {
    let alpha = a.w + b.w;
    let rgb = a.truncate() * a.w + b.truncate() * b.w;
    if alpha > 0.0 { (rgb / alpha).extend(0.5 * alpha) } else { Vec4::ZERO }
}

/// How far the rasterizer agrees with the ray caster, one sample per pixel.
fn same_as_rays(prepared: &Prepared, view: &View, plain: &Settings, cast: &Frame) -> String {
    // The ray caster's one sample was filtered as frames of one sample are.
    let settings = Settings { passes: Passes::COLOR, filter: Filter::Trilinear, ..*plain };
    let mut frame = Frame::default();
    Renderer::default().render(prepared, view, &settings, &mut frame);
    let differs = |(a, b): &(&[u8; 4], &[u8; 4])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1);
    let n = frame.rgba8.iter().zip(&cast.rgba8).filter(differs).count();
    format!(
        "at one sample {n} of {} pixels differ from the f64 ray caster's by over 1/255",
        frame.len()
    )
}

/// Objects that the exact test keeps.
fn n_visible(prepared: &Prepared, view: &View) -> u64 {
    let frustum = Frustum::from_camera(view.camera(), view.viewport().aspect());
    let sat = Sat::new(&frustum.relative_to_eye());
    let boxes = prepared.items().iter().filter(|item| !item.bounds.is_empty());
    let visible = boxes.filter(|item| Verdict::on(&item.bounds_from_eye(view), &sat).visible());
    visible.count() as u64
}

/// Means of `n` x `n` pixels.
fn shrunk(frame: &Frame, n: usize) -> Vec<Vec4> {
    let stride = frame.width as usize;
    let (width, height) = (stride / n, frame.height as usize / n);
    let share = 1.0 / (n * n) as f32;
    let mut out = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let rows = (y * n..(y + 1) * n).map(|row| row * stride + x * n);
            let sum: Vec4 = rows.flat_map(|at| &frame.linear[at..at + n]).sum();
            out.push(sum * share);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_samples_are_as_even_as_many() {
        let mut all = ORDER;
        all.sort_unstable();
        assert!(all.into_iter().eq(0..FRAMES));
        let quarters = |frames: &mut dyn Iterator<Item = u32>| {
            let places = frames.map(|i| sample_place(i, FRAMES));
            let mut n = [0; 4];
            places.for_each(|[x, y]| n[2 * usize::from(y > 0.5) + usize::from(x > 0.5)] += 1);
            n
        };
        for four in ORDER.chunks(4) {
            assert_eq!(quarters(&mut four.iter().copied()), [1; 4], "{four:?}");
        }
        for first in 0..2 {
            assert_eq!(quarters(&mut ORDER.into_iter().skip(first).step_by(2)), [2; 4]);
        }
    }

    #[test]
    fn transparent_colors_do_not_count() {
        let (red, none) = (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 1.0, 0.0, 0.0));
        assert_eq!(mean_of_two(red, none), Vec4::new(1.0, 0.0, 0.0, 0.5));
        assert_eq!(mean_of_two(none, none), Vec4::ZERO);
    }
}
