//! The budget of the linear axes in a machine file: a class or numbers with units. What it means is said in `machine`.

use serde_yaml::Value;

use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::message::{LoadError, did_you_mean};
use crate::load::checked_text::quantity::quantity;
use crate::machine::{LinearAxes, LinearClass};
use crate::units::Measure;

const KEY: Step = Step::Key("linear_axes");
const NUMBERS: [&str; 3] = ["positioning", "straightness", "squareness"];
/// Largest budget: 1 mm per metre and 1 mrad; a machine beyond it is to be set right, not measured.
const LARGEST_BUDGET: f64 = 1e-3;

/// `linear_axes: used`, or `linear_axes: {positioning: 8 um/m, straightness: 5 um/m, squareness: 15 urad}`.
pub(crate) fn linear_axes(document: &Document, raw: Option<&Value>) -> Result<LinearAxes, LoadError> {
    match raw {
        None => Ok(LinearAxes::default()),
        Some(Value::String(name)) => class(document, &[KEY], name),
        Some(Value::Mapping(numbers)) => {
            let mut budget = LinearAxes::default();
            for (key, value) in numbers {
                let name = key.as_str().unwrap_or_default();
                let place = [KEY, Step::Key(name)];
                let (target, measure) = match name {
                    "positioning" => (&mut budget.positioning, Measure::Strain),
                    "straightness" => (&mut budget.straightness, Measure::Strain),
                    "squareness" => (&mut budget.squareness_rad, Measure::Angle),
                    other => return Err(document.refuse(&[KEY], unknown(other, &NUMBERS))),
                };
                *target = quantity(document, &place, value, measure)?;
                if !(0.0..=LARGEST_BUDGET).contains(target) {
                    return Err(document.refuse(
                        &place,
                        format!(
                            "{name} is a standard deviation from 0 to 1000 um/m (positioning, straightness) or 1000 urad (squareness)"
                        ),
                    ));
                }
            }
            match NUMBERS.iter().find(|name| !numbers.contains_key(**name)) {
                Some(missing) => Err(document.refuse(
                    &[KEY],
                    format!(
                        "linear_axes lacks {missing}; write all three, e.g. {{positioning: 5 um/m, straightness: 5 um/m, squareness: 10 urad}}, or a class: {}",
                        classes().join(", ")
                    ),
                )),
                None => Ok(LinearAxes { class: None, is_stated: true, ..budget }),
            }
        }
        Some(_) => Err(document.refuse(
            &[KEY],
            format!(
                "linear_axes is no budget; write a class ({}) or {{positioning: 5 um/m, straightness: 5 um/m, squareness: 10 urad}}",
                classes().join(", ")
            ),
        )),
    }
}

fn classes() -> Vec<&'static str> {
    LinearClass::ALL.iter().map(|class| class.name()).collect()
}

fn class(document: &Document, place: &[Step], name: &str) -> Result<LinearAxes, LoadError> {
    let found = LinearClass::ALL.into_iter().find(|class| class.name() == name);
    found.map(LinearAxes::of).ok_or_else(|| document.refuse(place, unknown(name, &classes())))
}

fn unknown(found: &str, valid: &[&str]) -> String {
    let hint = did_you_mean(found, valid);
    format!("linear_axes has no '{found}'{hint} (allowed: {})", valid.join(", "))
}
