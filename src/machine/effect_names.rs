//! Names and measures of an effect's place and outlets on a machine; what they hold is in `effect`.

use super::axis::AxisKind;
use super::effect::{Outlet, Place};
use super::error_name::ErrorName;
use super::serial_machine::Machine;
use crate::units::Measure;

impl Place {
    /// Name in files and output: an axis name, `pivot`, `spindle-ball`, `bar`, `recorder`, `control`.
    pub fn name(self, machine: &Machine) -> &str {
        match self {
            Place::Axis(axis) => machine.axes.get(axis).map_or("?", |axis| axis.name.as_str()),
            other => Place::OTHERS.iter().find(|(_, place)| *place == other).map_or("?", |(name, _)| name),
        }
    }
}

/// Names of the coordinates of a ball.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

impl Outlet {
    /// The axis's own motion: `ECC` of C, `EXX` of X, along the line of an inclined axis.
    pub fn own(machine: &Machine, axis: usize) -> Outlet {
        match machine.axes[axis].zero_position() {
            Some(component) => Outlet::Motion { axis, component },
            None => Outlet::Along { axis },
        }
    }

    /// Name in files and output: `ECC`, `EC0Y`, `own`, `lag`, `acceleration`, `slides`, `delay`, `x y z`, `length`.
    pub fn name(&self, machine: &Machine) -> String {
        let axis_name = |axis: usize| machine.axes.get(axis).map_or("?", |axis| axis.name.as_str());
        match *self {
            Outlet::Motion { axis, component } => ErrorName::motion(component, axis_name(axis)).to_string(),
            Outlet::Location { axis, component } => ErrorName::location(component, axis_name(axis)).to_string(),
            Outlet::Along { .. } => "own".into(),
            Outlet::Lag { .. } => "lag".into(),
            Outlet::Acceleration { .. } => "acceleration".into(),
            Outlet::SlidesAcceleration { .. } => "slides".into(),
            Outlet::Delay => "delay".into(),
            Outlet::Pivot(k) | Outlet::SpindleBall(k) => COORDINATES[k.min(2)].into(),
            Outlet::Reading => "length".into(),
        }
    }

    /// What its amount measures.
    pub fn measure(&self, machine: &Machine) -> Measure {
        match *self {
            Outlet::Motion { component, .. } | Outlet::Location { component, .. } => component.measure(),
            Outlet::Along { axis } => match machine.axes[axis].kind {
                AxisKind::Linear => Measure::Length,
                AxisKind::Rotary => Measure::Angle,
            },
            Outlet::Lag { .. } | Outlet::Delay => Measure::Time,
            Outlet::Acceleration { .. } | Outlet::SlidesAcceleration { .. } => Measure::TimeSquared,
            Outlet::Pivot(_) | Outlet::SpindleBall(_) | Outlet::Reading => Measure::Length,
        }
    }
}
