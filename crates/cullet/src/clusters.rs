//! Meshes cut into clusters: triangles that lie together, with vertices and a box of their own.
//!
//! A cluster is what is tested against the view and against what has been drawn, and what is
//! transformed at once. Triangles are put in the order of a curve that fills space and cut into runs; each keeps
//! its number in the mesh, by which ties are decided, so the cutting cannot show in a picture.

use cullet_cull::Aabb;
use cullet_raster::{MAX_TRIANGLES, MAX_VERTICES};
use cullet_scene::Mesh;
use glam::Vec3;

use crate::curve::{PIECE, along_curve};
use crate::schedule::for_each_with;

/// More threads would wait for the sort, and each has a list as long as that of vertices.
const MOST_THREADS: usize = 8;

/// The clusters of a mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clusters {
    list: Vec<Cluster>,
    /// Model-space coordinates by part of the mesh, cluster by cluster in whole groups of eight.
    positions: Vec<[Vec<f32>; 3]>,
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
    /// Of its part of the mesh.
    first_vertex: u32,
    n_vertices: u32,
    first_triangle: u32,
    pub n_triangles: u32,
    /// Model space.
    pub bounds: Aabb,
}

impl Clusters {
    /// Cuts a mesh on `threads` threads, which do not show. Triangles with a corner that is not finite are left out.
    pub fn new(mesh: &Mesh, threads: usize) -> Self {
        let ids = along_curve(mesh, threads);
        let mut corners = vec![[0; 4]; ids.len()];
        let mut parts = vec![Part::default(); ids.len().div_ceil(PIECE)];
        let n_places = threads.min(MOST_THREADS).min(parts.len()).max(1);
        let mut places = vec![Places::default(); n_places];
        let jobs = parts.iter_mut().zip(ids.chunks(PIECE)).zip(corners.chunks_mut(PIECE));
        for_each_with(&mut places, jobs.enumerate(), |places, (i, ((part, ids), corners))| {
            part.open.first_triangle = (i * PIECE) as u32;
            part.cut(mesh, ids, corners, places);
        });
        let n_not_finite = (mesh.triangles.len() - ids.len()) as u64;
        let mut out = Clusters { ids, corners, n_not_finite, ..Clusters::default() };
        for part in parts {
            out.list.extend(part.list);
            out.positions.push(part.positions);
        }
        out
    }

    /// The box around all triangles with finite corners: what can be drawn. Neither points that no
    /// triangle uses nor triangles that will be dropped may change where a camera stands.
    pub fn bounds(&self) -> Aabb {
        self.list.iter().fold(Aabb::EMPTY, |all, cluster| all.union(&cluster.bounds))
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
        let [x, y, z] = &self.positions[cluster.first_triangle as usize / PIECE];
        cullet_raster::Cluster {
            positions: [&x[vertices.clone()], &y[vertices.clone()], &z[vertices]],
            corners: &self.corners[triangles.clone()],
            ids: &self.ids[triangles],
        }
    }
}

/// So many triangles of a mesh, which one thread cuts.
#[derive(Clone, Default)]
struct Part {
    list: Vec<Cluster>,
    positions: [Vec<f32>; 3],
    open: Open,
}

/// Where the vertices of a mesh are in the clusters of a thread.
#[derive(Clone, Default)]
struct Places {
    /// By vertex: in the upper bits a number of the cluster that it is in last, in the lower eight its index there.
    of: Vec<u32>,
    next_number: u32,
}

impl Places {
    /// The list for another part of the mesh, and the first number for its clusters, which no other has had since the
    /// list was emptied. A cluster has a triangle at least, so there are numbers for all.
    fn for_part(&mut self, mesh: &Mesh) -> (&mut [u32], u32) {
        let n = PIECE as u32;
        if self.next_number + n > u32::MAX >> 8 {
            (self.of, self.next_number) = (Vec::new(), 0);
        }
        self.of.resize(mesh.positions.len(), u32::MAX);
        self.next_number += n;
        (&mut self.of, self.next_number - n)
    }
}

/// A cluster that takes more.
#[derive(Clone, Default)]
struct Open {
    vertices: Vec<Vec3>,
    first_triangle: u32,
    n_triangles: u32,
}

impl Part {
    /// Cuts the triangles `ids` and fills `corners`. The first is known to be that of the open cluster.
    fn cut(&mut self, mesh: &Mesh, ids: &[u32], corners: &mut [[u8; 4]], places: &mut Places) {
        let (places, first_number) = places.for_part(mesh);
        for (id, corners) in ids.iter().zip(corners) {
            let triangle = mesh.triangles[*id as usize];
            let mut number = first_number + self.list.len() as u32;
            let n_new = triangle.iter().filter(|i| places[**i as usize] >> 8 != number).count();
            if self.open.n_triangles as usize == MAX_TRIANGLES
                || self.open.vertices.len() + n_new > MAX_VERTICES
            {
                self.close();
                number += 1;
            }
            for (corner, i) in corners.iter_mut().zip(triangle) {
                let place = &mut places[i as usize];
                if *place >> 8 != number {
                    *place = number << 8 | self.open.vertices.len() as u32;
                    self.open.vertices.push(mesh.positions[i as usize]);
                }
                *corner = *place as u8;
            }
            self.open.n_triangles += 1;
        }
        self.close();
    }

    /// Ends a cluster.
    fn close(&mut self) {
        let Open { vertices, first_triangle, n_triangles } = &mut self.open;
        let Some(&last) = vertices.last() else { return };
        let bounds = Aabb::from_points(vertices.iter().map(|p| p.as_dvec3()));
        vertices.resize(vertices.len().next_multiple_of(8), last);
        self.list.push(Cluster {
            first_vertex: self.positions[0].len() as u32,
            n_vertices: vertices.len() as u32,
            first_triangle: *first_triangle,
            n_triangles: *n_triangles,
            bounds,
        });
        for (axis, list) in self.positions.iter_mut().enumerate() {
            list.extend(vertices.iter().map(|p| p[axis]));
        }
        vertices.clear();
        *first_triangle += *n_triangles;
        *n_triangles = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(mesh: &Mesh) {
        let clusters = Clusters::new(mesh, 1);
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
    fn no_number_is_given_twice_before_places_are_forgotten() {
        let mesh = Mesh { positions: vec![Vec3::ZERO; 3], ..Mesh::default() };
        let mut places = Places::default();
        let mut next = 0;
        for part in 0..3000 {
            let (of, first) = places.for_part(&mesh);
            if first != next {
                assert_eq!(first, 0, "{part}");
                assert!(of.iter().all(|place| *place == u32::MAX));
            }
            let last = first + PIECE as u32 - 1;
            assert!(last << 8 >> 8 == last);
            of.fill(last << 8);
            next = last + 1;
        }
    }

    #[test]
    fn threads_do_not_show() {
        let scene = cullet_scene::synth::synth("sphere:400").unwrap();
        let mesh = &scene.meshes[0];
        assert!(mesh.triangles.len() > 3 * PIECE);
        check(mesh);
        let one = Clusters::new(mesh, 1);
        for threads in [2, 5] {
            let other = Clusters::new(mesh, threads);
            assert_eq!(format!("{one:?}"), format!("{other:?}"));
        }
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
        let clusters = Clusters::new(&mesh, 1);
        assert!(clusters.list().len() <= 70);
        let size = |c: &Cluster| (c.bounds.max - c.bounds.min).max_element();
        let wide = clusters.list().iter().filter(|c| size(c) > 20.0).count();
        assert!(wide <= 4, "{wide}");
    }
}
