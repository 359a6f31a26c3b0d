//! Quantities with units as users write them ("34.2 um", "6.62 arcsec") and the factors behind them; holds no geometry.
//!
//! Inside the library lengths are millimetres and angles radians. Geometric errors are small and
//! easily misread, so in files they always carry a unit and a bare number is refused.

use std::f64::consts::PI;

/// Micrometres in a millimetre.
pub const UM_PER_MM: f64 = 1000.0;
/// Arcseconds in a radian.
pub const ARCSEC_PER_RAD: f64 = 180.0 * 3600.0 / PI;

/// Milliseconds in a second.
pub const MS_PER_S: f64 = 1000.0;

/// Millimetres in an inch.
pub const MM_PER_INCH: f64 = 25.4;

/// A unit in which numbers may stand by mistake where mm or degrees are due.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OtherUnit {
    /// As messages name it.
    pub name: &'static str,
    /// One of it in the unit that is due, mm or deg.
    pub size: f64,
}

impl OtherUnit {
    pub const METRES: OtherUnit = OtherUnit { name: "metres", size: 1e3 };
    pub const INCHES: OtherUnit = OtherUnit { name: "inches", size: MM_PER_INCH };
    pub const CENTIMETRES: OtherUnit = OtherUnit { name: "centimetres", size: 10.0 };
    pub const MICROMETRES: OtherUnit = OtherUnit { name: "µm", size: 1e-3 };
    pub const RADIANS: OtherUnit = OtherUnit { name: "radians", size: 180.0 / PI };
    pub const TURNS: OtherUnit = OtherUnit { name: "turns", size: 360.0 };
}

/// What a quantity measures: decides which units are accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// A length, held in mm.
    Length,
    /// An angle, held in rad.
    Angle,
    /// A length per length, held in mm/mm.
    Strain,
    /// A time, held in s.
    Time,
    /// A time squared (position per acceleration), held in s².
    TimeSquared,
    /// A length per kelvin, held in mm/K.
    LengthPerKelvin,
    /// An angle per kelvin, held in rad/K.
    AnglePerKelvin,
    /// A length per unit of a load (Nm or N), held in mm per unit.
    LengthPerLoad,
    /// An angle per unit of a load, held in rad per unit.
    AnglePerLoad,
}

impl Measure {
    /// Units accepted on input with their factor to mm or rad; the first is used on output.
    pub fn units(self) -> &'static [(&'static str, f64)] {
        const ARCSEC: f64 = PI / (180.0 * 3600.0);
        match self {
            Measure::Length => &[("um", 1e-3), ("µm", 1e-3), ("μm", 1e-3), ("mm", 1.0), ("nm", 1e-6), ("m", 1e3)],
            Measure::Angle => &[
                ("arcsec", ARCSEC),
                ("\"", ARCSEC),
                ("″", ARCSEC),
                ("deg", PI / 180.0),
                ("°", PI / 180.0),
                ("arcmin", ARCSEC * 60.0),
                ("urad", 1e-6),
                ("µrad", 1e-6),
                ("μrad", 1e-6),
                ("mrad", 1e-3),
                ("rad", 1.0),
            ],
            Measure::Strain => &[("um/m", 1e-6), ("µm/m", 1e-6), ("μm/m", 1e-6), ("ppm", 1e-6), ("mm/mm", 1.0)],
            Measure::Time => &[("ms", 1e-3), ("s", 1.0), ("us", 1e-6)],
            Measure::TimeSquared => &[("ms^2", 1e-6), ("ms²", 1e-6), ("s^2", 1.0)],
            Measure::LengthPerKelvin => &[("um/K", 1e-3), ("µm/K", 1e-3), ("μm/K", 1e-3), ("mm/K", 1.0)],
            Measure::LengthPerLoad => &[("um/Nm", 1e-3), ("um/N", 1e-3), ("mm/Nm", 1.0), ("mm/N", 1.0)],
            Measure::AnglePerLoad => &[
                ("arcsec/Nm", ARCSEC),
                ("arcsec/N", ARCSEC),
                ("urad/Nm", 1e-6),
                ("deg/Nm", PI / 180.0),
                ("rad/Nm", 1.0),
            ],
            Measure::AnglePerKelvin => &[("arcsec/K", ARCSEC), ("urad/K", 1e-6), ("rad/K", 1.0)],
        }
    }

    /// Unit used on output: `um`, `arcsec`, `ms`, ….
    pub fn output_unit(self) -> &'static str {
        self.units()[0].0
    }

    /// The same as people read it: `µm`, `arcsec`, `µm/m`, ….
    pub fn shown_unit(self) -> String {
        self.output_unit().replace("um", "µm")
    }

    /// A value held in mm or rad in its output unit, µm or arcsec.
    pub fn to_output(self, value: f64) -> f64 {
        match self {
            Measure::Length => value * UM_PER_MM,
            Measure::Angle => value * ARCSEC_PER_RAD,
            _ => value / self.units()[0].1,
        }
    }
}

/// A number for a message: with exponent where it would be long otherwise.
pub fn shown(value: f64) -> String {
    let is_short = value == 0.0 || (1e-5..1e9).contains(&value.abs());
    if is_short { value.to_string() } else { format!("{value:e}") }
}

/// A number with at most so many decimals, without a negative zero.
pub fn rounded(value: f64, decimals: usize) -> f64 {
    let scale = 10f64.powi(decimals as i32);
    (value * scale).round() / scale + 0.0
}

/// Why a quantity was not understood; the text names what is allowed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum QuantityError {
    /// A number without a unit.
    #[error("'{found}' has no unit; write for example '{found} {example}' (allowed: {allowed})")]
    NoUnit { found: String, example: &'static str, allowed: String },
    /// A unit that is unknown or measures something else.
    #[error("unit '{unit}' in '{found}' does not fit here; allowed: {allowed}")]
    WrongUnit { found: String, unit: String, allowed: String },
    /// Text where a number is due, or a number that is not finite.
    #[error("'{found}' is not a finite number with a unit; write for example '12.5 {example}'")]
    NotANumber { found: String, example: &'static str },
}

/// Reads a quantity such as `34.2 um`; returns mm for lengths and rad for angles.
pub fn parse_quantity(text: &str, measure: Measure) -> Result<f64, QuantityError> {
    let text = text.trim();
    let example = measure.output_unit();
    let not_a_number = || QuantityError::NotANumber { found: text.to_string(), example };
    let split = number_length(text);
    if split == 0 {
        return Err(not_a_number());
    }
    let value: f64 = text[..split].parse().map_err(|_| not_a_number())?;
    if !value.is_finite() {
        return Err(not_a_number());
    }
    let unit = text[split..].trim();
    let allowed = || {
        let names: Vec<&str> = measure.units().iter().map(|(name, _)| *name).collect();
        names.join(", ")
    };
    if unit.is_empty() {
        return Err(QuantityError::NoUnit { found: text.to_string(), example, allowed: allowed() });
    }
    match measure.units().iter().find(|(name, _)| *name == unit) {
        Some((_, factor)) => Ok(value * factor),
        None => Err(QuantityError::WrongUnit { found: text.to_string(), unit: unit.to_string(), allowed: allowed() }),
    }
}

/// Length in bytes of the number at the start of `text`, exponent included ("1e-3 mm" but not the m of "1 m").
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut at = 0;
    let digits = |at: &mut usize| {
        let from = *at;
        while *at < bytes.len() && (bytes[*at].is_ascii_digit() || bytes[*at] == b'.') {
            *at += 1;
        }
        *at > from
    };
    if at < bytes.len() && (bytes[at] == b'+' || bytes[at] == b'-') {
        at += 1;
    }
    if !digits(&mut at) {
        return 0;
    }
    if at < bytes.len() && (bytes[at] == b'e' || bytes[at] == b'E') {
        let mut exponent = at + 1;
        if exponent < bytes.len() && (bytes[exponent] == b'+' || bytes[exponent] == b'-') {
            exponent += 1;
        }
        if digits(&mut exponent) {
            at = exponent;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_carry_their_unit() {
        let length = |text| parse_quantity(text, Measure::Length);
        let angle = |text| parse_quantity(text, Measure::Angle);
        assert_eq!(length("34.2 um").unwrap(), 34.2e-3);
        assert_eq!(length("-0.0525mm").unwrap(), -0.0525);
        assert_eq!(length("1e-3 mm").unwrap(), 1e-3);
        assert!((angle("3600 arcsec").unwrap() - PI / 180.0).abs() < 1e-16);
        assert!((angle("0.01 deg").unwrap() - 0.01 * PI / 180.0).abs() < 1e-18);
        assert!(matches!(length("34.2"), Err(QuantityError::NoUnit { .. })));
        assert!(matches!(length("3 arcsec"), Err(QuantityError::WrongUnit { .. })));
        assert!(matches!(length("nan um"), Err(QuantityError::NotANumber { .. })));
        assert!(matches!(length("1e999 um"), Err(QuantityError::NotANumber { .. })));
    }
}
