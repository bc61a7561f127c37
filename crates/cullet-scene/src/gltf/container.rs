//! Where in these bytes are the JSON text and the binary blob?

use ::gltf::Glb;

/// The parts of a glTF file.
#[derive(Debug)]
pub(super) struct Parts<'a> {
    /// The JSON text.
    pub json: &'a [u8],
    /// The binary chunk of a `.glb`, which is the content of buffer 0.
    pub blob: Option<&'a [u8]>,
}

/// Splits a binary file into its chunks; a text file is all JSON. The error says what is
/// wrong.
pub(super) fn split(bytes: &[u8]) -> Result<Parts<'_>, String> {
    if bytes.is_empty() {
        return Err("is empty".into());
    }
    if !bytes.starts_with(b"glTF") {
        // The glTF specification (2.0, section 2.7) forbids it, and its validator fails such files.
        if bytes.starts_with(BYTE_ORDER_MARK) {
            return Err("begins with a byte order mark, which glTF forbids: save it as UTF-8 \
                        without one"
                .into());
        }
        return Ok(Parts { json: bytes, blob: None });
    }
    let length = bytes.get(8..12).ok_or("ends within its header")?;
    let length = u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize;
    if length < HEADER_SIZE || length > bytes.len() {
        return Err(format!("says it has {length} bytes, but has {}", bytes.len()));
    }
    // Only the checks are wanted here: the crate hands out copies or borrows as it likes.
    let glb = Glb::from_slice(&bytes[..length]).map_err(|error| format!("is damaged: {error}"))?;
    let json_end = CHUNKS_START + glb.json.len();
    let blob_start = json_end + CHUNK_HEADER_SIZE;
    let blob = glb.bin.map(|blob| &bytes[blob_start..blob_start + blob.len()]);
    Ok(Parts { json: &bytes[CHUNKS_START..json_end], blob })
}

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
const HEADER_SIZE: usize = 12;
const CHUNK_HEADER_SIZE: usize = 8;
const CHUNKS_START: usize = HEADER_SIZE + CHUNK_HEADER_SIZE;

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, content) in chunks {
            bytes.extend((content.len() as u32).to_le_bytes());
            bytes.extend(*kind);
            bytes.extend(*content);
        }
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        bytes
    }

    #[test]
    fn chunks_are_found() {
        let bytes = glb(&[(b"JSON", b"{}  "), (b"BIN\0", b"abcd")]);
        let parts = split(&bytes).unwrap();
        assert_eq!((parts.json, parts.blob), (&b"{}  "[..], Some(&b"abcd"[..])));
    }

    #[test]
    fn bytes_behind_the_stated_length_are_ignored() {
        let mut bytes = glb(&[(b"JSON", b"{}  ")]);
        bytes.extend(b"trailing");
        assert_eq!(split(&bytes).unwrap().json, b"{}  ");
    }

    #[test]
    fn damaged_files_are_refused() {
        let whole = glb(&[(b"JSON", b"{}  "), (b"BIN\0", b"abcd")]);
        for length in 0..whole.len() {
            let cut = &whole[..length];
            assert!(split(cut).is_err() || !cut.starts_with(b"glTF"), "{length}");
        }
        assert!(split(&glb(&[(b"BIN\0", b"abcd")])).is_err());
        let mut short = whole.clone();
        short[8] = 3;
        assert!(split(&short).is_err());
    }

    #[test]
    fn text_is_all_json() {
        assert_eq!(split(b"{}").unwrap().json, b"{}");
        assert!(split(b"\xef\xbb\xbf{}").unwrap_err().contains("byte order mark"));
    }
}
