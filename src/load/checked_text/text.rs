//! Reads regular files of bounded size and says whether they lie in a folder; knows no format.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::OnceLock;

use super::limits::Limit;
use super::printable::hidden_in;
use crate::load::LoadError;

/// Text of a file of at most `limit` bytes; UTF-8, or UTF-16, without its byte order mark. Lines may end as old programs end them, by a
/// carriage return alone.
pub fn read_limited(file: &Path, limit: Limit) -> Result<String, LoadError> {
    text_of(file, bytes_limited(file, limit).map_err(|message| LoadError::file(file, message))?)
}

/// The same, or Windows-1252 (Latin-1 and more), a byte a character, where the bytes are such text and no UTF-8: true then.
pub(crate) fn read_limited_or_latin(file: &Path, limit: Limit) -> Result<(String, bool), LoadError> {
    let bytes = bytes_limited(file, limit).map_err(|message| LoadError::file(file, message))?;
    let latin =
        if wide_text(&bytes).is_none() && std::str::from_utf8(&bytes).is_err() { latin_text(&bytes) } else { None };
    match latin {
        Some(text) => Ok((with_lines(text), true)),
        None => Ok((text_of(file, bytes)?, false)),
    }
}

fn text_of(file: &Path, bytes: Vec<u8>) -> Result<String, LoadError> {
    let bytes = match wide_text(&bytes) {
        Some(text) => return text.map(with_lines).map_err(|message| LoadError::file(file, message)),
        None => bytes,
    };
    let text = String::from_utf8(bytes).map_err(|why| {
        let line = 1 + why.as_bytes()[..why.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        LoadError::line(file, line, "is not UTF-8 text; save it as UTF-8")
    })?;
    Ok(with_lines(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text)))
}

/// Text whose lines end by a carriage return alone, with line feeds.
fn with_lines(text: String) -> String {
    if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text }
}

/// Characters of the bytes 0x80 to 0x9f in Windows-1252; `_` where there is none.
const OF_WINDOWS: &str = "€_‚ƒ„…†‡ˆ‰Š‹Œ_Ž__‘’“”•–—˜™š›œ_žŸ";

/// Bytes as characters of Windows-1252; `None` where one is none, or controls something other than lines and tabs.
fn latin_text(bytes: &[u8]) -> Option<String> {
    let character = |byte: u8| match byte {
        b'\t' | b'\n' | b'\r' | b' '..=b'~' | 0xa0.. => Some(char::from(byte)),
        0x80..=0x9f => OF_WINDOWS.chars().nth(usize::from(byte - 0x80)).filter(|character| *character != '_'),
        _ => None,
    };
    bytes.iter().map(|&byte| character(byte)).collect()
}

/// Bytes of a file that are looked at for which of each two is zero.
const LOOKED_AT: usize = 256;

/// Whether the first bytes are Latin letters of two bytes each, the zero byte first or second in each pair.
fn is_wide(bytes: &[u8], zero: usize) -> bool {
    let pairs = bytes[..bytes.len().min(LOOKED_AT)].chunks_exact(2);
    let letters = pairs.clone().filter(|pair| pair[zero] == 0 && pair[1 - zero] != 0).count();
    // a unit such as µ is Latin too, Δ is not
    pairs.len() >= 4 && letters * 10 >= pairs.len() * 9
}

/// Text of two bytes a character, as spreadsheet programs save it: by its byte order mark, or by the zeros between Latin letters; `None` of
/// other text.
fn wide_text(bytes: &[u8]) -> Option<Result<String, String>> {
    let (unit, mark): (fn([u8; 2]) -> u16, usize) = match bytes {
        [0xff, 0xfe, ..] => (u16::from_le_bytes, 2),
        [0xfe, 0xff, ..] => (u16::from_be_bytes, 2),
        _ if is_wide(bytes, 1) => (u16::from_le_bytes, 0),
        _ if is_wide(bytes, 0) => (u16::from_be_bytes, 0),
        _ => return None,
    };
    let pairs = bytes[mark..].chunks_exact(2);
    if !pairs.remainder().is_empty() {
        return Some(Err("is UTF-16 text that ends within a character; the file is cut off, fetch it again".into()));
    }
    let units: Vec<u16> = pairs.map(|pair| unit([pair[0], pair[1]])).collect();
    Some(String::from_utf16(&units).map_err(|_| "begins as UTF-16 text but is no such text; save it as UTF-8".into()))
}

/// Content of a regular file of at most `limit` bytes; a refusal names no file.
pub(crate) fn bytes_limited(file: &Path, limit: Limit) -> Result<Vec<u8>, String> {
    if is_standard_input(file) {
        return standard_input(limit);
    }
    if let Some(hidden) = file.file_name().and_then(|name| hidden_in(&name.to_string_lossy())) {
        return Err(format!("has the hidden character {hidden} in its name; rename it"));
    }
    let metadata = std::fs::metadata(file).map_err(|why| match why.kind() {
        ErrorKind::NotFound => "is not there; check its name and folder".into(),
        _ => format!("cannot be read: {why}"),
    })?;
    if metadata.is_dir() {
        return Err("is a folder; name a file in it".into());
    }
    // opening a pipe would wait for its writer
    if !metadata.is_file() {
        return Err("is a pipe, socket or device; save what it holds to a file and name that".into());
    }
    let too_large = |found: String| {
        format!("is {found} large; a file of this kind has at most {} MB, is it the right one?", limit.megabytes())
    };
    let most = limit.most as u64;
    if metadata.len() > most {
        return Err(too_large(format!("{} MB", metadata.len().div_ceil(1 << 20))));
    }
    let opened = File::open(file).map_err(|why| format!("cannot be opened: {why}"))?;
    let mut bytes = Vec::new();
    opened.take(most + 1).read_to_end(&mut bytes).map_err(|why| format!("cannot be read: {why}"))?;
    // a file may grow while it is read
    if bytes.len() as u64 > most {
        return Err(too_large("too".into()));
    }
    Ok(bytes)
}

/// True for the name that stands for standard input.
pub fn is_standard_input(file: &Path) -> bool {
    file == Path::new("-")
}

/// All of standard input; what was read once is read again, for a verb may look at a file twice.
fn standard_input(limit: Limit) -> Result<Vec<u8>, String> {
    static READ: OnceLock<Result<Vec<u8>, String>> = OnceLock::new();
    let read = READ.get_or_init(|| {
        let mut bytes = Vec::new();
        let most = limit.most as u64 + 1;
        let read = std::io::stdin().lock().take(most).read_to_end(&mut bytes);
        read.map(|_| bytes).map_err(|why| format!("standard input cannot be read: {why}"))
    });
    match read {
        Ok(bytes) if bytes.len() > limit.most => {
            Err(format!("standard input is too large; a file of this kind has at most {} MB", limit.megabytes()))
        }
        Ok(bytes) => Ok(bytes.clone()),
        Err(why) => Err(why.clone()),
    }
}

/// True when a file lies, links followed, in one of some folders or below.
pub(crate) fn lies_in(file: &Path, folders: &[&Path]) -> bool {
    let Ok(file) = file.canonicalize() else { return false };
    folders.iter().any(|folder| {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        folder.canonicalize().is_ok_and(|folder| file.starts_with(folder))
    })
}
