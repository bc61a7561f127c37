//! The order of triangles in which neighbours in space are near each other: along a Morton curve through their middles
//! (Morton 1966, "A Computer Oriented Geodetic Data Base").

use cullet_cull::Aabb;
use cullet_scene::Mesh;
use glam::DVec3;

use crate::schedule::for_each;

/// Triangles of a part of a mesh, which one thread looks at.
pub(crate) const PIECE: usize = 1 << 14;

/// No triangle: after all others.
const NONE: u64 = u64::MAX;

/// The numbers of the triangles whose corners are all finite, in the order of the curve. `threads` do not show.
pub(crate) fn along_curve(mesh: &Mesh, threads: usize) -> Vec<u32> {
    let pieces = || mesh.triangles.chunks(PIECE);
    let mut boxes = vec![Aabb::EMPTY; pieces().len()];
    for_each(threads, boxes.iter_mut().zip(pieces()), |(bounds, triangles)| {
        *bounds = Aabb::from_points(triangles.iter().filter_map(|t| middle(mesh, t)));
    });
    let bounds = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds));
    let size = bounds.max - bounds.min;
    let scale = DVec3::splat(1023.0 / size.max_element().max(f64::MIN_POSITIVE));
    // The keys take the upper halves, the numbers, by which ties are decided, the lower.
    let mut entries = vec![NONE; mesh.triangles.len()];
    let jobs = entries.chunks_mut(PIECE).zip(pieces()).enumerate();
    for_each(threads, jobs, |(piece, (entries, triangles))| {
        for (i, (entry, triangle)) in entries.iter_mut().zip(triangles).enumerate() {
            if let Some(middle) = middle(mesh, triangle) {
                let number = (piece * PIECE + i) as u64;
                *entry = u64::from(key((middle - bounds.min) * scale)) << 32 | number;
            }
        }
    });
    entries.sort_unstable();
    entries.truncate(entries.partition_point(|entry| *entry != NONE));
    entries.into_iter().map(|entry| entry as u32).collect()
}

/// The middle of a triangle whose corners are finite.
fn middle(mesh: &Mesh, triangle: &[u32; 3]) -> Option<DVec3> {
    let [a, b, c] = *triangle;
    let [a, b, c] =
        [mesh.positions[a as usize], mesh.positions[b as usize], mesh.positions[c as usize]];
    let is_finite = a.is_finite() && b.is_finite() && c.is_finite();
    is_finite.then(|| (a.as_dvec3() + b.as_dvec3() + c.as_dvec3()) * (1.0 / 3.0))
}

/// Where a cell is on the curve. Within 0..1024 but for NaN of an overflow, which becomes 0: any order will do.
fn key(cell: DVec3) -> u32 {
    spread(cell.x as u32) | spread(cell.y as u32) << 1 | spread(cell.z as u32) << 2
}

/// Ten bits with two zeros between any two.
fn spread(bits: u32) -> u32 {
    let bits = bits & 0x3ff;
    let bits = (bits | bits << 16) & 0x0300_00ff;
    let bits = (bits | bits << 8) & 0x0300_f00f;
    let bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn neighbours_follow_each_other_and_what_is_not_finite_is_left_out() {
        // Triangles along x, in no order; every tenth has a corner that is no number.
        let n = 1000_u32;
        let place = |i: u32| (i * 617 % n) as f32;
        let x = |i: u32| if i % 10 == 3 { f32::NAN } else { place(i) };
        let corners = |i| [Vec3::new(x(i), 0.0, 0.0), Vec3::new(place(i), 1.0, 0.0), Vec3::ZERO];
        let positions: Vec<Vec3> = (0..n).flat_map(corners).collect();
        let triangles = (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let order = along_curve(&mesh, 1);
        assert_eq!(order.len() as u32, n - n / 10);
        assert!(order.iter().all(|i| i % 10 != 3));
        assert!(order.is_sorted_by_key(|i| place(*i) as u32));
        assert!(along_curve(&Mesh::default(), 1).is_empty());
    }
}
