//! The shortest decimal that reads back as exactly the value held inside; knows units, no file format.

use crate::machine::AxisKind;
use crate::units::Measure;

/// Decimal digits that tell any two f64 apart.
const MAX_DIGITS: usize = 17;
/// Neighbours of a guess that are tried: a product or quotient is off by an ulp or two.
const NEIGHBOURS: u32 = 4;

/// The shortest decimal near `guess` for which `read` gives exactly `value`; `None` when no neighbour does.
pub fn reading_back(value: f64, guess: f64, read: impl Fn(f64) -> f64) -> Option<f64> {
    let shorter = (0..MAX_DIGITS).filter_map(|digits| format!("{guess:.digits$e}").parse::<f64>().ok());
    let (mut above, mut below) = (guess, guess);
    let neighbours = (0..NEIGHBOURS).flat_map(|_| {
        (above, below) = (above.next_up(), below.next_down());
        [above, below]
    });
    shorter.chain(neighbours).find(|&decimal| read(decimal) == value)
}

/// A position held in mm or rad in the unit of files, mm or degrees.
pub fn position(kind: AxisKind, value: f64) -> f64 {
    let guess = kind.to_file_unit(value);
    reading_back(value, guess, |decimal| kind.from_file_unit(decimal)).unwrap_or(guess)
}

/// A length or angle held in mm or rad with its unit: µm or arcsec where that reads back exactly, else mm or rad.
pub fn quantity(measure: Measure, value: f64) -> String {
    scaled_quantity(measure, value, 1.0)
}

/// A coefficient that the reader multiplies by `scale` after its unit.
pub fn scaled_quantity(measure: Measure, value: f64, scale: f64) -> String {
    let units = measure.units();
    let inside = units.iter().find(|(_, factor)| *factor == 1.0).copied().unwrap_or(units[0]);
    [units[0], inside]
        .into_iter()
        .find_map(|(unit, factor)| {
            let decimal = reading_back(value, value / scale / factor, |decimal| decimal * factor * scale)?;
            Some(format!("{decimal} {unit}"))
        })
        .unwrap_or_else(|| format!("{} {}", value / scale, inside.0))
}

/// A value and its standard deviation with the same decimals: two digits of the deviation, at most two decimals.
pub fn shown(value: f64, sigma: f64) -> (String, String) {
    let decimals = match sigma.abs() {
        sigma if sigma < 10.0 => 2,
        sigma if sigma < 100.0 => 1,
        _ => 0,
    };
    let text = format!("{value:.decimals$}");
    // no minus before a zero
    let is_zero = text.chars().all(|c| "-0.".contains(c));
    (if is_zero { text.replace('-', "") } else { text }, format!("{sigma:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_stay_as_the_user_wrote_them() {
        assert_eq!(quantity(Measure::Length, 34.2 * 1e-3), "34.2 um");
        let arcsec = std::f64::consts::PI / (180.0 * 3600.0);
        assert_eq!(quantity(Measure::Angle, -22.32 * arcsec), "-22.32 arcsec");
        assert_eq!(position(AxisKind::Rotary, (-19.80901f64).to_radians()), -19.80901);
        assert_eq!(quantity(Measure::Length, 0.0), "0 um");
    }
}
