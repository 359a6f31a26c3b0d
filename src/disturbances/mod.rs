//! Effects of a machine with their sizes, as changes of what is read: exact, to first order, and as component errors. It knows no effect
//! by name; which there are is the catalogue's.

mod disturbance;
mod steady;

pub use disturbance::{Disturbance, Disturbances, column, gain};
pub use steady::into_component_errors;
