//! Machine files (YAML, see docs/formats.md) to a [`Machine`]; URDF has its own reader.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector3;
use serde::Deserialize;

use super::document::{Document, Step};
use super::message::LoadError;
use super::text::{MAX_YAML_BYTES, read_limited};
use crate::machine::{Axis, AxisKind, ComponentError, ComponentForm, ErrorName, Harmonic, Machine, StructuralCode};
use crate::units::{Measure, parse_quantity};

/// Most axes that a chain may have.
const MAX_AXES: usize = 24;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MachineFile {
    name: String,
    code: Option<String>,
    chain: Option<Vec<String>>,
    axes: BTreeMap<String, AxisFile>,
    gravity: Option<[f64; 3]>,
    #[serde(default)]
    machine_zero: BTreeMap<String, f64>,
    gauge_length: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisFile {
    #[serde(rename = "type")]
    kind: Option<KindFile>,
    direction: Option<[f64; 3]>,
    origin: Option<[f64; 3]>,
    range: Option<[f64; 2]>,
    #[serde(default)]
    reversed: bool,
    #[serde(default)]
    errors: BTreeMap<String, serde_yaml::Value>,
    #[serde(default)]
    component_errors: BTreeMap<String, FormFile>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum KindFile {
    Linear,
    Rotary,
}

/// Form of a component error in a file; coefficients are quantities per mm^k or deg^k.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FormFile {
    polynomial: Option<Vec<String>>,
    fourier: Option<Vec<HarmonicFile>>,
    table: Option<Vec<(f64, String)>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HarmonicFile {
    /// Periods per turn (rotary).
    per_turn: Option<f64>,
    /// Period, mm (linear).
    period: Option<f64>,
    cos: Option<String>,
    sin: Option<String>,
}

/// Reads a machine file.
pub fn load_machine(file: &Path) -> Result<Machine, LoadError> {
    machine_from_yaml(file, read_limited(file, MAX_YAML_BYTES)?)
}

/// Reads the text of a machine file; `file` is its name in messages.
pub fn machine_from_yaml(file: &Path, text: String) -> Result<Machine, LoadError> {
    let document = Document::parse(file, text)?;
    let raw: MachineFile = document.read()?;
    let code = structural_code(&document, &raw)?;
    let names: Vec<String> = code.axis_names().cloned().collect();
    if names.len() > MAX_AXES {
        return Err(
            document.refuse(&[Step::Key("chain")], format!("{} axes; at most {MAX_AXES} are allowed", names.len()))
        );
    }
    for name in raw.axes.keys() {
        if !names.contains(name) {
            return Err(document.refuse(
                &[Step::Key("axes"), Step::Key(name)],
                format!("axis '{name}' does not stand in the code {code}; its axes are {}", names.join(" ")),
            ));
        }
    }
    let all: Vec<&str> = names.iter().map(String::as_str).collect();
    let axes = names.iter().map(|name| axis(&document, &raw, name, &all)).collect::<Result<Vec<_>, _>>()?;
    let gravity = unit_vector(&document, &[Step::Key("gravity")], "gravity", raw.gravity.unwrap_or([0.0, 0.0, -1.0]))?;
    let mut machine_zero = vec![None; axes.len()];
    for (name, value) in &raw.machine_zero {
        let place = [Step::Key("machine_zero"), Step::Key(name)];
        let index = names.iter().position(|other| other == name).ok_or_else(|| {
            document.refuse(
                &place,
                format!(
                    "machine_zero names the axis '{name}', which the machine has not; its axes are {}",
                    names.join(" ")
                ),
            )
        })?;
        machine_zero[index] = Some(finite(&document, &place, *value)?);
    }
    let gauge_length_mm =
        raw.gauge_length.map(|value| finite(&document, &[Step::Key("gauge_length")], value)).transpose()?;
    Ok(Machine {
        name: raw.name,
        code,
        axes,
        gravity,
        machine_zero,
        gauge_length_mm,
        link_names: Vec::new(),
        effects: Vec::new(),
    })
}

fn structural_code(document: &Document, raw: &MachineFile) -> Result<StructuralCode, LoadError> {
    match (&raw.code, &raw.chain) {
        (Some(code), None) => {
            StructuralCode::parse(code).map_err(|why| document.refuse(&[Step::Key("code")], why.to_string()))
        }
        (None, Some(chain)) => chain_code(document, chain),
        (Some(_), Some(_)) => {
            Err(document.refuse(&[Step::Key("chain")], "both 'code' and 'chain' are given; keep one"))
        }
        (None, None) => {
            Err(document.refuse(&[], "neither 'code' nor 'chain' is given; write for example code: \"[wCAYbXZt]\""))
        }
    }
}

/// `[w, b, J1, J2, t]`: names of any length.
fn chain_code(document: &Document, chain: &[String]) -> Result<StructuralCode, LoadError> {
    let refuse = |index: usize, message: String| document.refuse(&[Step::Key("chain"), Step::Index(index)], message);
    if chain.first().map(String::as_str) != Some("w")
        || chain.last().map(String::as_str) != Some("t")
        || chain.len() < 3
    {
        return Err(refuse(
            0,
            "a chain starts with w (workpiece) and ends with t (tool), as in [w, b, J1, J2, t]".into(),
        ));
    }
    let mut sides: [Vec<String>; 2] = [Vec::new(), Vec::new()];
    let mut bed_seen = false;
    for (index, name) in chain.iter().enumerate().take(chain.len() - 1).skip(1) {
        match name.as_str() {
            "b" if bed_seen => return Err(refuse(index, "the bed b stands twice; it stands once".into())),
            "b" => bed_seen = true,
            "w" | "t" => return Err(refuse(index, format!("'{name}' stands inside the chain; it is an end"))),
            _ if sides.iter().flatten().any(|other| other == name) => {
                return Err(refuse(index, format!("axis '{name}' stands twice; each axis stands once")));
            }
            _ => sides[usize::from(bed_seen)].push(name.clone()),
        }
    }
    if !bed_seen {
        return Err(refuse(
            0,
            "the bed b is missing; write it between workpiece and tool axes, as in [w, b, J1, J2, t]".into(),
        ));
    }
    let [workpiece_side, tool_side] = sides;
    Ok(StructuralCode { workpiece_side, tool_side })
}

fn axis(document: &Document, raw: &MachineFile, name: &str, names: &[&str]) -> Result<Axis, LoadError> {
    let at = |key| [Step::Key("axes"), Step::Key(name), Step::Key(key)];
    let missing = AxisFile {
        kind: None,
        direction: None,
        origin: None,
        range: None,
        reversed: false,
        errors: BTreeMap::new(),
        component_errors: BTreeMap::new(),
    };
    let file = raw.axes.get(name).unwrap_or(&missing);
    let letter = letter_axis(name);
    let kind = match (file.kind, letter) {
        (Some(KindFile::Linear), _) => AxisKind::Linear,
        (Some(KindFile::Rotary), _) => AxisKind::Rotary,
        (None, Some((kind, _))) => kind,
        (None, None) => {
            return Err(document.refuse(
                &at("type"),
                format!("axis '{name}' is no letter X Y Z A B C U V W, so it needs a type: linear or rotary"),
            ));
        }
    };
    let direction = match (file.direction, letter) {
        (Some(direction), _) => unit_vector(document, &at("direction"), "direction", direction)?,
        (None, Some((_, direction))) => direction,
        (None, None) => {
            return Err(document.refuse(
                &at("direction"),
                format!("axis '{name}' is no letter X Y Z A B C U V W, so it needs a direction, e.g. [0, 0, 1]"),
            ));
        }
    };
    let origin = file.origin.unwrap_or_default();
    for value in origin {
        finite(document, &at("origin"), value)?;
    }
    let range = file.range.map(|range| axis_range(document, &at("range"), kind, range)).transpose()?;
    let mut axis = Axis {
        name: name.to_string(),
        kind,
        direction,
        origin: Vector3::from(origin),
        range,
        reversed: file.reversed,
        location_errors: [0.0; 6],
        component_errors: Vec::new(),
    };
    for (key, value) in &file.errors {
        let place = [Step::Key("axes"), Step::Key(name), Step::Key("errors"), Step::Key(key)];
        let error = own_error(document, &place, key, &axis, names)?;
        if !error.is_location {
            return Err(document.refuse(
                &place,
                format!(
                    "{error} is a component error, a function of position; write it under component_errors, or {} for the location error",
                    ErrorName::location(error.component, name)
                ),
            ));
        }
        axis.location_errors[error.component.index()] = quantity(document, &place, value, error.component.measure())?;
    }
    for (key, form) in &file.component_errors {
        let place = [Step::Key("axes"), Step::Key(name), Step::Key("component_errors"), Step::Key(key)];
        let error = own_error(document, &place, key, &axis, names)?;
        if error.is_location {
            return Err(
                document.refuse(&place, format!("{error} is a location error, a constant; write it under errors"))
            );
        }
        let form = component_form(document, &place, form, &axis, error.component.measure())?;
        axis.component_errors.push(ComponentError { component: error.component, form });
    }
    Ok(axis)
}

/// Kind and direction that a letter implies.
fn letter_axis(name: &str) -> Option<(AxisKind, Vector3<f64>)> {
    let kind = match name {
        "X" | "Y" | "Z" | "U" | "V" | "W" => AxisKind::Linear,
        "A" | "B" | "C" => AxisKind::Rotary,
        _ => return None,
    };
    let direction = match name {
        "X" | "U" | "A" => Vector3::x(),
        "Y" | "V" | "B" => Vector3::y(),
        _ => Vector3::z(),
    };
    Some((kind, direction))
}

fn own_error(
    document: &Document,
    place: &[Step],
    key: &str,
    axis: &Axis,
    names: &[&str],
) -> Result<ErrorName, LoadError> {
    let error = ErrorName::parse(key, names).map_err(|why| document.refuse(place, why.to_string()))?;
    if error.axis != axis.name {
        return Err(document.refuse(
            place,
            format!("{error} belongs to axis {} but stands under axis {}; move it", error.axis, axis.name),
        ));
    }
    Ok(error)
}

fn axis_range(
    document: &Document,
    place: &[Step],
    kind: AxisKind,
    [from, to]: [f64; 2],
) -> Result<(f64, f64), LoadError> {
    finite(document, place, from)?;
    finite(document, place, to)?;
    if from >= to {
        return Err(
            document.refuse(place, format!("range [{from}, {to}] is upside down or empty; write the lower end first"))
        );
    }
    Ok((kind.from_file_unit(from), kind.from_file_unit(to)))
}

fn unit_vector(document: &Document, place: &[Step], what: &str, value: [f64; 3]) -> Result<Vector3<f64>, LoadError> {
    for component in value {
        finite(document, place, component)?;
    }
    Vector3::from(value).try_normalize(1e-6).ok_or_else(|| {
        document.refuse(
            place,
            format!("{what} [{}, {}, {}] has no length; give a vector such as [0, 0, 1]", value[0], value[1], value[2]),
        )
    })
}

/// A finite number, or a refusal.
pub(super) fn finite(document: &Document, place: &[Step], value: f64) -> Result<f64, LoadError> {
    if value.is_finite() { Ok(value) } else { Err(document.refuse(place, format!("'{value}' is not a finite number"))) }
}

/// A quantity with a unit; a bare number is refused.
pub(super) fn quantity(
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
    parse_quantity(&text, measure).map_err(|why| document.refuse(place, why.to_string()))
}

fn component_form(
    document: &Document,
    place: &[Step],
    form: &FormFile,
    axis: &Axis,
    measure: Measure,
) -> Result<ComponentForm, LoadError> {
    let value = |text: &String| parse_quantity(text, measure).map_err(|why| document.refuse(place, why.to_string()));
    match (&form.polynomial, &form.fourier, &form.table) {
        (Some(coefficients), None, None) => {
            // coefficients are per mm^k or deg^k in the file, per mm^k or rad^k inside
            let per_unit = axis.kind.to_file_unit(1.0);
            let mut power = 1.0;
            let scaled = coefficients.iter().map(|text| {
                power *= per_unit;
                Ok(value(text)? * power)
            });
            Ok(ComponentForm::Polynomial(scaled.collect::<Result<_, LoadError>>()?))
        }
        (None, Some(harmonics), None) => {
            let harmonics = harmonics.iter().map(|h| {
                let frequency = match (h.per_turn, h.period, axis.kind) {
                    (Some(per_turn), None, AxisKind::Rotary) => per_turn,
                    (None, Some(period), AxisKind::Linear) if period > 0.0 => std::f64::consts::TAU / period,
                    (None, Some(period), AxisKind::Rotary) if period > 0.0 => 360.0 / period,
                    _ => {
                        return Err(document.refuse(
                            place,
                            "a harmonic has 'per_turn: 2' (rotary axis) or 'period: 10' (mm, or deg for a rotary axis), above zero",
                        ));
                    }
                };
                let amplitude = |text: &Option<String>| text.as_ref().map_or(Ok(0.0), value);
                Ok(Harmonic { frequency: finite(document, place, frequency)?, cosine: amplitude(&h.cos)?, sine: amplitude(&h.sin)? })
            });
            Ok(ComponentForm::Fourier(harmonics.collect::<Result<_, LoadError>>()?))
        }
        (None, None, Some(rows)) => {
            let mut position = Vec::with_capacity(rows.len());
            let mut values = Vec::with_capacity(rows.len());
            for (at, text) in rows {
                let at = axis.kind.from_file_unit(finite(document, place, *at)?);
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
