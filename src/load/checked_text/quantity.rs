//! Numbers, vectors and quantities of YAML files with refusals at their place; no keys of any format.

use nalgebra::Vector3;

use super::document::{Document, Step};
use super::message::LoadError;
use crate::units::{Measure, parse_quantity, shown};

/// How far the squared norm of a normalised vector can be from 1 by rounding.
const UNIT_TO_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Largest extent of anything in a machine file, mm.
const MAX_EXTENT_MM: f64 = 1e6;

/// A point in R, mm.
pub(crate) fn point(document: &Document, place: &[Step], value: &[f64; 3]) -> Result<Vector3<f64>, LoadError> {
    for &component in value {
        if finite(document, place, component)?.abs() > MAX_EXTENT_MM {
            return Err(document.refuse(place, format!("{} mm is beyond {MAX_EXTENT_MM} mm", shown(component))));
        }
    }
    Ok(Vector3::from(*value))
}

/// A vector made unit length; one of no length is refused.
pub(crate) fn unit_vector(
    document: &Document,
    place: &[Step],
    what: &str,
    value: [f64; 3],
) -> Result<Vector3<f64>, LoadError> {
    for component in value {
        finite(document, place, component)?;
    }
    let vector = Vector3::from(value);
    if (vector.norm_squared() - 1.0).abs() <= UNIT_TO_ROUNDING {
        // dividing by the norm again would only stir the last digit: a written file reads back unchanged
        return Ok(vector);
    }
    vector.try_normalize(1e-6).ok_or_else(|| {
        document.refuse(
            place,
            format!("{what} [{}, {}, {}] has no length; give a vector such as [0, 0, 1]", value[0], value[1], value[2]),
        )
    })
}

/// Largest number of a machine or session file: ten kilometres in mm.
pub(crate) const LARGEST: f64 = 1e7;

/// Largest geometric error, mm: zero points of axes included.
const LARGEST_LENGTH_MM: f64 = 1000.0;
/// Largest geometric error, rad: zero positions of joints included.
const LARGEST_ANGLE_RAD: f64 = std::f64::consts::PI;

/// A finite number of sensible size, or a refusal.
pub(crate) fn finite(document: &Document, place: &[Step], value: f64) -> Result<f64, LoadError> {
    if value.is_finite() && value.abs() <= LARGEST {
        Ok(value)
    } else {
        Err(document
            .refuse(place, format!("'{}' is not a finite number between -{LARGEST} and {LARGEST}", shown(value))))
    }
}

/// A quantity with a unit; a bare number is refused.
pub(crate) fn quantity(
    document: &Document,
    place: &[Step],
    value: &serde_yaml::Value,
    measure: Measure,
) -> Result<f64, LoadError> {
    let text = match value {
        serde_yaml::Value::String(text) => text.clone(),
        serde_yaml::Value::Number(number) => number.to_string(),
        _ => {
            return Err(
                document.refuse(place, format!("is no quantity; write for example '12.5 {}'", measure.output_unit()))
            );
        }
    };
    let value = parse_quantity(&text, measure).map_err(|why| document.refuse(place, why.to_string()))?;
    let largest = match measure {
        Measure::Length => LARGEST_LENGTH_MM,
        Measure::Angle => LARGEST_ANGLE_RAD,
        _ => LARGEST,
    };
    if value.abs() <= largest {
        return Ok(value);
    }
    Err(document.refuse(
        place,
        format!("'{text}' is larger than any geometric error (at most {LARGEST_LENGTH_MM} mm or half a turn); check its unit"),
    ))
}

/// A standard deviation of a setup, mm.
pub(crate) fn positive_length(
    document: &Document,
    place: &[Step],
    value: &serde_yaml::Value,
) -> Result<f64, LoadError> {
    let length = quantity(document, place, value, Measure::Length)?;
    if length > 0.0 && length <= 100.0 {
        Ok(length)
    } else {
        Err(document.refuse(place, "a spread is above zero and at most 100 mm"))
    }
}
