//! Alpha tests, eight places of a triangle at a time: [`crate::alpha`], wide.

use cullet_scene::AlphaMode;
use fearless_simd::{Simd, dispatch, f32x8};

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
    let Some(Sampled::Wide(sampler)) = &cutout.paint.texture else { return [0; 2] };
    stage.places.set_eight(places);
    let records = core::slice::from_ref(record);
    // What is there and what is not is always decided exactly.
    cutout.paint.place::<S, f32x8<S>, false>(simd, records, &[], stage, 0);
    let lod = sampler.levels::<S, f32x8<S>>(simd, stage.lod.get(simd, 0));
    let uv: [f32x8<S>; 2] = [stage.u.get(simd, 0), stage.v.get(simd, 0)];
    sampler.find(simd, uv, lod, &mut stage.taps, 0);
    sampler.blend_all::<S, f32x8<S>, true>(simd, &stage.taps, 8, &mut stage.texels.0);
    let mut kept = 0;
    for lane in 0..8 {
        let alpha = cutout.factor * (stage.texels.0[lane][3] * STEP);
        kept |= u64::from(alpha >= cutout.cutoff) << lane;
    }
    [kept, stage.good[0]]
}
