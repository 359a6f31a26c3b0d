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
pub(super) const READINGS: [&str; 9] =
    ["deviation", "reading", "length", "radius", "ballbar", "abweichung", "laenge", "distance", "transducer"];
/// Words that name times.
const TIMES: [&str; 4] = ["time", "zeit", "t", "seconds"];

/// A name in small letters, its words apart.
pub(super) fn plain_name(name: &str) -> String {
    let plain = name.trim().trim_matches('"').to_lowercase().replace(['µ', 'μ'], "u").replace('ä', "ae");
    plain.chars().map(|character| if character.is_alphanumeric() { character } else { '_' }).collect()
}

pub(super) fn meaning(name: &str) -> Meaning {
    let plain = plain_name(name);
    let words: Vec<&str> = plain.split('_').filter(|word| !word.is_empty()).collect();
    let has = |list: &[&str]| words.iter().any(|word| list.contains(word));
    if has(&TIMES) {
        return Meaning::Time(words.iter().find_map(|word| time_unit_s(word)).unwrap_or(1.0));
    }
    if !has(&READINGS) {
        return Meaning::Other;
    }
    let is_length = has(&["length", "laenge", "distance"]);
    Meaning::Readings(match (has(&["um", "micron", "microns"]), has(&["mm"]), is_length) {
        (true, _, false) => Some(LengthColumn::DeviationUm),
        (_, true, false) => Some(LengthColumn::DeviationMm),
        (_, true, true) => Some(LengthColumn::LengthMm),
        _ => None,
    })
}
