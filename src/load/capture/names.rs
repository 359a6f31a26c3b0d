//! What names of columns and elements mean. It reads no numbers.

use super::sampling::time_unit_s;
use crate::session::LengthColumn;

/// What a name of a column or element means.
pub(super) enum Meaning {
    /// Times in this unit, s.
    Time(f64),
    /// Readings, with what they are where the name says it.
    Readings(Option<LengthColumn>),
    Other,
}

/// Words that name readings.
pub(super) const READINGS: [&str; 12] = [
    "deviation",
    "reading",
    "length",
    "radius",
    "ballbar",
    "abweichung",
    "laenge",
    "distance",
    "transducer",
    "displacement",
    "messwert",
    "ecart",
];
/// Words that name readings where a unit of length stands beside them: there is an error code without one.
const WITH_UNIT: [&str; 3] = ["error", "δl", "dl"];
/// Words that name times.
const TIMES: [&str; 10] =
    ["time", "zeit", "t", "seconds", "datetime", "timestamp", "zeitstempel", "uhrzeit", "elapsed", "temps"];
/// Words for micrometres.
const MICROMETRES: [&str; 8] =
    ["um", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres", "mikrometer"];
/// Words for units of length in which no readings are taken.
const OTHER_UNITS: [&str; 8] = ["in", "inch", "inches", "thou", "mil", "mils", "nm", "cm"];
/// Words for lengths themselves, and for what they are off by, which a length beside them is of.
const LENGTHS: [&str; 3] = ["length", "laenge", "distance"];
const OFF: [&str; 4] = ["deviation", "abweichung", "ecart", "error"];

/// A name in small letters, its words apart.
pub(super) fn plain_name(name: &str) -> String {
    let plain =
        name.trim().trim_matches('"').to_lowercase().replace(['µ', 'μ'], "u").replace('ä', "ae").replace('é', "e");
    plain.chars().map(|character| if character.is_alphanumeric() { character } else { '_' }).collect()
}

/// The unit of length in a name of readings that is none of those that are read.
pub(super) fn other_unit(name: &str) -> Option<&'static str> {
    let plain = plain_name(name);
    let mut words = plain.split('_');
    words.find_map(|word| OTHER_UNITS.into_iter().find(|unit| *unit == word))
}

pub(super) fn meaning(name: &str) -> Meaning {
    let plain = plain_name(name);
    let words: Vec<&str> = plain.split('_').filter(|word| !word.is_empty()).collect();
    let has = |list: &[&str]| words.iter().any(|word| list.contains(word));
    if has(&TIMES) {
        return Meaning::Time(words.iter().find_map(|word| time_unit_s(word)).unwrap_or(1.0));
    }
    let (in_um, in_mm) = (has(&MICROMETRES), has(&["mm"]));
    if !(has(&READINGS) || has(&WITH_UNIT) && (in_um || in_mm)) {
        return Meaning::Other;
    }
    let is_length = has(&LENGTHS) && !has(&OFF);
    Meaning::Readings(match (in_um, in_mm, is_length) {
        (true, _, false) => Some(LengthColumn::DeviationUm),
        (_, true, false) => Some(LengthColumn::DeviationMm),
        (_, true, true) => Some(LengthColumn::LengthMm),
        _ => None,
    })
}
