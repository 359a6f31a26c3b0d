//! Files as gauges write them, text tables or XML, to columns of times and readings. What they mean is `import`'s to find.

mod names;
mod numbers;
mod raw;
mod sampling;
mod table;
mod xml;

use std::path::Path;

use self::raw::Raw;
pub use self::raw::{CaptureFile, CaptureHints};
use crate::load::checked_text::limits::CSV_BYTES;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::text::read_limited_or_latin;

/// Reads a capture: a table with a header that names times and readings, or XML with a list of numbers.
pub fn load_capture(file: &Path, hints: CaptureHints) -> Result<CaptureFile, LoadError> {
    let (text, is_latin) = read_limited_or_latin(file, CSV_BYTES)?;
    let raw: Raw =
        if text.trim_start().starts_with('<') { xml::from_xml(file, &text)? } else { table::from_table(file, &text)? };
    Ok(CaptureFile { is_latin, ..raw.finished(file, hints)? })
}
