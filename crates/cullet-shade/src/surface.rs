//! A mesh in the world, and what can be read off it at a fragment.
//!
//! Attributes are interpolated as `a * wa + b * wb + c * wc`, left to right. Normals leave
//! model space through the cofactor matrix, which needs no inverse and so serves singular
//! transforms too; times the sign of the determinant, it keeps outward outward when an
//! object is mirrored.
//!
//! Source: Lengyel, "Foundations of Game Engine Development", volume 1, 2016, section 3.2
//! (normals transform by the cofactor matrix).

use std::ops::{Add, Mul};

use cullet_raster::Fragment;
use cullet_scene::{Material, Mesh};
use glam::{DAffine3, DMat3, DVec3, Mat3, Vec2, Vec3};

use crate::select::max;
use crate::texture::Texture;

/// A mesh with its material, placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Corners given to functions of this crate index its vertex lists.
    pub mesh: &'a Mesh,
    /// What it looks like.
    pub material: &'a Material,
    /// The base colour texture of the material; `None` counts as white.
    pub texture: Option<&'a Texture>,
    /// Model to world.
    pub world_from_model: DAffine3,
    /// Model to world for normals, up to length: see [`normal_matrix`].
    pub normal_world_from_model: Mat3,
}

impl<'a> Surface<'a> {
    /// Places a mesh in the world; the normal matrix follows from the transform.
    pub fn new(
        mesh: &'a Mesh,
        material: &'a Material,
        texture: Option<&'a Texture>,
        world_from_model: DAffine3,
    ) -> Self {
        let normal_world_from_model = normal_matrix(&world_from_model);
        Surface { mesh, material, texture, world_from_model, normal_world_from_model }
    }
}

/// Takes outward normals from model to world space, up to a positive factor.
///
/// The cofactor matrix times the sign of the determinant (+1 when that is 0), scaled to a
/// largest entry of magnitude 1: scales from 1e-30 to 1e30 and singular matrices give
/// finite entries. Zero when the transform leaves no plane (rank below 2) or is not finite.
pub fn normal_matrix(world_from_model: &DAffine3) -> Mat3 {
    let cofactor = cofactor_matrix(world_from_model);
    let sign = if mirrors(world_from_model) { -1.0 } else { 1.0 };
    (scaled_to_one(cofactor) * sign).as_mat3()
}

/// Whether the transform turns counter-clockwise triangles clockwise: a determinant below 0, and
/// not by rounding alone. A product of rotations and a flat scale has one of either sign, some
/// 1e-16 of the product of its columns' lengths; flat nodes are not mirrored.
pub fn mirrors(world_from_model: &DAffine3) -> bool {
    const NOISE: f64 = 1e-14;
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = scaled_to_one(world_from_model.matrix3);
    let largest = (x.dot(x) * y.dot(y) * z.dot(z)).sqrt();
    x.dot(y.cross(z)) < -NOISE * largest
}

/// Of the transform scaled to a largest entry of 1, so that products stay in range.
fn cofactor_matrix(world_from_model: &DAffine3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = scaled_to_one(world_from_model.matrix3);
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

/// Divides by the largest magnitude; zero if that is 0, or if an entry is not finite.
fn scaled_to_one(matrix: DMat3) -> DMat3 {
    let entries = matrix.to_cols_array();
    let largest = entries.into_iter().fold(0.0, |largest, entry| max(entry.abs(), largest));
    if matrix.is_finite() && largest > 0.0 {
        DMat3::from_cols_array(&entries.map(|entry| entry / largest))
    } else {
        DMat3::ZERO
    }
}

/// Unit normal in world space on the side seen: outward on front faces, inward on back.
///
/// Smooth where the mesh has normals and they add up to a direction, else flat. The zero
/// vector where there is no flat one either: zero-area, NaN or flattened triangles.
pub fn world_normal(
    surface: &Surface<'_>,
    corners: [u32; 3],
    front: bool,
    fragment: &Fragment,
) -> Vec3 {
    let normals = surface.mesh.normals.as_deref().map(|normals| gather(normals, corners));
    let outward = outward_normal(surface, corners, normals, fragment.weights.as_vec3());
    if front { outward } else { -outward }
}

/// Texture coordinates of set 0 as in the file, untransformed; zero if the mesh has none.
pub fn uv(surface: &Surface<'_>, corners: [u32; 3], fragment: &Fragment) -> Vec2 {
    interpolate(corner_uvs(surface, corners, 0), fragment.weights.as_vec3())
}

/// Place in world space: computed in f64, rounded once.
pub fn world_position(surface: &Surface<'_>, corners: [u32; 3], fragment: &Fragment) -> Vec3 {
    let [a, b, c] = gather(&surface.mesh.positions, corners).map(|corner| corner.as_dvec3());
    let weights = fragment.weights;
    let position = a * weights.x + b * weights.y + c * weights.z;
    surface.world_from_model.transform_point3(position).as_vec3()
}

/// The values of a triangle's corners.
pub(crate) fn gather<T: Copy>(values: &[T], corners: [u32; 3]) -> [T; 3] {
    corners.map(|corner| values[corner as usize])
}

/// Corner values blended by weights, or by their derivatives.
#[inline(always)]
pub(crate) fn interpolate<T>([a, b, c]: [T; 3], weights: Vec3) -> T
where
    T: Mul<f32, Output = T> + Add<Output = T>,
{
    a * weights.x + b * weights.y + c * weights.z
}

/// Zero if the mesh lacks the set.
pub(crate) fn corner_uvs(surface: &Surface<'_>, corners: [u32; 3], set: usize) -> [Vec2; 3] {
    match surface.mesh.uvs.get(set) {
        Some(Some(uvs)) => gather(uvs, corners),
        _ => [Vec2::ZERO; 3],
    }
}

/// From corner normals, if given and good, else from the triangle.
#[inline(always)]
pub(crate) fn outward_normal(
    surface: &Surface<'_>,
    corners: [u32; 3],
    normals: Option<[Vec3; 3]>,
    weights: Vec3,
) -> Vec3 {
    normals
        .and_then(|normals| {
            let normal_model = interpolate(normals, weights);
            direction(surface.normal_world_from_model * normal_model)
        })
        .unwrap_or_else(|| flat_normal(surface, corners))
}

/// Unit outward normal of the triangle in world space, or zero if it has none.
pub(crate) fn flat_normal(surface: &Surface<'_>, corners: [u32; 3]) -> Vec3 {
    // In f64 no product of finite f32 differences overflows or vanishes.
    let [a, b, c] = gather(&surface.mesh.positions, corners).map(|corner| corner.as_dvec3());
    let normal_model: DVec3 = (b - a).cross(c - a);
    let length = normal_model.dot(normal_model).sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return Vec3::ZERO;
    }
    let normal_world = surface.normal_world_from_model * (normal_model / length).as_vec3();
    direction(normal_world).unwrap_or(Vec3::ZERO)
}

/// Unit vector along `v` of any finite length but zero.
fn direction(v: Vec3) -> Option<Vec3> {
    let length2 = v.dot(v);
    let squares_are_safe = length2 > 1e-30 && length2 < 1e30;
    if squares_are_safe {
        return Some(v / length2.sqrt());
    }
    let largest = max(max(v.x.abs(), v.y.abs()), v.z.abs());
    let has_direction = v.is_finite() && largest > 0.0;
    has_direction.then(|| v / largest).map(|v| v / v.dot(v).sqrt())
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    const CORNERS: [u32; 3] = [0, 1, 2];
    const MIDDLE: Fragment =
        Fragment { weights: DVec3::new(0.25, 0.25, 0.5), ddx: Vec3::ZERO, ddy: Vec3::ZERO };

    /// Counter-clockwise seen from +z.
    fn triangle() -> Mesh {
        Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], ..Mesh::default() }
    }

    fn scale(x: f64, y: f64, z: f64) -> DAffine3 {
        DAffine3::from_scale(DVec3::new(x, y, z))
    }

    #[track_caller]
    fn check_normal(mesh: &Mesh, transform: DAffine3, front: bool, expected: Vec3) {
        let material = Material::default();
        let surface = Surface::new(mesh, &material, None, transform);
        let normal = world_normal(&surface, CORNERS, front, &MIDDLE);
        assert!((normal - expected).length() < 1e-6, "{normal} is not {expected}");
    }

    #[test]
    fn flat_normals_point_outward_at_every_scale() {
        for exponent in [-30, -20, -6, 0, 6, 20, 30] {
            let s = 10_f64.powi(exponent);
            check_normal(&triangle(), scale(s, s, s), true, Vec3::Z);
            check_normal(&triangle(), scale(s, s, s), false, Vec3::NEG_Z);
            check_normal(&triangle(), scale(s, 1.0, 1.0), true, Vec3::Z);
        }
    }

    #[test]
    fn mirrored_is_as_baked() {
        // Mirroring in x leaves this triangle's outward side where it was.
        check_normal(&triangle(), scale(-1.0, 1.0, 1.0), true, Vec3::Z);
        check_normal(&triangle(), scale(1.0, 1.0, -1.0), true, Vec3::NEG_Z);
        let smooth = Mesh { normals: Some(vec![Vec3::X; 3]), ..triangle() };
        check_normal(&smooth, scale(-1.0, 1.0, 1.0), true, Vec3::NEG_X);
        assert!(mirrors(&scale(-1e-30, 1e-30, 1e-30)));
        assert!(!mirrors(&scale(-1e30, -1e30, 1e30)));
        assert!(!mirrors(&scale(-1.0, 1.0, 0.0)));
    }

    #[test]
    fn normals_stay_perpendicular_under_stretching() {
        let turned = DQuat::from_rotation_x(0.5) * DQuat::from_rotation_y(0.3);
        let transform = scale(3.0, 0.5, 1.0) * DAffine3::from_quat(turned);
        let material = Material::default();
        let mesh = triangle();
        let surface = Surface::new(&mesh, &material, None, transform);
        let normal = world_normal(&surface, CORNERS, true, &MIDDLE).as_dvec3();
        for edge in [DVec3::X, DVec3::Y] {
            assert!(normal.dot(transform.transform_vector3(edge)).abs() < 1e-6);
        }
    }

    #[test]
    fn singular_transforms_give_finite_normals() {
        check_normal(&triangle(), scale(1.0, 1.0, 0.0), true, Vec3::Z);
        check_normal(&triangle(), scale(0.0, 1.0, 1.0), true, Vec3::ZERO);
        check_normal(&triangle(), scale(0.0, 0.0, 1.0), true, Vec3::ZERO);
        check_normal(&triangle(), scale(0.0, 0.0, 0.0), true, Vec3::ZERO);
        check_normal(&triangle(), scale(f64::NAN, 1.0, 1.0), true, Vec3::ZERO);
    }

    #[test]
    fn normals_of_any_length_are_normalised() {
        for length in [1e-44, 1e-30, 1e-10, 5.0, 1e25, 1e38] {
            let mesh = Mesh { normals: Some(vec![Vec3::X * length; 3]), ..triangle() };
            check_normal(&mesh, DAffine3::IDENTITY, true, Vec3::X);
        }
    }

    #[test]
    fn bad_normals_fall_back_to_flat_and_then_to_zero() {
        let opposed = vec![Vec3::X, Vec3::X, Vec3::NEG_X];
        for normals in [vec![Vec3::ZERO; 3], vec![Vec3::NAN; 3], vec![Vec3::INFINITY; 3], opposed] {
            let mesh = Mesh { normals: Some(normals.clone()), ..triangle() };
            check_normal(&mesh, DAffine3::IDENTITY, true, Vec3::Z);
            let point = Mesh { positions: vec![Vec3::ONE; 3], ..mesh };
            check_normal(&point, DAffine3::IDENTITY, true, Vec3::ZERO);
        }
    }

    #[test]
    fn flat_normals_of_huge_and_tiny_triangles() {
        for size in [1e-44, 1e-30, 1e38] {
            let positions = triangle().positions.iter().map(|&p| p * size).collect();
            let mesh = Mesh { positions, ..Mesh::default() };
            check_normal(&mesh, DAffine3::IDENTITY, true, Vec3::Z);
        }
    }

    #[test]
    fn positions_and_coordinates_are_interpolated() {
        let mesh = Mesh { uvs: [Some(vec![Vec2::ZERO, Vec2::X, Vec2::Y]), None], ..triangle() };
        let material = Material::default();
        let far = DAffine3::from_translation(DVec3::splat(1e6));
        let surface = Surface::new(&mesh, &material, None, far);
        assert_eq!(uv(&surface, CORNERS, &MIDDLE), Vec2::new(0.25, 0.5));
        let expected = Vec3::new(1_000_000.25, 1_000_000.5, 1e6);
        assert_eq!(world_position(&surface, CORNERS, &MIDDLE), expected);
        let bare = triangle();
        let surface = Surface::new(&bare, &material, None, far);
        assert_eq!(uv(&surface, CORNERS, &MIDDLE), Vec2::ZERO);
    }
}
