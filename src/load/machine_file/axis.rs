//! One axis of a machine file: kind, line, range and errors. The chain's order is read in `machine`.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::Deserialize;

use super::component_form::{FormFile, component_form};
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::{finite, quantity, unit_vector};
use crate::machine::{Axis, AxisKind, Component, ComponentError, ErrorName, letter_axis};
use crate::units::shown;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(crate) struct AxisFile {
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

/// The kind of an axis: the one that its letter has, or the one that is stated where its name is no letter.
fn axis_kind(document: &Document, stated: Option<KindFile>, name: &str) -> Result<AxisKind, LoadError> {
    let at = [Step::Key("axes"), Step::Key(name), Step::Key("type")];
    let stated = stated.map(|stated| match stated {
        KindFile::Linear => AxisKind::Linear,
        KindFile::Rotary => AxisKind::Rotary,
    });
    let found = match (stated, letter_axis(name)) {
        (Some(kind), None) => return Ok(kind),
        (Some(stated), Some((kind, _))) if stated != kind => {
            let (is, other) = match kind {
                AxisKind::Linear => ("linear", "a rotary one is A, B or C"),
                AxisKind::Rotary => ("rotary", "a linear one is X, Y, Z, U, V or W"),
            };
            format!("axis {name} is {is} by its letter (ISO 841); {other}, or has a longer name, as in R1")
        }
        (_, Some((kind, _))) => return Ok(kind),
        (None, None) => {
            format!("axis '{name}' is no letter X Y Z A B C U V W, so it needs a type: linear or rotary")
        }
    };
    Err(document.refuse(&at, found))
}

/// Reads one axis; `names` are all axes of the chain.
pub(crate) fn axis(document: &Document, file: &AxisFile, name: &str, names: &[&str]) -> Result<Axis, LoadError> {
    let at = |key| [Step::Key("axes"), Step::Key(name), Step::Key(key)];
    let letter = letter_axis(name);
    let kind = axis_kind(document, file.kind, name)?;
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
    let mut stated: Vec<Component> = Vec::new();
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
        if stated.contains(&error.component) {
            return Err(document.refuse(&place, format!("{error} stands twice in different spellings; keep one")));
        }
        stated.push(error.component);
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
        let form = component_form(document, &place, form, kind, error.component.measure())?;
        if axis.component_errors.iter().any(|other| other.component == error.component) {
            return Err(document.refuse(&place, format!("{error} stands twice in different spellings; keep one")));
        }
        axis.component_errors.push(ComponentError { component: error.component, form });
    }
    axis.component_errors.sort_by_key(|error| error.component);
    Ok(axis)
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
        return Err(document.refuse(
            place,
            format!(
                "range [{}, {}] is upside down or empty; write the lower end first, as in [-120, 30]",
                shown(from),
                shown(to)
            ),
        ));
    }
    Ok((kind.from_file_unit(from), kind.from_file_unit(to)))
}
