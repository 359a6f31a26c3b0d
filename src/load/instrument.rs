//! Data files of length gauges (YAML, see docs/formats.md) to an [`Instrument`]. No recordings.

use std::path::Path;

use serde::Deserialize;

use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::YAML_BYTES;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::{finite, quantity};
use crate::load::checked_text::text::read_limited;
use crate::simulate::Instrument;
use crate::units::{Measure, shown};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InstrumentFile {
    /// For people.
    #[serde(rename = "name")]
    _name: String,
    resolution: Option<serde_yaml::Value>,
    stroke: Option<[f64; 2]>,
    noise: Option<NoiseFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoiseFile {
    white: Option<serde_yaml::Value>,
    correlated: Option<serde_yaml::Value>,
    correlation_time: Option<f64>,
    drift: Option<serde_yaml::Value>,
}

/// Largest noise or resolution of an instrument worth the name, mm.
const LARGEST_MM: f64 = 1.0;

/// Reads an instrument file; what it does not state is zero (noise, resolution) or without limit (stroke).
pub fn load_instrument(file: &Path) -> Result<Instrument, LoadError> {
    let document = Document::parse(file, read_limited(file, YAML_BYTES)?)?;
    let raw: InstrumentFile = document.read()?;
    let length = |place: &[Step], value: &Option<serde_yaml::Value>| -> Result<f64, LoadError> {
        let Some(value) = value else { return Ok(0.0) };
        let length_mm = quantity(&document, place, value, Measure::Length)?;
        if (0.0..=LARGEST_MM).contains(&length_mm) {
            return Ok(length_mm);
        }
        Err(document.refuse(place, format!("{} mm is not allowed; 0 to {LARGEST_MM} mm are", shown(length_mm))))
    };
    let stroke_mm = match raw.stroke {
        None => (f64::NEG_INFINITY, f64::INFINITY),
        Some([from, to]) => {
            let place = [Step::Key("stroke")];
            let (from, to) = (finite(&document, &place, from)?, finite(&document, &place, to)?);
            if from >= 0.0 || to <= 0.0 {
                return Err(document.refuse(
                    &place,
                    format!(
                        "stroke [{}, {}] does not hold the bar's length; write for example [-1, 1] (mm)",
                        shown(from),
                        shown(to)
                    ),
                ));
            }
            (from, to)
        }
    };
    let mut instrument = Instrument {
        resolution_mm: length(&[Step::Key("resolution")], &raw.resolution)?,
        stroke_mm,
        white_mm: 0.0,
        correlated_mm: 0.0,
        correlation_time_s: 1.0,
        drift_mm_per_sqrt_s: 0.0,
    };
    let Some(noise) = &raw.noise else { return Ok(instrument) };
    let place = |key| [Step::Key("noise"), Step::Key(key)];
    instrument.white_mm = length(&place("white"), &noise.white)?;
    instrument.correlated_mm = length(&place("correlated"), &noise.correlated)?;
    instrument.drift_mm_per_sqrt_s = length(&place("drift"), &noise.drift)?;
    match noise.correlation_time {
        Some(time_s) if time_s.is_finite() && time_s > 0.0 => instrument.correlation_time_s = time_s,
        Some(time_s) => {
            let place = place("correlation_time");
            return Err(document.refuse(&place, format!("{} is no time; write seconds above 0", shown(time_s))));
        }
        None if instrument.correlated_mm > 0.0 => {
            return Err(document.refuse(
                &place("correlated"),
                "correlated noise needs a correlation_time in seconds; add for example 'correlation_time: 1.2'",
            ));
        }
        None => {}
    }
    Ok(instrument)
}
