//! Meshes cut into clusters: triangles that lie together, with vertices and a box of their own.
//!
//! A cluster is what is tested against the view and against what has been drawn, and what is
//! transformed at once. Triangles are put in the order of a Morton curve through their middles
//! (Morton 1966, "A Computer Oriented Geodetic Data Base") and cut into runs; each keeps its number
//! in the mesh, by which ties are decided, so the cutting cannot show in a picture.

use cullet_cull::Aabb;
use cullet_raster::{MAX_TRIANGLES, MAX_VERTICES};
use cullet_scene::Mesh;
use glam::{DVec3, Vec3};

/// The clusters of a mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clusters {
    list: Vec<Cluster>,
    /// Model-space coordinates, cluster by cluster in whole groups of eight.
    positions: [Vec<f32>; 3],
    /// Corners by triangle, indices into the vertices of its cluster; the last is 0.
    corners: Vec<[u8; 4]>,
    /// Number of each triangle in the mesh.
    ids: Vec<u32>,
    /// Triangles in no cluster, since a corner is not finite.
    pub n_not_finite: u64,
}

/// Where the parts of a cluster are, and the box around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cluster {
    first_vertex: u32,
    n_vertices: u32,
    first_triangle: u32,
    pub n_triangles: u32,
    /// Model space.
    pub bounds: Aabb,
}

impl Clusters {
    /// Cuts a mesh. Triangles with a corner that is not finite are left out.
    pub fn new(mesh: &Mesh) -> Self {
        let corner = |i: u32| mesh.positions[i as usize];
        let finite = |t: &[u32; 3]| t.iter().all(|&i| corner(i).is_finite());
        let drawable = (0u32..).zip(&mesh.triangles).filter(|(_, t)| finite(t));
        let mut order: Vec<u64> = drawable.map(|(id, _)| u64::from(id)).collect();
        if order.len() > MAX_TRIANGLES {
            sort_by_place(mesh, &mut order);
        }
        let mut out = Clusters {
            n_not_finite: (mesh.triangles.len() - order.len()) as u64,
            ids: Vec::with_capacity(order.len()),
            corners: Vec::with_capacity(order.len()),
            ..Clusters::default()
        };
        // Per vertex of the mesh: the cluster it is in last, and its index there.
        let mut place = vec![(u32::MAX, 0u8); mesh.positions.len()];
        let mut open = Open::default();
        for id in order.into_iter().map(|entry| entry as u32) {
            let triangle = mesh.triangles[id as usize];
            let number = out.list.len() as u32;
            let n_new = triangle.iter().filter(|&&i| place[i as usize].0 != number).count();
            if open.n_triangles == MAX_TRIANGLES || open.vertices.len() + n_new > MAX_VERTICES {
                out.close(&mut open);
            }
            let number = out.list.len() as u32;
            let corners = triangle.map(|i| {
                let slot = &mut place[i as usize];
                if slot.0 != number {
                    *slot = (number, open.vertices.len() as u8);
                    open.vertices.push(corner(i));
                }
                slot.1
            });
            open.n_triangles += 1;
            out.corners.push([corners[0], corners[1], corners[2], 0]);
            out.ids.push(id);
        }
        out.close(&mut open);
        out
    }

    /// Ends a cluster.
    fn close(&mut self, open: &mut Open) {
        let Some(&last) = open.vertices.last() else { return };
        let bounds = Aabb::from_points(open.vertices.iter().map(|p| p.as_dvec3()));
        open.vertices.resize(open.vertices.len().next_multiple_of(8), last);
        self.list.push(Cluster {
            first_vertex: self.positions[0].len() as u32,
            n_vertices: open.vertices.len() as u32,
            first_triangle: (self.ids.len() - open.n_triangles) as u32,
            n_triangles: open.n_triangles as u32,
            bounds,
        });
        for (axis, list) in self.positions.iter_mut().enumerate() {
            list.extend(open.vertices.iter().map(|p| p[axis]));
        }
        open.vertices.clear();
        open.n_triangles = 0;
    }

    /// All clusters.
    pub fn list(&self) -> &[Cluster] {
        &self.list
    }

    /// How many triangles some of them have, which follow each other.
    pub fn n_triangles(&self, range: std::ops::Range<u32>) -> u64 {
        let Some(last) = range.end.checked_sub(1) else { return 0 };
        let (first, last) = (&self.list[range.start as usize], &self.list[last as usize]);
        u64::from(last.first_triangle + last.n_triangles - first.first_triangle)
    }

    /// One of them, as the rasterizer takes it.
    pub fn geometry(&self, index: usize) -> cullet_raster::Cluster<'_> {
        let cluster = &self.list[index];
        let vertices = cluster.first_vertex as usize..;
        let vertices = vertices.start..vertices.start + cluster.n_vertices as usize;
        let triangles = cluster.first_triangle as usize..;
        let triangles = triangles.start..triangles.start + cluster.n_triangles as usize;
        let [x, y, z] = &self.positions;
        cullet_raster::Cluster {
            positions: [&x[vertices.clone()], &y[vertices.clone()], &z[vertices]],
            corners: &self.corners[triangles.clone()],
            ids: &self.ids[triangles],
        }
    }
}

/// A cluster that takes more.
#[derive(Default)]
struct Open {
    vertices: Vec<Vec3>,
    n_triangles: usize,
}

/// Sorts triangles, given by number, along the curve; the keys take the upper halves.
fn sort_by_place(mesh: &Mesh, order: &mut [u64]) {
    let middle = |id: u64| {
        let corners = mesh.triangles[id as usize].map(|i| mesh.positions[i as usize].as_dvec3());
        (corners[0] + corners[1] + corners[2]) / 3.0
    };
    let bounds = Aabb::from_points(order.iter().map(|&id| middle(id)));
    let size = bounds.max - bounds.min;
    let scale = DVec3::splat(1023.0 / size.max_element().max(f64::MIN_POSITIVE));
    for entry in order.iter_mut() {
        // Within 0..1024 but for NaN of an overflow, which becomes 0: any order will do.
        let cell = (middle(*entry) - bounds.min) * scale;
        let key = spread(cell.x as u32) | spread(cell.y as u32) << 1 | spread(cell.z as u32) << 2;
        *entry |= u64::from(key) << 32;
    }
    order.sort_unstable();
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
    use super::*;

    #[track_caller]
    fn check(mesh: &Mesh) {
        let clusters = Clusters::new(mesh);
        let mut seen = vec![0; mesh.triangles.len()];
        for (i, cluster) in clusters.list().iter().enumerate() {
            let geometry = clusters.geometry(i);
            let [x, y, z] = geometry.positions;
            assert!(x.len() % 8 == 0 && x.len() <= MAX_VERTICES);
            assert!(geometry.ids.len() <= MAX_TRIANGLES && !geometry.ids.is_empty());
            assert_eq!(geometry.ids.len(), cluster.n_triangles as usize);
            for (corners, &id) in geometry.corners.iter().zip(geometry.ids) {
                seen[id as usize] += 1;
                for (corner, vertex) in mesh.triangles[id as usize].iter().zip(corners) {
                    let vertex = usize::from(*vertex);
                    let position = Vec3::new(x[vertex], y[vertex], z[vertex]);
                    assert_eq!(position, mesh.positions[*corner as usize]);
                    assert!(cluster.bounds.contains_point(position.as_dvec3()));
                }
            }
        }
        let n_finite = |t: &[u32; 3]| t.iter().all(|&i| mesh.positions[i as usize].is_finite());
        for (n, triangle) in seen.iter().zip(&mesh.triangles) {
            assert_eq!(*n, i32::from(n_finite(triangle)));
        }
        let n_seen: i32 = seen.iter().sum();
        assert_eq!(n_seen as u64 + clusters.n_not_finite, mesh.triangles.len() as u64);
    }

    #[test]
    fn every_finite_triangle_is_in_one_cluster() {
        let scene = cullet_scene::synth::synth("sphere:40").unwrap();
        scene.meshes.iter().for_each(check);
        check(&Mesh::default());
        // Triangles that share nothing, far apart, some not finite.
        let far = [1e38, -3e38, f32::NAN, f32::INFINITY, 0.0, 1e-40, -2.0];
        let positions = (0..900).map(|i| Vec3::new(far[i % 7], i as f32, far[i / 7 % 7]));
        let triangles = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        check(&Mesh { positions: positions.collect(), triangles, ..Mesh::default() });
    }

    #[test]
    fn clusters_of_a_grid_are_compact() {
        let n = 64u32;
        let at = |x: u32, y: u32| Vec3::new(x as f32, y as f32, 0.0);
        let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| at(x, y))).collect();
        let quads = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
        let triangles = quads.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        let mesh = Mesh { positions, triangles: triangles.collect(), ..Mesh::default() };
        check(&mesh);
        let clusters = Clusters::new(&mesh);
        assert!(clusters.list().len() <= 70);
        let size = |c: &Cluster| (c.bounds.max - c.bounds.min).max_element();
        let wide = clusters.list().iter().filter(|c| size(c) > 20.0).count();
        assert!(wide <= 4, "{wide}");
    }
}
