//! Numbers of a fit as a control takes them: which parameter, with which sign and unit, and what it cannot hold.
//!
//! A control that corrects by its kinematics description holds places of axis lines and vectors between them. What it
//! holds of the errors is [`held`]: a machine whose lines stand where the fit found them, with nominal directions. What stays over
//! the volume is the erring machine against that one.

mod backlash;
mod counting;
mod held;
mod linuxcnc;
mod numbers;
mod parameters;
mod present;
mod remaining;
mod tables;

pub use backlash::{Backlash, backlash};
pub use counting::counting_against;
pub use held::{held, held_where, left_over};
pub use linuxcnc::{Module, module_of, modules_of};
pub use numbers::{Number, What, numbers};
pub use parameters::{Control, Parameter, all_parameters, is_entered, parameters};
pub use present::{OtherUnit, refuse_other_units};
pub use remaining::{Enters, Remaining, Worsening, entered_effects, remaining};
pub(crate) use tables::LINUXCNC_ROWS;
pub use tables::{CompensationTable, squareness, tables, without_travel};
