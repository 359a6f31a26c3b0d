//! Effects of a machine with their sizes, as changes of what is read: exact, to first order, and as component errors. It knows no effect
//! by name; which there are is the catalogue's.

mod disturbance;
mod remembered;
mod steady;

pub use disturbance::{Disturbance, Disturbances, column, gain};
pub use remembered::{Remembered, take_remembered};
pub use steady::{TableEnd, Taken, into_component_errors, into_component_errors_within, positions_seen, steps_seen};
