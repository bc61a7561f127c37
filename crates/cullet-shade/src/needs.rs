//! What does this material ask of a pixel?
//!
//! Asked once per mesh and material. The answer picks a kernel, and what is not in it is
//! never fetched, interpolated or even looked at.

use cullet_scene::{AlphaMode, Material, Mesh};

/// How surfaces answer light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Shading {
    /// Base colour times `A + (1 - A) max(0, N.L)`, for every kind of material.
    #[default]
    Lambert,
    /// The base colour alone.
    Unlit,
}

/// A set of things that shading needs. Which texture coordinate set it reads is not part
/// of it: that is an index in the material and costs nothing per pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Needs(pub(crate) u8);

impl Needs {
    /// The base colour factor alone.
    pub const NONE: Needs = Needs(0);
    /// The base colour texture.
    pub const TEXTURE: Needs = Needs(1);
    /// The transform of its coordinates.
    pub const UV_TRANSFORM: Needs = Needs(1 << 1);
    /// Vertex colours.
    pub const VERTEX_COLOR: Needs = Needs(1 << 2);
    /// A light and a normal, flat unless [`Needs::SMOOTH_NORMAL`].
    pub const LIT: Needs = Needs(1 << 3);
    /// Interpolated vertex normals.
    pub const SMOOTH_NORMAL: Needs = Needs(1 << 4);
    /// An alpha test decides which pixels are covered. Kernels run after it and ignore it.
    pub const MASK: Needs = Needs(1 << 5);

    /// A light at a point, that reaches the surface: see [`PointLight`](crate::PointLight). No
    /// matter of the material, so [`Needs::of`] never asks for it.
    pub const POINT_LIGHT: Needs = Needs(1 << 6);

    /// What `material` on `mesh` needs: nothing that its shading does not use.
    pub fn of(mesh: &Mesh, material: &Material, shading: Shading) -> Needs {
        let mut needs = Needs::NONE;
        if let Some(texture) = &material.base_color_texture {
            needs = needs.with(Needs::TEXTURE);
            if texture.transform.is_some() {
                needs = needs.with(Needs::UV_TRANSFORM);
            }
        }
        if mesh.colors.is_some() {
            needs = needs.with(Needs::VERTEX_COLOR);
        }
        if shading == Shading::Lambert {
            needs = needs.with(Needs::LIT);
            if mesh.normals.is_some() {
                needs = needs.with(Needs::SMOOTH_NORMAL);
            }
        }
        if matches!(material.alpha, AlphaMode::Mask { .. }) {
            needs = needs.with(Needs::MASK);
        }
        needs
    }

    /// Both sets together.
    pub const fn with(self, other: Needs) -> Needs {
        Needs(self.0 | other.0)
    }

    /// Whether all of `other` is in this set.
    pub const fn contains(self, other: Needs) -> bool {
        self.0 & other.0 == other.0
    }
}

#[cfg(test)]
mod tests {
    use cullet_scene::TextureRef;
    use glam::{Affine2, Vec3};

    use super::*;

    #[test]
    fn nothing_is_needed_that_is_not_there() {
        let (mesh, material) = (Mesh::default(), Material::default());
        assert_eq!(Needs::of(&mesh, &material, Shading::Unlit), Needs::NONE);
        assert_eq!(Needs::of(&mesh, &material, Shading::Lambert), Needs::LIT);
    }

    #[test]
    fn unlit_shading_needs_no_normals_even_when_there() {
        let mesh = Mesh { normals: Some(vec![Vec3::Y]), ..Mesh::default() };
        let lit = Needs::of(&mesh, &Material::default(), Shading::Lambert);
        assert_eq!(lit, Needs::LIT.with(Needs::SMOOTH_NORMAL));
        // Under lambert a material's kind only says where the base colour comes from.
        let unlit = Material { unlit: true, ..Material::default() };
        assert_eq!(Needs::of(&mesh, &unlit, Shading::Lambert), lit);
        assert_eq!(Needs::of(&mesh, &Material::default(), Shading::Unlit), Needs::NONE);
    }

    #[test]
    fn textures_colours_and_masks_are_seen() {
        let mesh = Mesh { colors: Some(Vec::new()), ..Mesh::default() };
        let transform = Some(Affine2::IDENTITY);
        let material = Material {
            base_color_texture: Some(TextureRef { texture: 0, uv_set: 1, transform }),
            alpha: AlphaMode::Mask { cutoff: 0.5 },
            ..Material::default()
        };
        let needs = Needs::of(&mesh, &material, Shading::Unlit);
        assert!(needs.contains(Needs::TEXTURE.with(Needs::UV_TRANSFORM)));
        assert!(needs.contains(Needs::VERTEX_COLOR.with(Needs::MASK)));
        assert!(!needs.contains(Needs::LIT));
    }
}
