//! What numbers does an accessor stand for?
//!
//! All component types, normalized or not, interleaved, sparse, or without data (zeros).
//! Opening checks once that every row lies within its bytes, in arithmetic that cannot
//! overflow, and allocates nothing that grows with a number the file merely claims.

use ::gltf::json::accessor::{Accessor as AccessorJson, ComponentType, Type};
use ::gltf::json::buffer::View;
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, Root};
use std::borrow::Cow;

/// A readable accessor. `N` in its methods is the number of components wanted of a row.
#[derive(Debug)]
pub(super) struct Accessor<'a> {
    /// Rows. Without a buffer view this is only what the file claims.
    pub count: u64,
    /// What a row is.
    pub shape: Type,
    /// What a component is.
    pub component: ComponentType,
    normalized: bool,
    /// `None`: zeros.
    rows: Option<Rows<'a>>,
    /// Rows that differ, by increasing row number, and what stands there instead.
    replaced: Vec<u32>,
    replacements: Option<Rows<'a>>,
}

/// Equally spaced rows, all within `bytes`.
#[derive(Clone, Copy, Debug)]
struct Rows<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Accessor<'a> {
    /// Opens an accessor; the error says what is wrong with it.
    pub fn open(
        root: &Root,
        buffers: &'a [Cow<'_, [u8]>],
        index: Index<AccessorJson>,
    ) -> Result<Accessor<'a>, String> {
        let place = |problem: String| format!("accessor {}: {problem}", index.value());
        open(root, buffers, index).map_err(place)
    }

    /// Nothing stands in the file: all rows are zero.
    pub fn is_without_data(&self) -> bool {
        self.rows.is_none() && self.replaced.is_empty()
    }

    /// Row `i` as numbers: normalized integers become 0..1 or -1..1, components that the
    /// accessor lacks are 0. `i` must be below [`Self::count`].
    pub fn row<const N: usize>(&self, i: u64) -> [f32; N] {
        self.numbers(i, self.normalized)
    }

    /// Like [`Self::row`], with integers taken as normalized whatever the file says.
    pub fn fractions<const N: usize>(&self, i: u64) -> [f32; N] {
        self.numbers(i, true)
    }

    /// [`Self::row`] of the first `n` rows, where they stand in the file just as in memory: floats,
    /// side by side, none replaced. `None` where they do not.
    pub fn packed_floats<const N: usize>(&self, n: u64) -> Option<&'a [[[u8; 4]; N]]> {
        let is_plain = self.component == ComponentType::F32 && self.shape.multiplicity() == N;
        if is_plain { self.packed(n) } else { None }
    }

    /// [`Self::integer`] of all rows as bytes, `N` at a time and without those left at the end,
    /// where they stand side by side, `SIZE` bytes each, none replaced. `None` where they do not.
    pub fn packed_integers<const SIZE: usize, const N: usize>(
        &self,
    ) -> Option<&'a [[[u8; SIZE]; N]]> {
        let is_plain = self.component.size() == SIZE && self.shape == Type::Scalar;
        if is_plain { self.packed(self.count / N as u64) } else { None }
    }

    /// The first `n` times `N` times `SIZE` bytes, if they are rows without gaps.
    fn packed<const SIZE: usize, const N: usize>(&self, n: u64) -> Option<&'a [[[u8; SIZE]; N]]> {
        let rows = self.rows.filter(|_| self.replacements.is_none())?;
        let size = self.component.size() * self.shape.multiplicity();
        if rows.stride != size {
            return None;
        }
        rows.bytes.as_chunks().0.as_chunks().0.get(..usize::try_from(n).ok()?)
    }

    fn numbers<const N: usize>(&self, i: u64, normalized: bool) -> [f32; N] {
        let mut row = [0.0; N];
        if let Some(bytes) = self.row_bytes(i) {
            let size = self.component.size();
            for (value, bytes) in row.iter_mut().zip(bytes.chunks_exact(size)) {
                *value = number(bytes, self.component, normalized);
            }
        }
        row
    }

    /// The first component of row `i` as an unsigned integer; 0 for other types.
    pub fn integer(&self, i: u64) -> u32 {
        self.integers::<1>(i)[0]
    }

    /// Row `i` as unsigned integers; 0 for other types.
    pub fn integers<const N: usize>(&self, i: u64) -> [u32; N] {
        let mut row = [0; N];
        if let Some(bytes) = self.row_bytes(i) {
            let size = self.component.size();
            for (value, bytes) in row.iter_mut().zip(bytes.chunks_exact(size)) {
                *value = unsigned(bytes);
            }
        }
        row
    }

    fn row_bytes(&self, i: u64) -> Option<&'a [u8]> {
        let size = self.component.size() * self.shape.multiplicity();
        if let Some(replacements) = self.replacements
            && let Ok(row) = u32::try_from(i)
            && let Ok(found) = self.replaced.binary_search(&row)
        {
            return replacements.get(found, size);
        }
        self.rows?.get(usize::try_from(i).ok()?, size)
    }
}

impl<'a> Rows<'a> {
    fn get(&self, i: usize, size: usize) -> Option<&'a [u8]> {
        let start = i.checked_mul(self.stride)?;
        self.bytes.get(start..start.checked_add(size)?)
    }
}

fn open<'a>(
    root: &Root,
    buffers: &'a [Cow<'_, [u8]>],
    index: Index<AccessorJson>,
) -> Result<Accessor<'a>, String> {
    let json = root.get(index).ok_or("does not exist")?;
    let (Checked::Valid(component), Checked::Valid(shape)) = (json.component_type, json.type_)
    else {
        return Err("has an unknown type".into());
    };
    let size = component.0.size() * shape.multiplicity();
    let count = json.count.0;
    let rows = match json.buffer_view {
        None => None,
        Some(view) => {
            let offset = json.byte_offset.unwrap_or_default().0;
            Some(rows(root, buffers, view, offset, count, size)?)
        }
    };
    let mut accessor = Accessor {
        count,
        shape,
        component: component.0,
        normalized: json.normalized,
        rows,
        replaced: Vec::new(),
        replacements: None,
    };
    if let Some(sparse) = &json.sparse {
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err("has sparse indices of an unknown type".into());
        };
        let (n_sparse, offset) = (sparse.count.0, sparse.indices.byte_offset.0);
        let size_of_index = component.0.size();
        let indices =
            self::rows(root, buffers, sparse.indices.buffer_view, offset, n_sparse, size_of_index)?;
        let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset.0);
        accessor.replacements = Some(self::rows(root, buffers, view, offset, n_sparse, size)?);
        accessor.replaced = (0..n_sparse as usize)
            .filter_map(|i| indices.get(i, size_of_index))
            .map(unsigned)
            .collect();
        let increasing = accessor.replaced.is_sorted_by(|a, b| a < b);
        let in_range = accessor.replaced.last().is_none_or(|&last| u64::from(last) < count);
        if !increasing || !in_range {
            return Err("has sparse indices out of order or out of range".into());
        }
    }
    Ok(accessor)
}

/// `count` rows of `size` bytes, checked against the view and the buffer.
fn rows<'a>(
    root: &Root,
    buffers: &'a [Cow<'_, [u8]>],
    view: Index<View>,
    offset: u64,
    count: u64,
    size: usize,
) -> Result<Rows<'a>, String> {
    let stride = root.get(view).and_then(|view| view.byte_stride).map_or(size, |stride| stride.0);
    if stride < size {
        return Err(format!("has a stride of {stride} bytes for rows of {size}"));
    }
    let bytes = view_bytes(root, buffers, view)?;
    let last = count.saturating_sub(1);
    let end = last
        .checked_mul(stride as u64)
        .and_then(|last| last.checked_add(offset)?.checked_add(size as u64));
    if count == 0 {
        return Ok(Rows { bytes: &[], stride });
    }
    if end.is_none_or(|end| end > bytes.len() as u64) {
        return Err(format!("reaches beyond buffer view {}", view.value()));
    }
    Ok(Rows { bytes: &bytes[offset as usize..], stride })
}

/// The bytes of a buffer view, as many as the buffer really has.
pub(super) fn view_bytes<'a>(
    root: &Root,
    buffers: &'a [Cow<'_, [u8]>],
    index: Index<View>,
) -> Result<&'a [u8], String> {
    let view = root.get(index).ok_or("has no such buffer view")?;
    let bytes = buffers.get(view.buffer.value()).ok_or("has no such buffer")?;
    let n_bytes = bytes.len() as u64;
    let start = view.byte_offset.unwrap_or_default().0;
    if start > n_bytes {
        return Err(format!("buffer view {} starts beyond its buffer", index.value()));
    }
    let end = start.saturating_add(view.byte_length.0).min(n_bytes);
    Ok(&bytes[start as usize..end as usize])
}

/// One component, little-endian. The divisors are those of the format.
fn number(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, largest) = match (component, bytes) {
        (ComponentType::I8, &[a]) => (f32::from(a as i8), 127.0),
        (ComponentType::U8, &[a]) => (f32::from(a), 255.0),
        (ComponentType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (ComponentType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
        (ComponentType::U32, &[a, b, c, d]) => {
            (u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32)
        }
        (ComponentType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        _ => return 0.0,
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}

fn unsigned(bytes: &[u8]) -> u32 {
    match *bytes {
        [a] => a.into(),
        [a, b] => u16::from_le_bytes([a, b]).into(),
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Opens accessor 0 over one buffer with views 0 (stride 4 when asked) and 1 (all).
    fn open_json(accessor: &str, bytes: &[u8], stride: bool) -> Result<Vec<[f32; 3]>, String> {
        let n_bytes = bytes.len();
        let stride = if stride { r#","byteStride":4"# } else { "" };
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"accessors":[{accessor}],
            "buffers":[{{"byteLength":{n_bytes}}}],"bufferViews":[
            {{"buffer":0,"byteLength":{n_bytes}{stride}}},{{"buffer":0,"byteLength":{n_bytes}}}]}}"#
        );
        let root: Root = serde_json::from_str(&text).unwrap();
        let buffers = [Cow::Borrowed(bytes)];
        let accessor = Accessor::open(&root, &buffers, Index::new(0))?;
        Ok((0..accessor.count.min(10)).map(|i| accessor.row(i)).collect())
    }

    #[test]
    fn components_of_every_type_are_read() {
        #[track_caller]
        fn check(component: u32, normalized: bool, bytes: &[u8], expected: f32) {
            let json = format!(
                r#"{{"bufferView":1,"count":1,"componentType":{component},"type":"SCALAR",
                "normalized":{normalized}}}"#
            );
            assert_eq!(open_json(&json, bytes, false).unwrap(), [[expected, 0.0, 0.0]]);
        }
        check(5120, false, &[0xff], -1.0);
        check(5120, true, &[0x80], -1.0);
        check(5120, true, &[127], 1.0);
        check(5121, false, &[255], 255.0);
        check(5121, true, &[255], 1.0);
        check(5122, true, &[0xff, 0x7f], 1.0);
        check(5122, false, &[0, 0x80], -32768.0);
        check(5123, true, &[0xff, 0xff], 1.0);
        check(5125, false, &[1, 0, 0, 0], 1.0);
        check(5126, false, &1.5f32.to_le_bytes(), 1.5);
    }

    #[test]
    fn rows_may_be_interleaved() {
        let json =
            r#"{"bufferView":0,"byteOffset":1,"count":2,"componentType":5121,"type":"VEC3"}"#;
        let rows = open_json(json, &[9, 1, 2, 3, 9, 4, 5, 6], true).unwrap();
        assert_eq!(rows, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    }

    #[test]
    fn sparse_rows_replace_zeros() {
        let json = r#"{"count":4,"componentType":5121,"type":"SCALAR","sparse":{"count":2,
            "indices":{"bufferView":1,"componentType":5121},
            "values":{"bufferView":1,"byteOffset":2}}}"#;
        let rows = open_json(json, &[1, 3, 7, 8], false).unwrap();
        assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), [0.0, 7.0, 0.0, 8.0]);
        assert!(open_json(json, &[3, 1, 7, 8], false).is_err());
        assert!(open_json(json, &[1, 4, 7, 8], false).is_err());
        assert!(open_json(json, &[1, 2, 3], false).is_err());
    }

    /// Plain twins: `row` and `integer`.
    #[test]
    fn packed_rows_are_the_rows() {
        let bytes: Vec<u8> = (0..48u8).map(|i| i.wrapping_mul(37)).collect();
        let text = |accessor: &str, stride: &str| {
            format!(
                r#"{{"asset":{{"version":"2.0"}},"accessors":[{accessor}],
                "buffers":[{{"byteLength":48}}],
                "bufferViews":[{{"buffer":0,"byteLength":48{stride}}}]}}"#
            )
        };
        let buffers = [Cow::Borrowed(&bytes[..])];
        let with = |json: String, check: &dyn Fn(Accessor<'_>)| {
            let root: Root = serde_json::from_str(&json).unwrap();
            check(Accessor::open(&root, &buffers, Index::new(0)).unwrap());
        };
        let floats =
            r#"{"bufferView":0,"byteOffset":4,"count":3,"componentType":5126,"type":"VEC3"}"#;
        with(text(floats, ""), &|accessor| {
            let packed = accessor.packed_floats::<3>(3).unwrap();
            for (i, row) in (0..).zip(packed) {
                let expected = accessor.row::<3>(i).map(f32::to_bits);
                assert_eq!(row.map(u32::from_le_bytes), expected);
            }
            assert_eq!(accessor.packed_floats::<3>(2).unwrap().len(), 2);
            assert!(accessor.packed_floats::<2>(3).is_none());
            assert!(accessor.packed_integers::<4, 3>().is_none());
        });
        with(text(floats, r#","byteStride":16"#), &|accessor| {
            assert!(accessor.packed_floats::<3>(3).is_none());
        });
        let indices =
            r#"{"bufferView":0,"byteOffset":2,"count":8,"componentType":5123,"type":"SCALAR"}"#;
        with(text(indices, ""), &|accessor| {
            let packed = accessor.packed_integers::<2, 3>().unwrap();
            assert_eq!(packed.len(), 2);
            for (i, bytes) in (0..).zip(packed.as_flattened()) {
                assert_eq!(u32::from(u16::from_le_bytes(*bytes)), accessor.integer(i));
            }
            assert!(accessor.packed_integers::<4, 3>().is_none());
        });
    }

    #[test]
    fn claims_beyond_the_bytes_are_refused() {
        for accessor in [
            r#"{"bufferView":1,"count":5,"componentType":5121,"type":"SCALAR"}"#,
            r#"{"bufferView":1,"count":1,"byteOffset":4,"componentType":5121,"type":"SCALAR"}"#,
            r#"{"bufferView":1,"count":18446744073709551615,"componentType":5126,"type":"MAT4"}"#,
            r#"{"bufferView":1,"count":1,"byteOffset":18446744073709551615,
                "componentType":5121,"type":"SCALAR"}"#,
            r#"{"bufferView":0,"count":1,"componentType":5126,"type":"VEC3"}"#,
        ] {
            assert!(open_json(accessor, &[0; 4], true).is_err(), "{accessor}");
        }
    }

    #[test]
    fn a_claim_without_data_costs_nothing() {
        let json = r#"{"count":1099511627776,"componentType":5126,"type":"VEC3"}"#;
        assert_eq!(open_json(json, &[], false).unwrap(), [[0.0; 3]; 10]);
    }
}
