//! Location errors from recordings: one weighted nonlinear least-squares fit over all tests of a session.
//!
//! Minimises `Σ ‖W(reading − L(errors, balls) − bar)‖² + Σ ((x − prior)/σ_prior)²` over the free location errors, the
//! place of every pivot and spindle ball, the reading error of every bar and what the linear axes do within their budget; W whitens each trace by a noise model
//! (white + AR(1) + drift) fitted to the residuals, so that uncertainties hold for autocorrelated noise.

mod absorbed;
mod ambiguity;
mod axis_lines;
mod candidates;
mod determined;
mod estimate;
mod fitted;
mod least_squares;
mod mark_senses;
mod model;
mod outliers;
mod senses;
mod solve;
mod uncertainty;

pub use ambiguity::Ambiguity;
pub use axis_lines::{AxisLine, CentreReading, axis_lines};
pub use determined::{DeterminedError, DeterminedErrors};
pub use estimate::{Estimate, Fit, FittedSlides, FreeLocation, Summed, TestFit};
pub use fitted::fitted_session;
pub use least_squares::{fit, identify};
pub use model::error::FitError;
pub use model::options::Options;
pub use model::problem::{Prediction, PreparedTest, Problem};
pub(crate) use model::slides::squareness_within;
pub use model::unknowns::{FreeError, FreePrior, Quantity, Unknown, default_free, parse_free, unknowns};
pub(crate) use outliers::kept_rows;
pub use senses::{MovedError, SenseTest, TurnedSense, turned_senses};
pub(crate) use solve::minimise_until;
pub use solve::{Normal, Solution, Until, Weighting, minimise, residual_mm};
