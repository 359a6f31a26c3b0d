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

impl Parameter {
    /// The name without what explains it: `MD24558`, `19703`.
    pub fn short_name(&self) -> &str {
        self.name.strip_prefix("No. ").unwrap_or(&self.name)
    }

    /// Whether a name means this parameter: in full, its number alone, or its first word.
    pub fn is_called(&self, name: &str) -> bool {
        let first = self.short_name().split_whitespace().next();
        name == self.name || name == self.short_name() || Some(name) == first
    }
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
        (Control::LinuxCnc, Some((fitted, nominal))) => pins(machine, numbers, fitted, nominal),
        (Control::LinuxCnc, None) => Vec::new(),
        _ => summed(
            numbers
                .iter()
                .filter(|number| number.determined)
                .flat_map(|number| named(control, machine, number))
                .collect(),
        ),
    }
}

/// One entry for each parameter: a vector that closes a chain takes the changes of all others.
fn summed(list: Vec<Parameter>) -> Vec<Parameter> {
    let mut sums: Vec<Parameter> = Vec::new();
    for one in list {
        match sums.iter_mut().find(|sum| sum.name == one.name) {
            Some(sum) => {
                sum.change += one.change;
                sum.sigma = sum.sigma.hypot(one.sigma);
            }
            None => sums.push(one),
        }
    }
    sums
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
///
/// Places have values in machine coordinates only: without the machine file's `machine_zero` their changes alone are told.
fn pins(machine: &Machine, numbers: &[Number], fitted: &Module, nominal: &Module) -> Vec<Parameter> {
    let is_stated = |slide: &str| machine.axis_index(slide).is_some_and(|axis| machine.machine_zero[axis].is_some());
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
        let is_known = match *pin {
            "pivot-length" => false,
            "x-rot-point" => is_stated("X"),
            "y-rot-point" => is_stated("Y"),
            "z-rot-point" => is_stated("Z"),
            _ => true,
        };
        let value = is_known.then_some(*value);
        let meaning = match *pin {
            "pivot-length" => "from the tilting axis to the spindle ball".to_string(),
            "x-offset" | "y-offset" => "from C's line to the tilting axis's line".to_string(),
            _ => "line in machine coordinates".to_string(),
        };
        Some(Parameter { name: format!("{}.{pin}", fitted.name), meaning, change, sigma, value, is_angle: false })
    });
    list.collect()
}
