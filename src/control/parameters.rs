//! Parameters of the makers' controls for the numbers of a fit.
//!
//! Parameter numbers and the ends of vectors are those of the makers' manuals (SINUMERIK Operate commissioning manual 12/2017, swivelling, and
//! function manual five-axis transformation; FANUC Series 30i-A, tool centre point control for 5-axis machining, A-79348E).

use super::counting::sign_of_coordinate;
use super::linuxcnc::Module;
use super::numbers::{Number, What};
use crate::machine::{AxisKind, Machine};

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

    /// Names that mean this parameter: without what explains it, in full, and its first word.
    pub fn names(&self) -> [&str; 3] {
        let short = self.short_name();
        [short, &self.name, short.split_whitespace().next().unwrap_or(short)]
    }

    /// Whether a name means this parameter.
    pub fn is_called(&self, name: &str) -> bool {
        self.names().contains(&name)
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

/// The parameters that a control has for a machine, also those whose numbers the recordings do not determine.
pub fn all_parameters(
    control: Control,
    machine: &Machine,
    numbers: &[Number],
    module: Option<(&Module, &Module)>,
) -> Vec<Parameter> {
    let all: Vec<Number> = numbers.iter().map(|number| Number { determined: true, ..number.clone() }).collect();
    parameters(control, machine, &all, module)
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
    match control {
        Control::Heidenhain => heidenhain(machine, number),
        Control::Sinumerik => sinumerik(machine, number),
        Control::Fanuc => fanuc(machine, number),
        Control::LinuxCnc => Vec::new(),
    }
}

/// A change of a number as a parameter holds it, with its sign there, in the coordinates that the control reads.
fn of(machine: &Machine, number: &Number, (name, meaning): (String, String), sign: f64) -> Parameter {
    Parameter {
        name,
        meaning,
        change: sign * sign_of_coordinate(machine, number.component) * number.change,
        sigma: number.sigma,
        value: None,
        is_angle: number.what == What::Direction,
    }
}

/// Shifts from one system to the next, from the bed outward on either side.
fn heidenhain(machine: &Machine, number: &Number) -> Vec<Parameter> {
    let (axis, along) = (&machine.axes[number.axis].name, COORDINATES[number.component]);
    let described = |(name, meaning): (String, String)| {
        of(machine, number, (format!("kinematics description: {name}"), meaning), 1.0)
    };
    let table_centre = |axis: &str| (format!("place of {axis}, {along}"), format!("centre of {axis}"));
    let (name, meaning) = match number.what {
        What::TableCentre => table_centre(axis),
        What::Vector { from } => {
            let from = &machine.axes[from].name;
            (format!("shift from {from} to {axis}, {along}"), format!("vector from {from} to {axis}"))
        }
        What::Pivot => {
            (format!("shift from {axis} to the spindle, {along}"), format!("vector from {axis} to the spindle ball"))
        }
        What::ZeroShift | What::Direction => return Vec::new(),
    };
    // the description's tool goes where its vector goes, and the table beside it goes along: nothing closes this chain
    let is_table = |axis: &usize| machine.axes[*axis].kind == AxisKind::Rotary && machine.carries_workpiece(*axis);
    let beside = (0..machine.axes.len()).rfind(is_table).map(|axis| &machine.axes[axis]);
    let moved = beside.filter(|table| number.what == What::Pivot && table.across().any(|k| k == number.component));
    std::iter::once(described((name, meaning))).chain(moved.map(|table| described(table_centre(&table.name)))).collect()
}

/// What turns, as `$TC_CARR23` tells it.
#[derive(Clone, Copy, PartialEq)]
enum Swivels {
    /// T: the tool alone.
    Tool,
    /// P: the workpiece alone.
    Part,
    /// M: one axis on either side.
    Mixed,
}

/// The vectors of a swivel data record, as CYCLE800 and the five-axis transformation hold them: `$TC_CARR` of the first part and
/// machine data.
#[derive(Clone, Copy)]
enum SwivelVector {
    I1,
    I2,
    I3,
    I4,
}

impl SwivelVector {
    /// Name with the number of its first part.
    fn carrier(self) -> (&'static str, usize) {
        match self {
            SwivelVector::I1 => ("I1", 1),
            SwivelVector::I2 => ("I2", 4),
            SwivelVector::I3 => ("I3", 15),
            SwivelVector::I4 => ("I4", 18),
        }
    }

    /// Machine data of the transformation with the same vector (commissioning manual 12/2017, page 572; there the table between two axes of
    /// a table has the number 24558 beside the name of 24560, which the function manual gives it).
    fn machine_data(self, swivels: Swivels) -> Option<&'static str> {
        match (self, swivels) {
            (SwivelVector::I1, Swivels::Tool) | (SwivelVector::I4, Swivels::Part | Swivels::Mixed) => {
                Some("MD24500 $MC_TRAFO5_PART_OFFSET_1")
            }
            (SwivelVector::I3, Swivels::Tool) | (SwivelVector::I2, Swivels::Part | Swivels::Mixed) => {
                Some("MD24550 $MC_TRAFO5_BASE_TOOL_1")
            }
            (SwivelVector::I3, Swivels::Mixed) => Some("MD24558 $MC_TRAFO5_JOINT_OFFSET_PART_1"),
            (SwivelVector::I2, Swivels::Tool)
            | (SwivelVector::I3, Swivels::Part)
            | (SwivelVector::I1, Swivels::Mixed) => Some("MD24560 $MC_TRAFO5_JOINT_OFFSET_1"),
            _ => None,
        }
    }
}

/// Vectors of `CYCLE800` and of the transformation (commissioning manual 12/2017, swivelling). A head's run from the tool to the machine:
/// I3 from the spindle to the second axis, I2 from there to the first; with a table beside it I2 from the spindle to the axis. A table's run
/// from the machine outward: I2 to the first axis, I3 to the second; beside a head I3 to the axis. I1 and I4 close the chains.
fn sinumerik(machine: &Machine, number: &Number) -> Vec<Parameter> {
    let axis = &machine.axes[number.axis].name;
    let turning = machine.axes_of(AxisKind::Rotary);
    let (table, head): (Vec<usize>, Vec<usize>) = turning.partition(|&axis| machine.carries_workpiece(axis));
    let swivels = match (table.is_empty(), head.is_empty()) {
        (false, false) => Swivels::Mixed,
        (true, _) => Swivels::Tool,
        (false, true) => Swivels::Part,
    };
    let (vector, says, sign) = match (number.what, swivels) {
        (What::TableCentre, Swivels::Mixed) => (SwivelVector::I3, format!("centre of {axis}"), 1.0),
        (What::TableCentre, _) => (SwivelVector::I2, format!("centre of {axis}"), 1.0),
        (What::Vector { from }, _) if machine.carries_workpiece(number.axis) => {
            (SwivelVector::I3, format!("vector from {} to {axis}", machine.axes[from].name), 1.0)
        }
        (What::Vector { from }, _) => {
            (SwivelVector::I2, format!("vector from {axis} to {}", machine.axes[from].name), -1.0)
        }
        (What::Pivot, Swivels::Mixed) => (SwivelVector::I2, format!("vector from the spindle to {axis}"), -1.0),
        (What::Pivot, _) => (SwivelVector::I3, format!("vector from the spindle to {axis}"), -1.0),
        (What::ZeroShift | What::Direction, _) => return Vec::new(),
    };
    let closing = if machine.carries_workpiece(number.axis) { SwivelVector::I4 } else { SwivelVector::I1 };
    let (k, along) = (number.component, COORDINATES[number.component]);
    let both = [(vector, says, sign), (closing, "which closes the chain".to_string(), -sign)];
    let entries = |(vector, says, sign): &(SwivelVector, String, f64)| {
        let (name, first) = vector.carrier();
        let carrier = (format!("$TC_CARR{}", first + k), format!("{name}, {says}, {along}"));
        let carrier = of(machine, number, carrier, *sign);
        let data = vector.machine_data(swivels).map(|data| {
            let says = format!("{says}, {along} (transformation in place of CYCLE800)");
            of(machine, number, (format!("{data}[{k}]"), says), *sign)
        });
        std::iter::once(carrier).chain(data).collect::<Vec<Parameter>>()
    };
    both.iter().flat_map(entries).collect()
}

/// Vectors of tool centre point control (Series 30i-A, A-79348E pages 80 to 84): a table's run from the machine outward, a head's from the
/// tool axis to the (second) axis, and from the second axis to the first.
fn fanuc(machine: &Machine, number: &Number) -> Vec<Parameter> {
    let (axis, k, along) = (&machine.axes[number.axis].name, number.component, COORDINATES[number.component]);
    let is_table = machine.carries_workpiece(number.axis);
    let (first, says, sign) = match number.what {
        What::TableCentre => (19700, format!("table centre of {axis}"), 1.0),
        What::Vector { from } if is_table => (19703, format!("vector from {} to {axis}", machine.axes[from].name), 1.0),
        What::Vector { from } => (19712, format!("vector from {axis} to {}", machine.axes[from].name), -1.0),
        What::Pivot => (19709, format!("vector from the tool axis to {axis}"), -1.0),
        What::ZeroShift | What::Direction => return Vec::new(),
    };
    vec![of(machine, number, (format!("No. {}", first + k), format!("{says}, {along}")), sign)]
}

/// Whether a control takes a number: what is determined of it then changes one of its parameters.
pub fn is_entered(
    control: Control,
    machine: &Machine,
    numbers: &[Number],
    number: &Number,
    module: Option<&Module>,
) -> bool {
    match module {
        _ if !number.determined => false,
        Some(module) => module.pins.iter().any(|(pin, _)| {
            let of = made_of(pin, numbers).unwrap_or_default();
            of.contains(&number) && of.iter().all(|number| number.determined)
        }),
        None => !named(control, machine, number).is_empty(),
    }
}

/// Which numbers a pin of a LinuxCNC module is made of; `None` of one that holds none.
fn made_of<'n>(pin: &str, numbers: &'n [Number]) -> Option<Vec<&'n Number>> {
    let shifts = |component: usize| numbers.iter().filter(move |number| number.component == component);
    let is_place = |number: &&Number| matches!(number.what, What::TableCentre | What::Vector { .. });
    let is_vector = |number: &&Number| matches!(number.what, What::Vector { .. });
    Some(match pin {
        "x-rot-point" => shifts(0).filter(is_place).collect(),
        "y-rot-point" => shifts(1).filter(is_place).collect(),
        "x-offset" => shifts(0).filter(is_vector).collect(),
        "y-offset" => shifts(1).filter(is_vector).collect(),
        "z-rot-point" => shifts(2).filter(|number| number.what == What::TableCentre).collect(),
        "pivot-length" => shifts(2).filter(|number| number.what == What::Pivot).collect(),
        _ => return None,
    })
}

/// Pins of a LinuxCNC module; a pin stays when a number that it needs is not determined.
///
/// Places have values in machine coordinates only: without the machine file's `machine_zero` their changes alone are told.
fn pins(machine: &Machine, numbers: &[Number], fitted: &Module, nominal: &Module) -> Vec<Parameter> {
    let is_stated = |slide: &str| machine.axis_index(slide).is_some_and(|axis| machine.machine_zero[axis].is_some());
    let list = fitted.pins.iter().zip(&nominal.pins).filter_map(|((pin, value), (_, before))| {
        let of = made_of(pin, numbers)?;
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
