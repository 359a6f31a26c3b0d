//! Names of causes, components and units in the words of the trade. It weighs nothing.

use super::selected::Candidate;
use crate::diagnose::cause::Cause;
use crate::diagnose::model::linear_model::{Term, display};
use crate::effects::{Driver, Signature, kind, signature};
use crate::machine::{AxisKind, Component, Effect, ErrorName, Machine, Outlet, ParameterValue};
use crate::units::Measure;

/// Drivers that look alike where one place is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DriverClass {
    Position,
    Direction,
    Time,
    Speed,
    Constant,
}

pub(crate) fn driver_class(driver: Driver) -> DriverClass {
    match driver {
        Driver::Position | Driver::Gravity | Driver::Load => DriverClass::Position,
        Driver::Direction => DriverClass::Direction,
        Driver::Time | Driver::Temperature | Driver::Event => DriverClass::Time,
        Driver::Speed => DriverClass::Speed,
        Driver::Constant => DriverClass::Constant,
    }
}

/// Driver of a candidate: free curves have theirs as a parameter.
pub(crate) fn candidate_driver(candidate: &Candidate) -> Driver {
    let named = |name: &str| match candidate.effect.parameter(name) {
        Some(ParameterValue::Word(word)) => Some(word.clone()),
        _ => None,
    };
    match (signature(&candidate.effect.kind), named("driver").as_deref(), named("channel")) {
        (Some(Signature::FreeCurve), Some("direction"), _) => Driver::Direction,
        // a curve of its own in every run repeats with nothing
        (Some(Signature::FreeCurve), ..) if candidate.differs_by_test() => Driver::Time,
        (Some(Signature::FreeCurve), Some("time" | "run"), _) => Driver::Time,
        // heat drives a growth that runs out, whether or not a thermometer was read
        (Some(Signature::Growth), _, _) | (Some(Signature::BarLength), _, Some(_)) => Driver::Temperature,
        (Some(Signature::BarLength), _, None) if candidate.effect.parameter("tau").is_some() => Driver::Temperature,
        _ => kind(&candidate.effect.kind).map_or(Driver::Position, |kind| kind.driver),
    }
}

pub(crate) fn cause(machine: &Machine, candidate: &Candidate, effects: &[Effect]) -> Cause {
    let mut components = components(machine, &candidate.terms);
    // the motions that matter: at least a tenth of the largest, in display units
    let weight = |name: &String| -> f64 {
        effects
            .iter()
            .flat_map(|effect| &effect.sizes)
            .filter(|size| component_name(machine, &size.outlet) == *name)
            .map(|size| (size.value * display(size.outlet.measure(machine))).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    components.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    let largest = components.first().map_or(0.0, weight);
    components.retain(|name| weight(name) >= 0.1 * largest);
    Cause {
        effect: candidate.effect.kind.clone(),
        driver: candidate_driver(candidate),
        place: candidate.effect.place.name(machine).to_string(),
        components,
    }
}

/// Cause of an effect through some outlets.
pub fn cause_of(machine: &Machine, effect: &Effect, outlets: &[Outlet]) -> Cause {
    let driver = kind(&effect.kind).map_or(Driver::Position, |kind| kind.driver);
    let components = outlets.iter().map(|outlet| component_name(machine, outlet)).collect();
    Cause { effect: effect.kind.clone(), driver, place: effect.place.name(machine).to_string(), components }
}

pub(crate) fn components(machine: &Machine, terms: &[Term]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    // what all slides do beside a lag is no motion of its axis
    let is_common = |term: &Term| matches!(term.outlet, Outlet::SlidesAcceleration { .. });
    let only_common = terms.iter().all(is_common);
    for term in terms.iter().filter(|term| only_common || !is_common(term)) {
        for outlet in term.outlets() {
            let name = component_name(machine, &outlet);
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

/// ISO name of what an outlet moves.
pub(crate) fn component_name(machine: &Machine, outlet: &Outlet) -> String {
    let axis_name = |axis: usize| machine.axes[axis].name.clone();
    match *outlet {
        Outlet::Pivot(k) => format!("pivot-{}", ["x", "y", "z"][k]),
        Outlet::SpindleBall(k) => format!("spindle-ball-{}", ["x", "y", "z"][k]),
        Outlet::Reading => "length".into(),
        Outlet::SlidesAcceleration { .. } => "slides".into(),
        Outlet::Lag { axis } | Outlet::Acceleration { axis } | Outlet::Along { axis } => {
            let name = axis_name(axis);
            // an axis named A, B, C, X, Y or Z has its own motion by its name, wherever it points
            let named = Component::ALL.into_iter().find(|component| {
                let rotary = machine.axes[axis].kind == AxisKind::Rotary;
                let letters = if rotary { ["A", "B", "C"] } else { ["X", "Y", "Z"] };
                component.is_angle() == rotary && letters[component.direction_index()] == name
            });
            let own: Component = named.unwrap_or(machine.axes[axis].own_component());
            ErrorName::motion(own, &name).to_string()
        }
        Outlet::Delay => "delay".into(),
        Outlet::Motion { axis, component } => ErrorName::motion(component, &axis_name(axis)).to_string(),
        Outlet::Location { axis, component } => ErrorName::location(component, &axis_name(axis)).to_string(),
    }
}

/// Unit of a measure in findings.
pub fn unit(measure: Measure) -> &'static str {
    match measure {
        Measure::Length | Measure::LengthPerKelvin | Measure::LengthPerLoad => "um",
        Measure::Angle | Measure::AnglePerKelvin | Measure::AnglePerLoad => "arcsec",
        Measure::Strain => "um/m",
        Measure::Time => "ms",
        Measure::TimeSquared => "us2",
    }
}
