//! Alpha tests, eight places of a triangle at a time: [`crate::alpha`], wide.

use cullet_scene::AlphaMode;
use fearless_simd::{Simd, dispatch};

use super::column::{Lanes, wide};
use super::paint::{Paint, Sampled, Scratch, Stage};
use super::record::Record;
use crate::kernel::Look;
use crate::needs::{Needs, Shading};
use crate::surface::Surface;
use crate::texture::STEP;

/// A material with holes.
#[derive(Clone, Copy, Debug)]
pub struct Cutout<'a> {
    paint: Paint<'a>,
    /// What of the surface the alpha of a place depends on.
    needs: Needs,
    /// Factor of the texture's alpha.
    factor: f32,
    cutoff: f32,
}

impl<'a> Cutout<'a> {
    /// `None` if the material has no holes, or if wide code does not serve: without a texture, with nearest
    /// texels, with samples along the footprint, with vertex colours.
    pub fn new(surface: &Surface<'a>, look: &Look) -> Option<Self> {
        let AlphaMode::Mask { cutoff } = surface.material.alpha else { return None };
        let needs = Needs::of(surface.mesh, surface.material, Shading::Unlit);
        if needs.contains(Needs::VERTEX_COLOR) {
            return None;
        }
        let paint = Paint::new(surface, needs, look);
        let is_wide = matches!(paint.texture, Some(Sampled::Wide(_)));
        let factor = surface.material.base_color.w;
        is_wide.then_some(Cutout { paint, needs, factor, cutoff })
    }

    /// What records must be set up for.
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// Which of eight places, px from the corner of the record's block, have matter, and for which of
    /// them that is to be trusted: a bit each. The others are to be asked of [`crate::alpha`].
    pub fn kept(&self, record: &Record, places: [[f32; 8]; 2], scratch: &mut Scratch) -> [u64; 2] {
        dispatch!(self.paint.simd, simd => kept(simd, self, record, places, &mut scratch.0))
    }
}

#[inline(always)]
fn kept<S: Simd>(
    simd: S,
    cutout: &Cutout<'_>,
    record: &Record,
    places: [[f32; 8]; 2],
    stage: &mut Stage,
) -> [u64; 2] {
    wide!(S, kept_of(simd, cutout, record, places, stage))
}

#[inline(always)]
fn kept_of<S: Simd, V: Lanes<S>>(
    simd: S,
    cutout: &Cutout<'_>,
    record: &Record,
    places: [[f32; 8]; 2],
    stage: &mut Stage,
) -> [u64; 2] {
    let Some(Sampled::Wide(sampler)) = &cutout.paint.texture else { return [0; 2] };
    stage.places.set_eight(places);
    let (records, mut good) = (core::slice::from_ref(record), 0);
    const PLACES: usize = 8;
    for group in 0..PLACES.div_ceil(V::LEN) {
        // What is there and what is not is always decided exactly.
        cutout.paint.place::<S, V, false>(simd, records, &[], stage, group);
        let lod = sampler.levels::<S, V>(simd, stage.lod.get(simd, group));
        let uv = [stage.u.get(simd, group), stage.v.get(simd, group)];
        sampler.find(simd, uv, lod, &mut stage.taps, group);
        good |= stage.good.0[group] << (group * V::LEN);
    }
    sampler.blend_all::<S, V, true>(simd, &stage.taps, PLACES, &mut stage.texels.0);
    let mut kept = 0;
    for lane in 0..PLACES {
        let alpha = cutout.factor * (stage.texels.0[lane][3] * STEP);
        kept |= u64::from(alpha >= cutout.cutoff) << lane;
    }
    [kept, good]
}
