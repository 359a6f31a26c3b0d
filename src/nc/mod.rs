//! Programs that run a plan: approach, run-in, capture arc both ways, dwell, retreat, for four controls. It moves nothing itself.
//!
//! A program is a list of [`Step`]s, the same for every control; a dialect writes them down. It starts and ends at the
//! park position and travels one axis at a time, so that every control makes the motion that was checked. Near the cups it
//! stops before every leg and goes at feed. Feeds are those of one ball as seen from the other, converted to the turning
//! axis, deg/min, which is how all four controls read F in a block that moves one rotary axis alone; mm/min along the arc on
//! circles and arcs that carry a rotary axis; the time of each block where slides follow on another curve. Positions are
//! machine coordinates where `machine_zero` is known for every axis and the control feeds in them, else work coordinates
//! with zero at the machine file's zero.

mod coordinates;
mod coupled;
mod dialect;
mod dry_run;
mod head;
mod heidenhain;
mod iso;
mod marks;
mod program_text;
mod run;
mod setup_words;
mod step;
mod test_steps;
mod way;
mod work_zero;

pub use coordinates::Coordinates;
pub use dialect::Dialect;
pub(crate) use dry_run::little_words;
pub(crate) use head::ball_speed;
pub use head::without_machine_zero;
pub use program_text::{dry_run_program, program};
pub(crate) use setup_words::placing_words;
pub use step::{Curves, Step};
pub use test_steps::steps;
pub use work_zero::zero_words;
