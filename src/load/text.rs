//! Reads text files of bounded size; knows no format.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::LoadError;

/// Largest machine or session file, bytes: a generous multiple of any real one.
pub const MAX_YAML_BYTES: u64 = 4 << 20;
/// Largest recording, bytes: about two million samples.
pub const MAX_CSV_BYTES: u64 = 128 << 20;

/// Text of a file of at most `limit` bytes; a byte order mark is dropped.
pub fn read_limited(file: &Path, limit: u64) -> Result<String, LoadError> {
    let refuse = |message: String| LoadError::file(file, message);
    let metadata = std::fs::metadata(file).map_err(|why| match why.kind() {
        std::io::ErrorKind::NotFound => refuse("is not there; check its name and folder".into()),
        _ => refuse(format!("cannot be read: {why}")),
    })?;
    if metadata.is_dir() {
        return Err(refuse("is a folder; name a file in it".into()));
    }
    let too_large = |found: String| {
        refuse(format!("is {found} large; a file of this kind has at most {} MB, is it the right one?", limit >> 20))
    };
    if metadata.len() > limit {
        return Err(too_large(format!("{} MB", metadata.len().div_ceil(1 << 20))));
    }
    let opened = File::open(file).map_err(|why| refuse(format!("cannot be opened: {why}")))?;
    let mut bytes = Vec::new();
    opened.take(limit + 1).read_to_end(&mut bytes).map_err(|why| refuse(format!("cannot be read: {why}")))?;
    // a pipe or device reports no size, so the limit is checked on what came
    if bytes.len() as u64 > limit {
        return Err(too_large("too".into()));
    }
    let text = String::from_utf8(bytes).map_err(|why| {
        let line = 1 + why.as_bytes()[..why.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        LoadError::line(file, line, "is not UTF-8 text; save it as UTF-8")
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}
