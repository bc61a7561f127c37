//! A list of hashes: lines as `sha256sum` writes them, a hash and what it is of.

use std::collections::BTreeMap;

/// Hashes by the name of the scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct List(BTreeMap<String, String>);

impl List {
    /// Reads a list. Empty lines and lines that begin with `#` say nothing.
    pub fn parse(text: &str) -> Result<List, String> {
        let mut list = List::default();
        for (i, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let (hash, name) = line
                .split_once(char::is_whitespace)
                .filter(|(hash, _)| is_hash(hash))
                .ok_or_else(|| format!("line {} is no hash and name", i + 1))?;
            if list.0.insert(name.trim().into(), hash.to_ascii_lowercase()).is_some() {
                return Err(format!("line {} names `{}` again", i + 1, name.trim()));
            }
        }
        Ok(list)
    }

    /// Sets the hash of `name`.
    pub fn set(&mut self, name: &str, hash: &str) {
        self.0.insert(name.into(), hash.into());
    }

    /// The hash of `name`.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    /// The list as text, sorted by name.
    pub fn text(&self) -> String {
        let lines = self.0.iter().map(|(name, hash)| line(hash, name));
        format!("{HEADER}{}", lines.collect::<String>())
    }
}

const HEADER: &str = "# SHA-256 of the pictures of each scene: `cullet verify` compares with it, \
    `cullet verify --bless FILE` writes it.\n";

/// One line of a list.
pub fn line(hash: &str, name: &str) -> String {
    format!("{hash}  {name}\n")
}

fn is_hash(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let mut list = List::default();
        list.set("b.glb", &"0f".repeat(32));
        list.set("a name with blanks", &"17".repeat(32));
        assert_eq!(List::parse(&list.text()), Ok(list));
    }

    #[test]
    fn odd_lines_are_named() {
        let hash = "ab".repeat(32);
        let twice = format!("{hash}  x\n\n# fine\n{hash}  x\n");
        assert_eq!(List::parse(&twice), Err("line 4 names `x` again".into()));
        for text in ["abc  x", &hash, &format!("{}g  x", &hash[1..])] {
            assert_eq!(List::parse(text), Err("line 1 is no hash and name".into()));
        }
    }
}
