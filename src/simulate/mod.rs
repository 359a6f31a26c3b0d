//! Traces of a session: what an ideal instrument would read, and the real one in `instrument`. No files.

mod component_errors;
mod forward;
mod instrument;
mod setup_errors;
mod trace;

pub use component_errors::{component_errors, component_errors_of};
pub use forward::{SimulateError, lengths, simulate, simulate_with, trace};
pub use instrument::{Instrument, InstrumentError};
pub use setup_errors::SetupErrors;
pub use trace::Trace;
