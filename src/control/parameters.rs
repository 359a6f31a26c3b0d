//! Parameters of the makers' controls for the numbers of a fit.
//!
//! Parameter numbers are those of the makers' manuals (SINUMERIK Operate commissioning manual 12/2017, swivelling, and
//! function manual five-axis transformation; FANUC Series 30i-A parameters, tool centre point control).

use super::linuxcnc::Module;
use super::numbers::{Number, What};
use crate::machine::Machine;

/// A control.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    LinuxCnc,
    Heidenhain,
    Sinumerik,
    Fanuc,
}

/// A change of one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name as the control has it.
    pub name: String,
    /// What it is, in words.
    pub meaning: String,
    /// To be added to the present value, mm; rad for directions.
    pub change: f64,
    pub sigma: f64,
    /// The value itself, where the machine file says all of it.
    pub value: Option<f64>,
    pub is_angle: bool,
}

const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// Changes for the determined numbers. `module` is LinuxCNC's with the lines of the fitted machine and of the nominal one.
pub fn parameters(
    control: Control,
    machine: &Machine,
    numbers: &[Number],
    module: Option<(&Module, &Module)>,
) -> Vec<Parameter> {
    match (control, module) {
        (Control::LinuxCnc, Some((fitted, nominal))) => pins(numbers, fitted, nominal),
        (Control::LinuxCnc, None) => Vec::new(),
        _ => numbers
            .iter()
            .filter(|number| number.determined)
            .flat_map(|number| named(control, machine, number))
            .collect(),
    }
}

/// Parameters of one number; none where the control does not hold it.
fn named(control: Control, machine: &Machine, number: &Number) -> Vec<Parameter> {
    let axis = &machine.axes[number.axis].name;
    let k = number.component;
    let along = COORDINATES[k];
    let is_table = number.axis < machine.code.workpiece_side.len();
    let of = |name: String, meaning: String, sign: f64| Parameter {
        name,
        meaning,
        change: sign * number.change,
        sigma: number.sigma,
        value: None,
        is_angle: number.what == What::Direction,
    };
    let carrier = |from: usize| machine.axes[from].name.as_str();
    match (control, number.what) {
        (Control::Heidenhain, What::TableCentre) => {
            vec![of(format!("kinematics description: place of {axis}, {along}"), format!("centre of {axis}"), 1.0)]
        }
        (Control::Heidenhain, What::Vector { from }) => vec![of(
            format!("kinematics description: shift from {} to {axis}, {along}", carrier(from)),
            format!("vector from {} to {axis}", carrier(from)),
            1.0,
        )],
        (Control::Heidenhain, What::Pivot) => vec![of(
            format!("kinematics description: shift from {axis} to the spindle, {along}"),
            format!("vector from {axis} to the spindle ball"),
            1.0,
        )],
        (Control::Sinumerik, What::TableCentre) => vec![
            of(format!("$TC_CARR{}", 4 + k), format!("I2, centre of {axis}, {along}"), 1.0),
            of(format!("$TC_CARR{}", 18 + k), format!("I4, which closes the chain, {along}"), -1.0),
            of(
                format!("MD24500 $MC_TRAFO5_PART_OFFSET_1[{k}]"),
                format!("centre of {axis}, {along} (transformation in place of CYCLE800)"),
                1.0,
            ),
        ],
        (Control::Sinumerik, What::Vector { from }) if is_table => vec![
            of(format!("$TC_CARR{}", 15 + k), format!("I3, vector from {} to {axis}, {along}", carrier(from)), 1.0),
            of(format!("$TC_CARR{}", 18 + k), format!("I4, which closes the chain, {along}"), -1.0),
            of(
                format!("MD24558 $MC_TRAFO5_JOINT_OFFSET_PART_1[{k}]"),
                format!("vector from {} to {axis}, {along} (transformation)", carrier(from)),
                1.0,
            ),
        ],
        (Control::Sinumerik, What::Vector { from }) => vec![
            of(format!("$TC_CARR{}", 4 + k), format!("I2, vector from {axis} to {}, {along}", carrier(from)), -1.0),
            of(format!("$TC_CARR{}", 1 + k), format!("I1, which closes the chain, {along}"), 1.0),
            of(
                format!("MD24560 $MC_TRAFO5_JOINT_OFFSET_1[{k}]"),
                format!("vector from {} to {axis}, {along} (transformation)", carrier(from)),
                1.0,
            ),
        ],
        (Control::Sinumerik, What::Pivot) => vec![
            of(format!("$TC_CARR{}", 15 + k), format!("I3, vector from the spindle to {axis}, {along}"), -1.0),
            of(format!("$TC_CARR{}", 1 + k), format!("I1, which closes the chain, {along}"), 1.0),
            of(
                format!("MD24550 $MC_TRAFO5_BASE_TOOL_1[{k}]"),
                format!("vector from {axis} to the spindle, {along} (transformation)"),
                1.0,
            ),
        ],
        (Control::Fanuc, What::TableCentre) => {
            vec![of(format!("No. {}", 19700 + k), format!("table centre of {axis}, {along}"), 1.0)]
        }
        (Control::Fanuc, What::Vector { from }) if is_table => {
            vec![of(format!("No. {}", 19703 + k), format!("vector from {} to {axis}, {along}", carrier(from)), 1.0)]
        }
        (Control::Fanuc, What::Vector { from }) => {
            vec![of(format!("No. {}", 19712 + k), format!("vector between {} and {axis}, {along}", carrier(from)), 1.0)]
        }
        (Control::Fanuc, What::Pivot) => {
            vec![of(format!("No. {}", 19709 + k), format!("vector between {axis} and the spindle, {along}"), 1.0)]
        }
        _ => Vec::new(),
    }
}

/// Pins of a LinuxCNC module; a pin stays when a number that it needs is not determined.
fn pins(numbers: &[Number], fitted: &Module, nominal: &Module) -> Vec<Parameter> {
    let shifts = |component: usize| numbers.iter().filter(move |number| number.component == component);
    let list = fitted.pins.iter().zip(&nominal.pins).filter_map(|((pin, value), (_, before))| {
        // which numbers a pin is made of
        let of: Vec<&Number> = match *pin {
            "x-rot-point" => shifts(0).filter(|number| number.what != What::Direction).collect(),
            "y-rot-point" => shifts(1).filter(|number| number.what != What::Direction).collect(),
            "x-offset" => shifts(0).filter(|number| matches!(number.what, What::Vector { .. })).collect(),
            "y-offset" => shifts(1).filter(|number| matches!(number.what, What::Vector { .. })).collect(),
            "z-rot-point" => shifts(2).filter(|number| number.what == What::TableCentre).collect(),
            "pivot-length" => shifts(2).filter(|number| number.what == What::Pivot).collect(),
            _ => return None,
        };
        if of.is_empty() || of.iter().any(|number| !number.determined) {
            return None;
        }
        // the ball below the axis: farther down is a longer pivot
        let change =
            if *pin == "pivot-length" { -of.iter().map(|number| number.change).sum::<f64>() } else { value - before };
        let sigma = of.iter().map(|number| number.sigma.powi(2)).sum::<f64>().sqrt();
        let value = (*pin != "pivot-length").then_some(*value);
        let meaning = match *pin {
            "pivot-length" => "from the tilting axis to the spindle ball".to_string(),
            "x-offset" | "y-offset" => "from C's line to the tilting axis's line".to_string(),
            _ => "line in machine coordinates".to_string(),
        };
        Some(Parameter { name: format!("{}.{pin}", fitted.name), meaning, change, sigma, value, is_angle: false })
    });
    list.collect()
}
