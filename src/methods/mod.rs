//! The thesis's own estimators and the figures of planar circles: closed formulas, test by test. Not the least-squares fit.
//!
//! | file | holds |
//! |---|---|
//! | `circle_fit` | the algebraic circle fit of section 4.2 |
//! | `turning` | a sweep of any rotary axis as a circle in its turning plane (start position, cone reduction) |
//! | `runs` | repeat runs, averaged with their standard deviation |
//! | `axis_line` | an axis as a line, an outer axis's share in an inner one's |
//! | `thesis_value` | an error as one of the thesis's methods finds it |
//! | `thesis` | chapters 4, 5 and 6: which tests, which differences give which error |
//! | `compensated` | traces with the found errors taken out, as in Figs 4.6–4.8 |
//! | `bar_turn` | where the bar points during a test, and the two directions of one pass |
//! | `swept` | what a test is drawn over: an axis, the angle of a circle |
//! | `trace` | recorded tests pass by pass: angles, deviations of readings and model |
//! | `centring` | deviations without the offset of the centre |
//! | `circles` | planar circles of two linear axes: ISO 230-4 figures and their parts |
//!
//! What each approximation costs is measured in `tests/thesis_methods.rs` and told in `docs/methods.md`.

mod axis_line;
mod bar_turn;
mod centring;
mod circle_fit;
mod circles;
mod compensated;
mod error;
mod runs;
mod swept;
mod thesis;
mod thesis_value;
mod trace;
mod turning;

pub use bar_turn::BarTurn;
pub use centring::Centred;
pub use circle_fit::{FittedCircle, fit_circle};
pub use circles::{AxisReversals, CircleFigures, DirectionFigures, Reversal, Squareness, circles};
pub use compensated::CompensatedTrace;
pub use error::MethodError;
pub use runs::{Bar, Runs, Scatter};
pub use swept::{Course, Swept, SweptOver};
pub use thesis::{ThesisEstimate, chapter4, chapter5, chapter6};
pub use thesis_value::{ThesisMethod, ThesisValue};
pub(crate) use trace::common_centre;
pub use trace::{TestTrace, TraceDeviations, recorded_passes};
pub use turning::{TurningCircle, turning_circle};
