//! An OBJ file as its writer meant it, in the strict form that `tobj` reads right.
//!
//! `tobj` says neither where an error is nor that it guessed, so every statement passes
//! here first: byte order mark, continued lines, comments behind numbers and broken UTF-8
//! go; lines and points are left out; indices become absolute and are checked. Vertices
//! come first in the result, because faces may refer to later ones, and faces with
//! different attributes go to different groups, because `tobj` would mix them up.
//!
//! Source: Wavefront, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write;

use super::notes::Notes;

/// The name of a material whose name is missing, in both files.
pub(super) const UNNAMED: &str = "unnamed";

/// An OBJ text without traps.
#[derive(Debug, Default)]
pub(super) struct Cleaned {
    /// Vertices first, then groups, materials and faces. Without material libraries.
    pub text: String,
    /// What stands behind each `mtllib`.
    pub libraries: Vec<String>,
    /// The materials used, in order of first use.
    pub materials: Vec<String>,
}

/// Something that cannot be read, in the 1-based line of the file.
#[derive(Debug)]
pub(super) struct Problem {
    /// 0 for the file as a whole.
    pub line: usize,
    pub text: String,
}

/// Cleans an OBJ file. Faces before the first group belong to `default_group`.
pub(super) fn clean(
    bytes: &[u8],
    default_group: &str,
    notes: &mut Notes,
) -> Result<Cleaned, Problem> {
    let text = text_of(bytes, notes);
    let statements = statements(&text);
    let census = Census::take(&statements);
    if !census.is_obj {
        return Err(Problem { line: 0, text: "holds no OBJ statement".into() });
    }
    let mut cleaner = Cleaner {
        census,
        so_far: [0; 3],
        vertices: String::new(),
        faces: String::new(),
        group: default_group.to_owned(),
        attributes: None,
        known_materials: BTreeSet::new(),
        cleaned: Cleaned::default(),
        notes,
    };
    for statement in &statements {
        cleaner
            .statement(statement, default_group)
            .map_err(|text| Problem { line: statement.line, text })?;
    }
    let Cleaner { mut vertices, faces, cleaned, .. } = cleaner;
    vertices.push_str(&faces);
    Ok(Cleaned { text: vertices, ..cleaned })
}

/// The text of a file: without byte order mark, with replacement characters for what is
/// not UTF-8.
pub(super) fn text_of<'a>(bytes: &'a [u8], notes: &mut Notes) -> Cow<'a, str> {
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    if matches!(text, Cow::Owned(_)) {
        notes.warn("utf-8", "is not UTF-8; other characters in names are replaced".into());
    }
    text
}

/// One statement, which may span several lines of the file.
pub(super) struct Statement<'a> {
    /// 1-based; the first one if there are several.
    pub line: usize,
    text: Cow<'a, str>,
}

impl Statement<'_> {
    /// The first word; `#` for a comment.
    pub fn keyword(&self) -> &str {
        if self.text.starts_with('#') { "#" } else { self.split().0 }
    }

    /// What stands behind the keyword, trimmed.
    pub fn rest(&self) -> &str {
        self.split().1.trim()
    }

    /// The words behind the keyword, up to a comment.
    pub fn words(&self) -> impl Iterator<Item = &str> {
        self.rest().split_whitespace().take_while(|word| !word.starts_with('#'))
    }

    fn split(&self) -> (&str, &str) {
        self.text.split_once(char::is_whitespace).unwrap_or((&self.text, ""))
    }
}

/// All statements with their lines; lines that end with a backslash go on in the next one.
pub(super) fn statements(text: &str) -> Vec<Statement<'_>> {
    let mut statements = Vec::new();
    let mut lines = text.lines().map(str::trim).zip(1..);
    while let Some((first, line)) = lines.next() {
        let mut text = Cow::Borrowed(first);
        while let Some(head) = text.strip_suffix('\\') {
            let next = lines.next().map_or("", |(next, _)| next);
            text = Cow::Owned(format!("{head} {next}"));
        }
        if !text.trim().is_empty() {
            statements.push(Statement { line, text });
        }
    }
    statements
}

/// What must be known before the first statement is understood.
struct Census {
    /// How many `v`, `vt` and `vn` there are.
    totals: [i64; 3],
    colored: bool,
    is_obj: bool,
}

impl Census {
    fn take(statements: &[Statement<'_>]) -> Census {
        let mut census = Census { totals: [0; 3], colored: false, is_obj: false };
        for statement in statements {
            census.is_obj |= KNOWN.contains(&statement.keyword());
            if let Some(kind) = ["v", "vt", "vn"].iter().position(|it| *it == statement.keyword()) {
                census.totals[kind] += 1;
                census.colored |= kind == 0 && statement.words().nth(5).is_some();
            }
        }
        census
    }
}

/// Keywords that show that a file is meant to be OBJ.
const KNOWN: &[&str] =
    &["#", "v", "vt", "vn", "vp", "f", "fo", "l", "p", "o", "g", "s", "mtllib", "usemtl"];

struct Cleaner<'a> {
    census: Census,
    /// How many `v`, `vt` and `vn` were seen, for relative indices.
    so_far: [i64; 3],
    vertices: String,
    faces: String,
    group: String,
    /// Whether the faces of the group have texture coordinates and normals.
    attributes: Option<(bool, bool)>,
    known_materials: BTreeSet<String>,
    cleaned: Cleaned,
    notes: &'a mut Notes,
}

impl Cleaner<'_> {
    fn statement(&mut self, statement: &Statement<'_>, default_group: &str) -> Result<(), String> {
        match statement.keyword() {
            "v" => self.position(statement)?,
            "vt" => self.numbers(1, statement, 1, 2)?,
            "vn" => self.numbers(2, statement, 3, 3)?,
            "f" | "fo" => self.face(statement)?,
            "l" | "p" => self.notes.leave_out("lines and points"),
            "curv" | "curv2" | "surf" => self.notes.leave_out("free-form curves and surfaces"),
            "o" | "g" => {
                let name = statement.rest();
                self.group = if name.is_empty() { default_group } else { name }.to_owned();
                self.attributes = None;
            }
            "usemtl" => self.use_material(statement),
            "mtllib" => self.cleaned.libraries.push(statement.rest().to_owned()),
            _ => {}
        }
        Ok(())
    }

    /// `x y z`, `x y z w`, `x y z r g b` or `x y z r g b a`.
    fn position(&mut self, statement: &Statement<'_>) -> Result<(), String> {
        let values = self.parse(statement)?;
        let (position, color) = match values.as_slice() {
            [x, y, z] => ([*x, *y, *z], [1.0; 3]),
            [_, _, _, 0.0] => return Err("the weight of a vertex is 0".into()),
            [x, y, z, w] => ([x / w, y / w, z / w], [1.0; 3]),
            [x, y, z, r, g, b] | [x, y, z, r, g, b, _] => ([*x, *y, *z], [*r, *g, *b]),
            other => return Err(format!("a vertex of {} numbers", other.len())),
        };
        self.so_far[0] += 1;
        push_numbers(&mut self.vertices, "v", &position);
        if self.census.colored {
            self.vertices.pop();
            push_numbers(&mut self.vertices, "", &color);
        }
        Ok(())
    }

    /// Texture coordinates (`kind` 1) or normals (2): at least `min` numbers, and as many
    /// as `keep` are used, filled up with 0.
    fn numbers(
        &mut self,
        kind: usize,
        statement: &Statement<'_>,
        min: usize,
        keep: usize,
    ) -> Result<(), String> {
        let mut values = self.parse(statement)?;
        if values.len() < min {
            return Err(format!("`{}` with {} numbers", statement.keyword(), values.len()));
        }
        values.resize(keep, 0.0);
        self.so_far[kind] += 1;
        push_numbers(&mut self.vertices, statement.keyword(), &values);
        Ok(())
    }

    /// Microsoft's spellings of NaN and infinity become NaN: the triangles there are lost,
    /// but not the rest.
    fn parse(&mut self, statement: &Statement<'_>) -> Result<Vec<f32>, String> {
        let mut values = Vec::with_capacity(8);
        for word in statement.words() {
            let value = match word.parse::<f32>() {
                Ok(value) => value,
                Err(_) if word.contains("#I") || word.contains("nan(") => f32::NAN,
                Err(_) => return Err(format!("`{word}` is not a number")),
            };
            if !value.is_finite() {
                let text = format!(
                    "line {}: `{word}` is not finite; its triangles are left out",
                    statement.line
                );
                self.notes.warn("not finite", text);
            }
            values.push(value);
        }
        Ok(values)
    }

    fn face(&mut self, statement: &Statement<'_>) -> Result<(), String> {
        let mut corners = Vec::with_capacity(4);
        for word in statement.words() {
            let corner =
                self.corner(word).ok_or_else(|| format!("`{word}` is not a corner of a face"))?;
            corners.push(corner);
        }
        if corners.len() < 3 {
            self.notes.leave_out("faces with less than three corners");
            return Ok(());
        }
        if let Some(stray) = corners.iter().find_map(|corner| self.stray(0, corner[0])) {
            let text =
                format!("line {}: a face refers to vertex {stray}; it is left out", statement.line);
            self.notes.warn("vertex", text);
            return Ok(());
        }
        let attributes = (
            self.keeps(1, "texture coordinate", &corners, statement.line),
            self.keeps(2, "normal", &corners, statement.line),
        );
        if self.attributes.replace(attributes) != Some(attributes) {
            let _ = writeln!(self.faces, "g {}", self.group); // writing to a String cannot fail
        }
        self.faces.push('f');
        for [v, vt, vn] in corners.iter().map(|corner| corner.map(Option::unwrap_or_default)) {
            let _ = match attributes {
                (false, false) => write!(self.faces, " {v}"),
                (true, false) => write!(self.faces, " {v}/{vt}"),
                (false, true) => write!(self.faces, " {v}//{vn}"),
                (true, true) => write!(self.faces, " {v}/{vt}/{vn}"),
            };
        }
        self.faces.push('\n');
        Ok(())
    }

    /// Absolute 1-based indices of a corner, not yet checked; `None` if it is none.
    fn corner(&self, word: &str) -> Option<[Option<i64>; 3]> {
        let mut corner = [None; 3];
        let mut parts = word.split('/');
        for (slot, n_so_far) in corner.iter_mut().zip(self.so_far) {
            let Some(part) = parts.next() else { break };
            if !part.is_empty() {
                let index: i64 = part.parse().ok()?;
                *slot = Some(if index < 0 { index.saturating_add(n_so_far + 1) } else { index });
            }
        }
        (corner[0].is_some() && parts.next().is_none()).then_some(corner)
    }

    /// What to call an index that refers to nothing.
    fn stray(&self, kind: usize, index: Option<i64>) -> Option<String> {
        let total = self.census.totals[kind];
        let index = index?;
        (!(1..=total).contains(&index)).then(|| format!("{index} of {total}"))
    }

    /// Whether all corners of a face have an attribute that exists.
    fn keeps(
        &mut self,
        kind: usize,
        what: &str,
        corners: &[[Option<i64>; 3]],
        line: usize,
    ) -> bool {
        if corners.iter().all(|corner| corner[kind].is_none()) {
            return false;
        }
        let stray = corners.iter().find_map(|corner| self.stray(kind, corner[kind]));
        let missing = corners.iter().any(|corner| corner[kind].is_none());
        let problem = match stray {
            Some(stray) => format!("refers to {what} {stray}"),
            None if missing => format!("has a corner without {what}"),
            None => return true,
        };
        let text = format!("line {line}: a face {problem}; it is drawn without");
        self.notes.warn(["", "uv", "normal"][kind], text);
        false
    }

    fn use_material(&mut self, statement: &Statement<'_>) {
        let name = if statement.rest().is_empty() { UNNAMED } else { statement.rest() };
        if self.known_materials.insert(name.to_owned()) {
            self.cleaned.materials.push(name.to_owned());
        }
        let _ = writeln!(self.faces, "usemtl {name}");
    }
}

fn push_numbers(text: &mut String, keyword: &str, values: &[f32]) {
    text.push_str(keyword);
    for value in values {
        let _ = write!(text, " {value}");
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(text: &str) -> (Result<Cleaned, Problem>, Vec<String>, Vec<String>) {
        let mut notes = Notes::default();
        let result = clean(text.as_bytes(), "all", &mut notes);
        let (warnings, left_out) = notes.finish("x");
        (result, warnings, left_out)
    }

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    /// What becomes of statements behind three vertices.
    #[track_caller]
    fn check(faces: &str, expected: &str) {
        let (result, ..) = cleaned(&format!("{TRIANGLE}{faces}"));
        assert_eq!(result.unwrap().text, format!("{TRIANGLE}{expected}"));
    }

    #[test]
    fn indices_become_absolute() {
        check("f 1 2 3", "g all\nf 1 2 3\n");
        check("f -3 -2 -1", "g all\nf 1 2 3\n");
        check("f -3// -2 -1/", "g all\nf 1 2 3\n");
        check("g a b\nf 1 2 3\nf 3 2 1\n", "g a b\nf 1 2 3\nf 3 2 1\n");
    }

    #[test]
    fn lines_may_be_continued_and_commented() {
        check("f 1 \\\n  2 3", "g all\nf 1 2 3\n");
        check("f \\\r\n1 2 \\\r\n3\r\nf 3 2 1\r\n", "g all\nf 1 2 3\nf 3 2 1\n");
        check("f 1 2 3 # front", "g all\nf 1 2 3\n");
        check("f 1 2 3 \\", "g all\nf 1 2 3\n");
    }

    #[test]
    fn names_may_hold_blanks_and_follow_tabs() {
        check("usemtl\tred  wall\no my house\nf 1 2 3", "usemtl red  wall\ng my house\nf 1 2 3\n");
        check("  g\nf 1 2 3", "g all\nf 1 2 3\n");
    }

    #[test]
    fn faces_with_other_attributes_go_to_another_group() {
        let text = "vt 0 0\nf 1 2 3\nf 1/1 2/1 3/1\nf 1 2/1 3/1\n";
        let expected = "vt 0 0\ng all\nf 1 2 3\ng all\nf 1/1 2/1 3/1\ng all\nf 1 2 3\n";
        check(text, expected);
    }

    #[test]
    fn every_vertex_has_a_color_when_one_has() {
        let (result, ..) = cleaned("v 1 2 3 0.5 0.25 0 1\nv 4 5 6\n");
        assert_eq!(result.unwrap().text, "v 1 2 3 0.5 0.25 0\nv 4 5 6 1 1 1\n");
    }

    #[test]
    fn weights_divide() {
        let (result, ..) = cleaned("v 2 4 6 2");
        assert_eq!(result.unwrap().text, "v 1 2 3\n");
    }

    #[track_caller]
    fn check_refused(text: &str, line: usize, expected: &str) {
        let problem = cleaned(text).0.unwrap_err();
        assert_eq!((problem.line, &*problem.text), (line, expected));
    }

    #[test]
    fn errors_name_their_line() {
        check_refused("", 0, "holds no OBJ statement");
        check_refused("\x7fELF\0\0binary", 0, "holds no OBJ statement");
        check_refused("# ok\nv 1,0 2,0 3,0", 2, "`1,0` is not a number");
        check_refused("v 1 2", 1, "a vertex of 2 numbers");
        check_refused("v 1 2 3 0", 1, "the weight of a vertex is 0");
        check_refused("\n\nf 1 2 x", 3, "`x` is not a corner of a face");
        check_refused("f 1/2/3/4 2 3", 1, "`1/2/3/4` is not a corner of a face");
        check_refused(
            "f 1 2 99999999999999999999",
            1,
            "`99999999999999999999` is not a corner of a face",
        );
        check_refused("v 0 0 \\\n0\nvn 1 2", 3, "`vn` with 2 numbers");
    }

    #[track_caller]
    fn check_warning(faces: &str, expected: &str) {
        let (result, warnings, _) = cleaned(&format!("{TRIANGLE}{faces}"));
        result.unwrap();
        assert_eq!(warnings, [format!("x: {expected}")]);
    }

    #[test]
    fn damage_is_told_with_its_line() {
        check_warning("f 1 2 4", "line 4: a face refers to vertex 4 of 3; it is left out");
        check_warning("f 0 1 2", "line 4: a face refers to vertex 0 of 3; it is left out");
        check_warning("f -9 1 2", "line 4: a face refers to vertex -5 of 3; it is left out");
        let min = i64::MIN;
        check_warning(
            &format!("f 1/{min} 2/1 3/1"),
            &format!(
                "line 4: a face refers to texture coordinate {} of 0; it is drawn without",
                min + 1
            ),
        );
        check_warning(
            "vn 0 0 1\nf 1//1 2 3",
            "line 5: a face has a corner without normal; it is drawn without",
        );
        check_warning("v 1.#IND 0 0", "line 4: `1.#IND` is not finite; its triangles are left out");
        check_warning("v 1e400 0 0", "line 4: `1e400` is not finite; its triangles are left out");
    }

    #[test]
    fn lines_points_and_scraps_are_left_out() {
        let (result, _, left_out) = cleaned(&format!("{TRIANGLE}l 1 2 3\np 1\nf 1 2\nf 1 2 3\nf"));
        assert_eq!(result.unwrap().text, format!("{TRIANGLE}g all\nf 1 2 3\n"));
        assert_eq!(left_out, ["faces with less than three corners: 2", "lines and points: 2"]);
    }

    #[test]
    fn byte_order_marks_and_foreign_characters_do_no_harm() {
        let mut notes = Notes::default();
        let text = b"\xef\xbb\xbfv 1 2 3\ng caf\xe9\n";
        assert_eq!(clean(text, "all", &mut notes).unwrap().text, "v 1 2 3\n");
        assert_eq!(notes.finish("x").0.len(), 1);
    }
}
