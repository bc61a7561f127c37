//! What to tell the user about a file, without telling it a thousand times.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Warnings and omissions, gathered by kind.
#[derive(Debug, Default)]
pub(super) struct Notes {
    /// The first place of some trouble with its details, and how many more there are.
    warnings: Vec<(String, usize)>,
    idx_of_kind: BTreeMap<&'static str, usize>,
    left_out: BTreeMap<String, usize>,
}

impl Notes {
    /// Trouble of the given `kind`; `text` tells the first case of it, with place and mending.
    pub fn warn(&mut self, kind: &'static str, text: String) {
        match self.idx_of_kind.entry(kind) {
            Entry::Occupied(idx) => self.warnings[*idx.get()].1 += 1,
            Entry::Vacant(idx) => {
                idx.insert(self.warnings.len());
                self.warnings.push((text, 0));
            }
        }
    }

    /// A warning that is worth telling every time.
    pub fn warn_each(&mut self, text: String) {
        self.warnings.push((text, 0));
    }

    /// The number of warnings so far.
    pub fn n_warnings(&self) -> usize {
        self.warnings.len()
    }

    /// A warning that belongs before those from `place` on, but was found out later.
    pub fn insert(&mut self, place: usize, text: String) {
        self.warnings.insert(place, (text, 0));
        for idx in self.idx_of_kind.values_mut().filter(|idx| **idx >= place) {
            *idx += 1;
        }
    }

    /// Something that is not drawn yet; `what` is a plural.
    pub fn leave_out(&mut self, what: &str) {
        *self.left_out.entry(what.to_owned()).or_default() += 1;
    }

    /// The sentences and phrases for a scene; `file` heads every warning.
    pub fn finish(self, file: &str) -> (Vec<String>, Vec<String>) {
        let sentence = |(text, n_more)| match n_more {
            0 => format!("{file}: {text}"),
            n_more => format!("{file}: {text} (and {n_more} more like it)"),
        };
        let warnings = self.warnings.into_iter().map(sentence).collect();
        let phrase = |(what, n)| format!("{what}: {n}");
        (warnings, self.left_out.into_iter().map(phrase).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_trouble_is_told_once_with_its_number() {
        let mut notes = Notes::default();
        notes.warn("face", "line 3: bad face".into());
        notes.warn("face", "line 4: bad face".into());
        notes.warn("name", "line 5: no name".into());
        notes.warn_each("one".into());
        let place = notes.n_warnings();
        notes.warn("late", "two".into());
        notes.insert(place, "between".into());
        notes.warn("late", "three".into());
        notes.leave_out("lines");
        notes.leave_out("lines");
        let (warnings, left_out) = notes.finish("a.obj");
        let expected = [
            "a.obj: line 3: bad face (and 1 more like it)",
            "a.obj: line 5: no name",
            "a.obj: one",
            "a.obj: between",
            "a.obj: two (and 1 more like it)",
        ];
        assert_eq!(warnings, expected);
        assert_eq!(left_out, ["lines: 2"]);
    }
}
