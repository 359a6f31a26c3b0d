//! What a fit may change: location errors, ball places, bar readings, each with its prior. Values live in the fit.

use crate::machine::{AxisKind, Component, ErrorName, ErrorNameError, Machine};
use crate::session::{Session, Setups, Zero};
use crate::units::Measure;

/// One unknown of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    pub quantity: Quantity,
    /// Name for people: `EX0C`, `pivot on C at (0, 100, 0), x`.
    pub label: String,
    pub measure: Measure,
    /// Standard deviation before the fit, mm or rad.
    pub prior_sigma: f64,
    /// Value before the fit, mm or rad.
    pub prior_mean: f64,
}

/// What an unknown stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Location error of an axis.
    Location { axis: usize, component: Component },
    /// Offset of a pivot ball from its stated place, in R at the zero position; coordinate 0, 1, 2.
    Pivot { setup: usize, coordinate: usize },
    /// Offset of a spindle ball.
    SpindleBall { setup: usize, coordinate: usize },
    /// Turn of an instrument's axes about a direction of R (0, 1, 2), as a rotation vector on its link.
    InstrumentTurn { setup: usize, coordinate: usize },
    /// The same of a target's axes.
    TargetTurn { setup: usize, coordinate: usize },
    /// Reading minus distance, of a bar.
    Bar { setup: usize },
    /// Displacement of a linear axis's carriage along a direction of R (0, 1, 2) in one of the shapes over its position
    /// that `slides` has, per length.
    Slide { axis: usize, direction: usize, shape: usize },
}

impl Quantity {
    /// Coordinate 0, 1, 2 of a ball's place or of a turn; 0 of what has none.
    pub fn coordinate(self) -> usize {
        match self {
            Quantity::Pivot { coordinate, .. }
            | Quantity::SpindleBall { coordinate, .. }
            | Quantity::InstrumentTurn { coordinate, .. }
            | Quantity::TargetTurn { coordinate, .. } => coordinate,
            _ => 0,
        }
    }

    /// Which kind of prior knowledge stands behind the unknown.
    pub fn is_setup(self) -> bool {
        !matches!(self, Quantity::Location { .. } | Quantity::Slide { .. })
    }
}

/// How little is assumed of location errors: wide enough to be without influence wherever data speak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreePrior {
    pub length_mm: f64,
    pub angle_rad: f64,
}

impl FreePrior {
    /// Machine tools: 1 mm and 0.1°, some twenty times the errors of a bad machine.
    const MACHINE_TOOL: FreePrior = FreePrior { length_mm: 1.0, angle_rad: 0.1 * std::f64::consts::PI / 180.0 };
    /// Arms: 20 mm and 5°, so that nominal dimensions and zero positions may be rough.
    const ARM: FreePrior = FreePrior { length_mm: 20.0, angle_rad: 5.0 * std::f64::consts::PI / 180.0 };

    /// Prior for a machine: arms have no linear axis, or one that carries them.
    pub fn of(machine: &Machine) -> FreePrior {
        if is_arm(machine) { FreePrior::ARM } else { FreePrior::MACHINE_TOOL }
    }
}

/// Rotary axes from which a chain is an arm although a slide carries it: machine tools have three at most.
const ARM_JOINTS: usize = 4;

/// A chain of rotary axes alone, or of so many that it is an arm on a slide.
pub fn is_arm(machine: &Machine) -> bool {
    let turning = machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary).count();
    turning == machine.axes.len() || turning >= ARM_JOINTS
}

/// Why a list of free errors was not understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FreeError {
    #[error("{0} (groups: rotary, squareness, linear, zero, all, none)")]
    Name(#[from] ErrorNameError),
    #[error("{0} is a component error; only location errors can be free here")]
    ComponentError(String),
    #[error(
        "'{0}' names no error; write names such as EX0C,EY0C or a group: rotary, squareness, linear, zero, all, none"
    )]
    Nothing(String),
}

/// Location errors free by default: the slots of the rotary axes, with the zero positions of an arm.
pub fn default_free(machine: &Machine) -> Vec<ErrorName> {
    let mut free = group(machine, "rotary");
    if is_arm(machine) {
        free.extend(group(machine, "zero"));
    }
    free
}

/// Reads `EX0C,EY0C`, a group name, or several of them.
pub fn parse_free(text: &str, machine: &Machine) -> Result<Vec<ErrorName>, FreeError> {
    let axes = machine.axis_names();
    let mut free: Vec<ErrorName> = Vec::new();
    for word in text.split([',', ' ']).filter(|word| !word.is_empty()) {
        let names = match word {
            "rotary" | "squareness" | "linear" | "zero" | "all" | "none" => group(machine, word),
            name => {
                let name = ErrorName::parse(name, &axes)?;
                if !name.is_location {
                    return Err(FreeError::ComponentError(name.to_string()));
                }
                vec![name]
            }
        };
        for name in names {
            if !free.contains(&name) {
                free.push(name);
            }
        }
    }
    // a stray comma is no wish for a fit without errors; that is 'none'
    match text.split([',', ' ']).all(str::is_empty) {
        true => Err(FreeError::Nothing(text.to_string())),
        false => Ok(free),
    }
}

/// Errors of a group: `squareness` are EC0Y, EB0Z, EA0Z (the gauge keeps EB0X, EC0X, EA0Y at zero).
fn group(machine: &Machine, name: &str) -> Vec<ErrorName> {
    let kind_slots = |kind: AxisKind| -> Vec<ErrorName> {
        let of_kind = |index: &usize| machine.axes[*index].kind == kind;
        (0..machine.axes.len()).filter(of_kind).flat_map(|index| machine.axis_slots(index)).collect()
    };
    match name {
        "rotary" => kind_slots(AxisKind::Rotary),
        "linear" => kind_slots(AxisKind::Linear),
        "squareness" => {
            let wanted = [(Component::EC, 1), (Component::EB, 2), (Component::EA, 2)];
            let linear = machine.axes.iter().filter(|axis| axis.kind == AxisKind::Linear);
            linear
                .flat_map(|axis| {
                    let along = axis.coordinate_direction();
                    wanted
                        .iter()
                        .filter(move |(_, direction)| along == Some(*direction))
                        .map(|(component, _)| ErrorName::location(*component, &axis.name))
                })
                .collect()
        }
        "zero" => machine
            .axes
            .iter()
            .filter_map(|axis| axis.zero_position().map(|component| ErrorName::location(component, &axis.name)))
            .collect(),
        "all" => ["rotary", "squareness"].iter().flat_map(|name| group(machine, name)).collect(),
        _ => Vec::new(),
    }
}

/// Whether the ball of a test goes where a pivot length that is not known goes: one in the spindle that a rotary axis carries, across that axis.
pub(crate) fn follows_pivot_length(session: &Session, test: usize, coordinate: usize) -> bool {
    let machine = &session.machine;
    let Some(axis) = machine.spindle_axis().filter(|_| session.spread.pivot_length_mm > 0.0) else { return false };
    let link = &session.tests[test].spindle_ball.link;
    let is_in_spindle = *link == "t" || *link == machine.axes[axis].name;
    is_in_spindle && machine.axes[axis].across().any(|k| k == coordinate)
}

/// Whether the unknown place of a spindle ball moves the ball of a test, whose own setup is `own`: its own, and in the first ball's place the pivot
/// length, which all balls in the spindle share.
pub(crate) fn moves_spindle_ball(
    session: &Session,
    (setup, coordinate): (usize, usize),
    test: usize,
    own: usize,
) -> bool {
    own == setup || (setup == 0 && own != usize::MAX && follows_pivot_length(session, test, coordinate))
}

/// All unknowns of a session: the free location errors, then pivots, spindle balls and bars.
pub fn unknowns(session: &Session, setups: &Setups, free: &[ErrorName], prior: FreePrior) -> Vec<Unknown> {
    let mut list = Vec::new();
    for name in free {
        let Some(axis) = session.machine.axis_index(&name.axis) else { continue };
        let measure = name.component.measure();
        list.push(Unknown {
            quantity: Quantity::Location { axis, component: name.component },
            label: name.to_string(),
            measure,
            prior_sigma: match measure {
                Measure::Angle => prior.angle_rad,
                _ => prior.length_mm,
            },
            prior_mean: session.machine.axes[axis].location_errors[name.component.index()],
        });
    }
    let mut setup_unknown = |quantity, label: String, prior_sigma| {
        let measure = match quantity {
            Quantity::InstrumentTurn { .. } | Quantity::TargetTurn { .. } => Measure::Angle,
            _ => Measure::Length,
        };
        list.push(Unknown { quantity, label, measure, prior_sigma, prior_mean: 0.0 });
    };
    for coordinate in 0..3 {
        let letter = ['x', 'y', 'z'][coordinate];
        for (setup, pivot) in setups.pivots.iter().enumerate() {
            setup_unknown(Quantity::Pivot { setup, coordinate }, format!("{}, {letter}", pivot.label), pivot.spread_mm);
        }
        for (setup, ball) in setups.spindle_balls.iter().enumerate() {
            let quantity = Quantity::SpindleBall { setup, coordinate };
            // the first ball's place stands for the pivot length too, those of the others are told from it
            let is_first = setup == 0 && follows_pivot_length(session, ball.first_test, coordinate);
            let pivot_length_mm = if is_first { session.spread.pivot_length_mm } else { 0.0 };
            let spread_mm = ball.spread_mm.hypot(pivot_length_mm);
            setup_unknown(quantity, format!("{}, {letter}", ball.label), spread_mm);
        }
    }
    for coordinate in 0..3 {
        let letter = ['x', 'y', 'z'][coordinate];
        for (setup, instrument) in setups.pivots.iter().enumerate() {
            let Some(turn_rad) = instrument.turn_rad else { continue };
            let quantity = Quantity::InstrumentTurn { setup, coordinate };
            setup_unknown(quantity, format!("{}, turn about {letter}", instrument.label), turn_rad);
        }
        for (setup, target) in setups.spindle_balls.iter().enumerate() {
            let Some(turn_rad) = target.turn_rad else { continue };
            let quantity = Quantity::TargetTurn { setup, coordinate };
            setup_unknown(quantity, format!("{}, turn about {letter}", target.label), turn_rad);
        }
    }
    for (setup, bar) in setups.bars.iter().enumerate() {
        let what = if bar.zero == Zero::Free { "zero" } else { "length" };
        setup_unknown(Quantity::Bar { setup }, format!("{what} of {}", bar.label), bar.spread_mm);
    }
    list
}
