//! One effect as an entry of a machine file's `effects:` list: reading back gives the same values.

use std::fmt::Write as _;

use super::yaml_text::text;
use crate::effects::{ParameterUnit, kind};
use crate::machine::{Effect, Machine, Outlet, ParameterValue};
use crate::report::wording::number::{position, quantity};

/// An entry of the list, indented to stand under `effects:`.
pub fn effect_yaml(machine: &Machine, effect: &Effect) -> String {
    let mut out = format!("  - effect: {}\n    place: {}\n", text(&effect.kind), text(effect.place.name(machine)));
    for (name, value) in &effect.parameters {
        let _ = writeln!(out, "    {name}: {}", parameter(machine, effect, name, value));
    }
    if let Some(tests) = &effect.tests {
        let names: Vec<String> = tests.iter().map(|name| text(name)).collect();
        let _ = writeln!(out, "    tests: [{}]", names.join(", "));
    }
    if let Some(rival) = &effect.cannot_tell_from {
        let _ = writeln!(out, "    cannot_tell_from: {}", text(rival));
    }
    let mut outlets: Vec<Outlet> = Vec::new();
    for size in &effect.sizes {
        if !outlets.contains(&size.outlet) {
            outlets.push(size.outlet);
        }
    }
    let sizes: Vec<String> = outlets
        .iter()
        .map(|outlet| format!("{}: {}", text(&outlet.name(machine)), amounts(machine, effect, outlet)))
        .collect();
    let _ = writeln!(out, "    sizes: {{{}}}", sizes.join(", "));
    out
}

fn parameter(machine: &Machine, effect: &Effect, name: &str, value: &ParameterValue) -> String {
    let unit = kind(&effect.kind).and_then(|kind| kind.parameters.iter().find(|parameter| parameter.name == name));
    let is_position = unit.is_some_and(|parameter| parameter.unit == ParameterUnit::Position);
    let axis = effect.place.axis().filter(|_| is_position);
    let number = |value: f64| axis.map_or(value, |axis| position(machine.axes[axis].kind, value)).to_string();
    match value {
        ParameterValue::Number(value) => number(*value),
        ParameterValue::List(values) => {
            let list: Vec<String> = values.iter().map(|&value| number(value)).collect();
            format!("[{}]", list.join(", "))
        }
        ParameterValue::Word(word) => text(word),
    }
}

/// `3 um`, or `{cos2: 3 um, sin2: 1 um}` when the effect has several functions.
fn amounts(machine: &Machine, effect: &Effect, outlet: &Outlet) -> String {
    let amount = |function: &str, value: f64| {
        let measure = kind(&effect.kind)
            .map_or_else(|| outlet.measure(machine), |kind| (kind.measure)(machine, outlet, function));
        quantity(measure, value)
    };
    let own: Vec<_> = effect.sizes.iter().filter(|size| size.outlet == *outlet).collect();
    match own.as_slice() {
        [single] if single.function.is_empty() => amount("", single.value),
        several => {
            let list: Vec<String> = several
                .iter()
                .map(|size| format!("{}: {}", text(&size.function), amount(&size.function, size.value)))
                .collect();
            format!("{{{}}}", list.join(", "))
        }
    }
}
