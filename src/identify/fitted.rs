//! A session as fitted: errors, ball places and bar errors moved to their estimates, so that simulating it predicts.

use super::{Fit, Quantity};
use crate::session::{Session, Setups};

/// The session whose simulation is the fit's prediction.
///
/// Commanded positions of planned paths depend on ball places; where a recording has no positions of its own, give it
/// those of the stated places before moving the balls.
pub fn fitted_session(session: &Session, fit: &Fit) -> Session {
    let setups = Setups::of(session);
    let mut fitted = session.clone();
    for (unknown, estimate) in fit.unknowns.iter().zip(&fit.estimates) {
        match unknown.quantity {
            Quantity::Location { axis, component } => {
                fitted.machine.axes[axis].location_errors[component.index()] = estimate.value;
            }
            Quantity::Pivot { setup, coordinate } => {
                for (test, _) in fitted.tests.iter_mut().zip(&setups.pivot_of).filter(|(_, of)| **of == setup) {
                    test.pivot.at[coordinate] += estimate.value;
                }
            }
            Quantity::SpindleBall { setup, coordinate } => {
                for (test, _) in fitted.tests.iter_mut().zip(&setups.spindle_ball_of).filter(|(_, of)| **of == setup) {
                    let sign = test.spindle_ball.sign(coordinate);
                    test.spindle_ball.at[coordinate] += sign * estimate.value;
                }
            }
            Quantity::Bar { setup } => {
                for (test, _) in fitted.tests.iter_mut().zip(&setups.bar_of).filter(|(_, of)| **of == Some(setup)) {
                    test.bar_error_mm += estimate.value;
                }
            }
        }
    }
    fitted
}
