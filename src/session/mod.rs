//! A session: tests with their balls, bars and recordings on one machine. It holds what was done, not what it means.

mod ball;
mod claim;
mod instruments;
mod mark_move;
mod marks;
mod motion;
mod path;
mod recording;
mod run_ends;
mod scattered;
mod second_socket;
mod setups;
mod test;
mod test_motion;

pub(crate) use ball::FREE_ZERO_MM;
pub use ball::{Ball, FREE_PIVOT_LENGTH_MM, Spread, Zero};
pub use claim::{Claim, ClaimedValue, Reduction};
pub use instruments::SightedMisfit;
pub(crate) use instruments::{is_looked_for, locate_instruments, located_anew, sighted_misfits};
pub use mark_move::marked;
pub use marks::Marks;
pub(crate) use marks::times_beside_readings;
pub use motion::Motion;
pub use path::{CirclePlane, Follow, Path};
pub use recording::{Clock, LengthColumn, Recording, Scatter};
pub use run_ends::{RunEnd, beyond};
pub(crate) use scattered::even_out;
pub use setups::{Setup, Setups};
pub(crate) use setups::{UNKNOWN_MM, UNKNOWN_RAD};
pub use test::{APPROACHED_OVER, Session, Test};
pub(crate) use test_motion::DEFAULT_RUN_IN;
pub use test_motion::{MotionError, way_mm};
