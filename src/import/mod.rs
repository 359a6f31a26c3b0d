//! What a gauge wrote in one piece to the recordings of a planned pair of tests: where in time its two sweeps lie. No files.
//!
//! A capture holds readings over the gauge's own time, from before the first run-in to after the second run-out, and no axis
//! position. What the axes did is known but for five numbers: when each direction began to move, their paces (speed over the
//! programmed feed) and the time in which the control ramps up; where marks show it, how far the servos lag. They minimise
//! `rᵀC⁻¹r + ‖x‖² + log det(C + MMᵀ) + priors`, `r = y − L₀(p) − M(p)·x`, C the noise with its wander, y the
//! readings, p the place along the run at each reading, L₀ the nominal length there, and M·x what balls, bar, location errors
//! and a few µm of unknown form and hysteresis may add (columns scaled by their standard deviations, x integrated out); of a known
//! program lost motion of its axes too, where the readings speak for it. A start
//! is told from a delay of the gauge's clock by nothing: only their sum is fitted, which is all that the axis positions need.
//!
//! | file | question |
//! |---|---|
//! | `capture` | the readings as they come, averaged to a few hundred, their noise |
//! | `course` | what would be read along a run, and what may lost motion add? |
//! | `marks` | where are the moves along the bar by which a program marks its runs, and what do they tell? |
//! | `marks::form` | where do readings have the form of one? |
//! | `marks::moves` | when did those moves end? |
//! | `marks::stopped` | was a run held between them? |
//! | `marks::outside` | did the bar rest before them and after? |
//! | `other_reading` | are they there at another sense, unit or clock? |
//! | `timing` | where along the run is the machine at a time? |
//! | `timing::lag` | how do axes follow their commands? |
//! | `timing::bend` | how is a run uneven? |
//! | `wander` | what do readings say that wander together? |
//! | `likelihood` | how well does a timing explain the readings? |
//! | `variables` | which numbers are sought, and in which units? |
//! | `search` | which timing explains them best, and which other does nearly? |
//! | `uncertainty` | how well is it known, in s and in degrees? |
//! | `uneven` | was a run held, or its feed changed, on the way? |
//! | `place` | is it to be believed? |
//! | `refusals` | what stands against it? |
//! | `error` | why is it not placed? |
//! | `session_times` | when was it recorded within the session? |
//! | `split` | the recordings |

mod capture;
mod course;
mod error;
mod likelihood;
mod marks;
mod other_reading;
mod place;
mod refusals;
mod search;
mod seen_marks;
mod session_times;
mod split;
mod timing;
mod trimmed;
mod uncertainty;
mod uneven;
mod variables;
mod wander;

pub use capture::Capture;
pub use course::{Course, Feeds, Pair, pairs};
pub use error::{Bound, ImportError, RunsDiffer};
pub use place::{Placement, place, place_named};
pub use session_times::{Began, Scale, SessionTimes, Stated, WhyPlanned};
pub use split::{recordings, split_session};
pub use timing::Timing;
