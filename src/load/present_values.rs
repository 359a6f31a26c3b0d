//! Files of the values that a control holds now: one `name = value` on a line, mm. Which names there are, the caller says.

use std::path::Path;

use crate::load::checked_text::limits::YAML_BYTES;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::text::read_limited;

/// Largest value, mm.
const LARGEST_MM: f64 = 1e6;

/// Values by their names as written, mm; each parameter at most once. `known` has the names of every parameter that the control has,
/// first the one that messages show.
pub fn load_present_values(file: &Path, known: &[[&str; 3]]) -> Result<Vec<(String, f64)>, LoadError> {
    let text = read_limited(file, YAML_BYTES)?;
    let mut list: Vec<(String, f64)> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let refused = |why: String| LoadError::line(file, index + 1, why);
        let parsed = line.rsplit_once('=').and_then(|(name, value)| {
            Some((name.trim().to_string(), value.trim().parse::<f64>().ok().filter(|value| value.abs() <= LARGEST_MM)?))
        });
        let (name, value) = parsed.ok_or_else(|| {
            refused(format!("'{line}' is not 'name = value' in mm; write for example $TC_CARR15 = -0.0123"))
        })?;
        let Some(names) = known.iter().find(|names| names.contains(&name.as_str())) else {
            let shown: Vec<&str> = known.iter().map(|names| names[0]).collect();
            return Err(refused(format!(
                "'{name}' is none of this control's parameters here; there are {}",
                shown.join(", ")
            )));
        };
        if list.iter().any(|(other, _)| names.contains(&other.as_str())) {
            return Err(refused(format!("'{name}' stands twice; keep one line")));
        }
        list.push((name, value));
    }
    Ok(list)
}
