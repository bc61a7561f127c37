//! Which triangles does a primitive have?

use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{Vec2, Vec3, Vec4};

use super::accessor::Accessor;
use super::{Input, Output, extensions};
use crate::{LoadError, Mesh};

/// Which rows of the accessors the vertices of a mesh are.
pub(super) enum Rows {
    /// The first so many.
    First(u64),
    /// Only those that triangles use, increasing.
    Used(Vec<u32>),
}

impl Rows {
    /// The rows in vertex order.
    pub fn iter(&self) -> Box<dyn Iterator<Item = u64> + '_> {
        match self {
            Rows::First(count) => Box::new(0..*count),
            Rows::Used(rows) => Box::new(rows.iter().map(|&row| row.into())),
        }
    }

    /// The number of vertices.
    pub fn len(&self) -> u64 {
        match self {
            Rows::First(count) => *count,
            Rows::Used(rows) => rows.len() as u64,
        }
    }

    /// How many rows an accessor must have.
    pub fn end(&self) -> u64 {
        match self {
            Rows::First(count) => *count,
            Rows::Used(rows) => rows.last().map_or(0, |&last| u64::from(last) + 1),
        }
    }

    /// Reads floats for every vertex, if the limit allows so many values of type `T`.
    fn decode_floats<const N: usize, T: From<[f32; N]>>(
        &self,
        input: &Input<'_>,
        output: &mut Output,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<T>, LoadError> {
        if let Rows::First(n) = *self
            && let Some(packed) = accessor.packed_floats::<N>(n)
        {
            output.count_decoded::<T>(input, n)?;
            return Ok(packed.iter().map(|row| T::from(row.map(f32::from_le_bytes))).collect());
        }
        self.decode(input, output, |row| T::from(accessor.row(row)))
    }

    /// Reads a value for every vertex, if the limit allows so many.
    fn decode<T>(
        &self,
        input: &Input<'_>,
        output: &mut Output,
        read: impl Fn(u64) -> T,
    ) -> Result<Vec<T>, LoadError> {
        output.count_decoded::<T>(input, self.len())?;
        Ok(self.iter().map(read).collect())
    }
}

/// Reads a primitive into a mesh without a name, which will be `posed` or drawn as it is.
/// `None`: left out, and said so.
pub(super) fn load(
    input: &Input<'_>,
    output: &mut Output,
    place: &str,
    json: &Primitive,
    posed: bool,
) -> Result<Option<(Mesh, Rows)>, LoadError> {
    refuse_compression(input, json)?;
    let Some(assembly) = Assembly::of(json) else {
        let points = matches!(json.mode, Checked::Valid(Mode::Points));
        output.leave_out(if points {
            "primitives made of points"
        } else {
            "primitives made of lines"
        });
        return Ok(None);
    };
    let Some(positions) = open_positions(input, output, place, json) else { return Ok(None) };
    let indices = match json.indices {
        None => None,
        Some(index) => match Accessor::open(&input.document.root, input.buffers, index) {
            Ok(indices) if is_index_list(&indices) => Some(indices),
            Ok(_) => {
                output.lose(place, "indices are not unsigned integers");
                return Ok(None);
            }
            Err(problem) => {
                output.lose(place, &format!("indices cannot be read: {problem}"));
                return Ok(None);
            }
        },
    };
    let is_without_data = |accessor: &Accessor<'_>| accessor.is_without_data();
    if indices.as_ref().is_some_and(is_without_data) || (!posed && is_without_data(&positions)) {
        output.warn(place, "has all its corners in one point, for lack of data; left out");
        return Ok(None);
    }
    // The largest value of an index type is reserved (it restarts strips elsewhere).
    let n_valid = match indices.as_ref().map(|indices| indices.component) {
        Some(ComponentType::U8) => positions.count.min(u8::MAX.into()),
        Some(ComponentType::U16) => positions.count.min(u16::MAX.into()),
        _ => positions.count,
    };
    let n_corners = indices.as_ref().map_or(positions.count, |indices| indices.count);
    let n_triangles = assembly.n_triangles(n_corners);
    count_triangles(input, output, n_triangles)?;
    output.count_decoded::<[u32; 3]>(input, n_triangles)?;
    let packed = match (&indices, assembly) {
        (Some(indices), Assembly::List) => packed_triangles(indices, n_valid),
        _ => None,
    };
    let mut triangles =
        packed.unwrap_or_else(|| assembly.triangles(n_triangles, indices.as_ref(), n_valid));
    warn_about_triangles(output, place, assembly, n_corners, n_triangles - triangles.len() as u64);
    if triangles.is_empty() {
        if n_triangles > 0 {
            output.lose(place, "all indices are out of range");
        }
        return Ok(None);
    }
    let rows = choose_rows(positions.count, &mut triangles);
    let mut mesh = Mesh { triangles, ..Mesh::default() };
    mesh.positions = rows.decode_floats::<3, Vec3>(input, output, &positions)?;
    load_attributes(input, output, place, json, &rows, positions.count, &mut mesh)?;
    Ok(Some((mesh, rows)))
}

/// Neither points nor lines.
pub(super) fn is_made_of_triangles(json: &Primitive) -> bool {
    Assembly::of(json).is_some()
}

/// Without its extension, a compressed primitive would be drawn as zeros.
fn refuse_compression(input: &Input<'_>, json: &Primitive) -> Result<(), LoadError> {
    let extension = json.extensions.as_ref().and_then(|all| all.others.get(extensions::DRACO));
    let positions = json.attributes.get(&Checked::Valid(Semantic::Positions));
    let has_fallback = positions
        .and_then(|&index| input.document.root.get(index))
        .is_some_and(|accessor| accessor.buffer_view.is_some());
    if extension.is_some() && !has_fallback {
        return Err(extensions::unsupported(input.name, extensions::DRACO));
    }
    Ok(())
}

/// How corners become triangles.
#[derive(Clone, Copy, PartialEq)]
enum Assembly {
    List,
    Strip,
    Fan,
}

impl Assembly {
    /// `None`: not triangles.
    fn of(json: &Primitive) -> Option<Assembly> {
        match json.mode {
            Checked::Valid(Mode::Triangles) => Some(Assembly::List),
            Checked::Valid(Mode::TriangleStrip) => Some(Assembly::Strip),
            Checked::Valid(Mode::TriangleFan) => Some(Assembly::Fan),
            _ => None,
        }
    }

    fn n_triangles(self, n_corners: u64) -> u64 {
        match self {
            Assembly::List => n_corners / 3,
            Assembly::Strip | Assembly::Fan => n_corners.saturating_sub(2),
        }
    }

    /// The triangles all of whose corners are below `n_valid`.
    fn triangles(
        self,
        n_triangles: u64,
        indices: Option<&Accessor<'_>>,
        n_valid: u64,
    ) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(n_triangles as usize);
        for i in 0..n_triangles {
            let corners = self.corners(i).map(|corner| match indices {
                Some(indices) => indices.integer(corner).into(),
                None => corner,
            });
            if corners.iter().all(|&corner| corner < n_valid) {
                triangles.push(corners.map(|corner| corner as u32));
            }
        }
        triangles
    }

    /// The three corners of triangle `i`, wound as the format says.
    fn corners(self, i: u64) -> [u64; 3] {
        match self {
            Assembly::List => [3 * i, 3 * i + 1, 3 * i + 2],
            Assembly::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Assembly::Fan => [i + 1, i + 2, 0],
        }
    }
}

/// [`Assembly::triangles`] of a list whose indices stand side by side; `None` where they do not.
fn packed_triangles(indices: &Accessor<'_>, n_valid: u64) -> Option<Vec<[u32; 3]>> {
    let narrow = |corner: [u8; 2]| u32::from(u16::from_le_bytes(corner));
    let mut triangles: Vec<[u32; 3]> = match indices.component {
        ComponentType::U16 => {
            indices.packed_integers::<2, 3>()?.iter().map(|corners| corners.map(narrow)).collect()
        }
        ComponentType::U32 => {
            let triangles = indices.packed_integers::<4, 3>()?.iter();
            triangles.map(|corners| corners.map(u32::from_le_bytes)).collect()
        }
        _ => return None,
    };
    let largest = triangles.as_flattened().iter().fold(0, |largest: u32, &i| largest.max(i));
    if u64::from(largest) >= n_valid {
        triangles.retain(|corners| corners.iter().all(|&corner| u64::from(corner) < n_valid));
    }
    Some(triangles)
}

fn open_positions<'a>(
    input: &Input<'a>,
    output: &mut Output,
    place: &str,
    json: &Primitive,
) -> Option<Accessor<'a>> {
    let Some(&index) = json.attributes.get(&Checked::Valid(Semantic::Positions)) else {
        output.lose(place, "has no positions");
        return None;
    };
    match Accessor::open(&input.document.root, input.buffers, index) {
        Ok(positions) if positions.shape != Type::Vec3 => {
            output.lose(place, "positions do not have three components");
        }
        Ok(positions) if positions.count > u64::from(u32::MAX) => {
            output.lose(place, "has more vertices than indices can count");
        }
        Ok(positions) => return Some(positions),
        Err(problem) => output.lose(place, &format!("positions cannot be read: {problem}")),
    }
    None
}

fn is_index_list(indices: &Accessor<'_>) -> bool {
    let unsigned =
        matches!(indices.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
    unsigned && indices.shape == Type::Scalar
}

fn count_triangles(input: &Input<'_>, output: &mut Output, more: u64) -> Result<(), LoadError> {
    output.n_triangles = output.n_triangles.saturating_add(more);
    if output.n_triangles <= input.options.max_triangles {
        return Ok(());
    }
    Err(LoadError::Limit {
        path: input.name.to_string(),
        what: "the number of triangles".into(),
        limit: input.options.max_triangles,
        option: "--max-triangles",
    })
}

fn warn_about_triangles(
    output: &mut Output,
    place: &str,
    assembly: Assembly,
    n_corners: u64,
    n_dropped: u64,
) {
    if n_dropped > 0 {
        let problem = format!("{n_dropped} triangles have an index out of range; left out");
        output.warn(place, problem);
    }
    if n_corners < 3 {
        output.warn(place, format_args!("has {n_corners} corners and so no triangle; left out"));
    } else if assembly == Assembly::List && !n_corners.is_multiple_of(3) {
        output.warn(place, "ends within a triangle; the rest of it is left out");
    }
}

/// Many primitives may share one large vertex list: each then keeps only its own part.
fn choose_rows(n_rows: u64, triangles: &mut [[u32; 3]]) -> Rows {
    if n_rows <= 3 * triangles.len() as u64 {
        return Rows::First(n_rows);
    }
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    for corner in triangles.as_flattened_mut() {
        // Every corner is in the list that was made of them.
        *corner = used.partition_point(|row| row < corner) as u32;
    }
    Rows::Used(used)
}

fn load_attributes(
    input: &Input<'_>,
    output: &mut Output,
    place: &str,
    json: &Primitive,
    rows: &Rows,
    n_rows: u64,
    mesh: &mut Mesh,
) -> Result<(), LoadError> {
    let mut open = |semantic: Semantic, shapes: &[Type]| {
        open_optional(input, output, place, json, semantic, shapes, n_rows)
    };
    let normals = open(Semantic::Normals, &[Type::Vec3]);
    let uvs = [0, 1].map(|set| open(Semantic::TexCoords(set), &[Type::Vec2]));
    let colors = open(Semantic::Colors(0), &[Type::Vec3, Type::Vec4]);

    if let Some(normals) = normals {
        mesh.normals = Some(rows.decode_floats::<3, Vec3>(input, output, &normals)?);
        mend_normals(output, place, mesh);
    }
    for (decoded, uvs) in mesh.uvs.iter_mut().zip(uvs) {
        let Some(uvs) = uvs else { continue };
        *decoded = Some(rows.decode_floats::<2, Vec2>(input, output, &uvs)?);
    }
    if let Some(colors) = colors {
        mesh.colors = Some(rows.decode(input, output, |row| color(&colors, row))?);
    }
    Ok(())
}

/// Opens an attribute that a mesh can do without. A bad one counts as missing.
pub(super) fn open_optional<'a>(
    input: &Input<'a>,
    output: &mut Output,
    place: &str,
    json: &Primitive,
    semantic: Semantic,
    shapes: &[Type],
    n_rows: u64,
) -> Option<Accessor<'a>> {
    let what = semantic.to_string();
    let &index = json.attributes.get(&Checked::Valid(semantic))?;
    let problem = match Accessor::open(&input.document.root, input.buffers, index) {
        Ok(accessor) if !shapes.contains(&accessor.shape) => "has a wrong type".into(),
        Ok(accessor) if accessor.count < n_rows => "has fewer rows than POSITION".into(),
        Ok(accessor) => return Some(accessor),
        Err(problem) => problem,
    };
    output.warn(place, format_args!("{what} {problem}; left out"));
    None
}

/// Integers are always fractions here, whether the file says so or not. Three components
/// have alpha 1.
fn color(colors: &Accessor<'_>, row: u64) -> Vec4 {
    let mut color = Vec4::from_array(colors.fractions(row));
    if colors.shape == Type::Vec3 {
        color.w = 1.0;
    }
    if color.is_finite() { color } else { Vec4::ONE }
}

/// Normals without a direction become the mean of the faces around them, weighted by area.
fn mend_normals(output: &mut Output, place: &str, mesh: &mut Mesh) {
    let Some(normals) = &mut mesh.normals else { return };
    let is_bad = |normal: &Vec3| !normal.is_finite() || *normal == Vec3::ZERO;
    let n_bad = normals.iter().filter(|normal| is_bad(normal)).count();
    if n_bad == 0 {
        return;
    }
    output.warn(place, format_args!("{n_bad} normals have no direction; computed from faces"));
    let bad: Vec<bool> = normals.iter().map(is_bad).collect();
    for (normal, _) in normals.iter_mut().zip(&bad).filter(|pair| *pair.1) {
        *normal = Vec3::ZERO;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
        let face = (b - a).cross(c - a);
        if !face.is_finite() {
            continue;
        }
        for corner in triangle.map(|corner| corner as usize).into_iter().filter(|&i| bad[i]) {
            normals[corner] += face;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let triangles = |assembly: Assembly, n: u64| -> Vec<[u64; 3]> {
            (0..assembly.n_triangles(n)).map(|i| assembly.corners(i)).collect()
        };
        assert_eq!(triangles(Assembly::List, 7), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(triangles(Assembly::Strip, 5), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(triangles(Assembly::Fan, 5), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        assert!(triangles(Assembly::Strip, 1).is_empty());
    }

    #[test]
    fn a_small_part_of_a_large_vertex_list_is_cut_out() {
        let mut triangles = [[5, 900, 5], [7, 900, 5]];
        let rows = choose_rows(1000, &mut triangles);
        assert_eq!(rows.iter().collect::<Vec<_>>(), [5, 7, 900]);
        assert_eq!((rows.len(), rows.end()), (3, 901));
        assert_eq!(triangles, [[0, 2, 0], [1, 2, 0]]);
    }
}
