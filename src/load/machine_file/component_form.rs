//! Component errors of a machine file: polynomial, Fourier or table text to a [`ComponentForm`]. The axis itself is read in `axis`.

use serde::Deserialize;

use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::{FORM_TERMS, TABLE_ROWS};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::{finite, quantity};
use crate::machine::{AxisKind, ComponentForm, Harmonic};
use crate::units::Measure;

/// Form of a component error in a file; coefficients are quantities per mm^k or deg^k.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FormFile {
    polynomial: Option<Vec<serde_yaml::Value>>,
    fourier: Option<Vec<HarmonicFile>>,
    table: Option<Vec<(f64, serde_yaml::Value)>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HarmonicFile {
    /// Periods per turn (rotary).
    per_turn: Option<f64>,
    /// Period, mm (linear).
    period: Option<f64>,
    cos: Option<serde_yaml::Value>,
    sin: Option<serde_yaml::Value>,
}

/// The form of one component error; `place` is its key in the file.
pub(crate) fn component_form(
    document: &Document,
    place: &[Step],
    form: &FormFile,
    kind: AxisKind,
    measure: Measure,
) -> Result<ComponentForm, LoadError> {
    let value = |text: &serde_yaml::Value| quantity(document, place, text, measure);
    let terms = form.polynomial.as_ref().map_or(0, Vec::len).max(form.fourier.as_ref().map_or(0, Vec::len));
    let rows = form.table.as_ref().map_or(0, Vec::len);
    if let Some(message) = FORM_TERMS.exceeded(terms).or_else(|| TABLE_ROWS.exceeded(rows)) {
        return Err(document.refuse(place, message));
    }
    match (&form.polynomial, &form.fourier, &form.table) {
        (Some(coefficients), None, None) => {
            // coefficients are per mm^k or deg^k in the file, per mm^k or rad^k inside
            let per_unit = kind.to_file_unit(1.0);
            let mut power = 1.0;
            let scaled = coefficients.iter().map(|text| {
                power *= per_unit;
                Ok(value(text)? * power)
            });
            Ok(ComponentForm::Polynomial(scaled.collect::<Result<_, LoadError>>()?))
        }
        (None, Some(harmonics), None) => {
            let harmonics = harmonics.iter().map(|h| {
                let frequency = match (h.per_turn, h.period, kind) {
                    (Some(per_turn), None, AxisKind::Rotary) if per_turn > 0.0 => per_turn,
                    (None, Some(period), AxisKind::Linear) if period > 0.0 => std::f64::consts::TAU / period,
                    (None, Some(period), AxisKind::Rotary) if period > 0.0 => 360.0 / period,
                    _ => {
                        return Err(document.refuse(
                            place,
                            "a harmonic has 'per_turn: 2' (rotary axis) or 'period: 10' (mm, or deg for a rotary axis), above zero",
                        ));
                    }
                };
                let amplitude = |text: &Option<serde_yaml::Value>| text.as_ref().map_or(Ok(0.0), value);
                Ok(Harmonic { frequency: finite(document, place, frequency)?, cosine: amplitude(&h.cos)?, sine: amplitude(&h.sin)? })
            });
            Ok(ComponentForm::Fourier(harmonics.collect::<Result<_, LoadError>>()?))
        }
        (None, None, Some(rows)) if rows.is_empty() => {
            Err(document.refuse(place, "the table is empty; write rows such as [-30, 1.5 um]"))
        }
        (None, None, Some(rows)) => {
            let mut position = Vec::with_capacity(rows.len());
            let mut values = Vec::with_capacity(rows.len());
            for (at, text) in rows {
                let at = kind.from_file_unit(finite(document, place, *at)?);
                if position.last().is_some_and(|&last| last >= at) {
                    return Err(document.refuse(place, "positions of a table rise from row to row"));
                }
                position.push(at);
                values.push(value(text)?);
            }
            Ok(ComponentForm::Table { position, value: values })
        }
        _ => Err(document.refuse(place, "give exactly one of polynomial, fourier, table")),
    }
}
