//! A session as fitted: errors, ball places and bar errors moved to their estimates, so that simulating it predicts.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::estimate::Fit;
use crate::identify::model::unknowns::{Quantity, moves_spindle_ball};
use crate::machine::{ComponentError, ComponentForm};
use crate::readings::rotation;
use crate::session::{Session, Setups};

/// The session whose simulation is the fit's prediction.
///
/// Commanded positions of planned paths depend on ball places; where a recording has no positions of its own, give it
/// those of the stated places before moving the balls.
pub fn fitted_session(session: &Session, fit: &Fit) -> Session {
    let setups = Setups::of(session);
    let mut fitted = session.clone();
    let mut turns: BTreeMap<(usize, bool), Vector3<f64>> = BTreeMap::new();
    for (unknown, estimate) in fit.unknowns.iter().zip(&fit.estimates) {
        match unknown.quantity {
            Quantity::Location { axis, component } => {
                fitted.machine.axes[axis].location_errors[component.index()] = estimate.value;
            }
            Quantity::Pivot { setup, coordinate } => {
                for (test, _) in fitted.tests.iter_mut().zip(&setups.pivot_of).filter(|(_, of)| **of == setup) {
                    test.pivot.at[coordinate] += estimate.value;
                }
                let second = fitted.tests.iter_mut().zip(&setups.second_pivot_of);
                for (test, _) in second.filter(|(_, of)| **of == Some(setup)) {
                    test.spindle_ball.at[coordinate] += estimate.value;
                }
            }
            Quantity::SpindleBall { setup, coordinate } => {
                for (test, own) in setups.spindle_ball_of.iter().enumerate() {
                    if moves_spindle_ball(session, (setup, coordinate), test, *own) {
                        let ball = &mut fitted.tests[test].spindle_ball;
                        ball.at[coordinate] += ball.sign(coordinate) * estimate.value;
                    }
                }
            }
            Quantity::InstrumentTurn { setup, .. } => {
                turns.entry((setup, false)).or_insert(Vector3::zeros())[unknown.quantity.coordinate()] = estimate.value;
            }
            Quantity::TargetTurn { setup, .. } => {
                turns.entry((setup, true)).or_insert(Vector3::zeros())[unknown.quantity.coordinate()] = estimate.value;
            }
            // a fit is not asked for these; they stand in `linear_axes`
            Quantity::Slide { .. } => {}
            Quantity::Bar { setup } => {
                for (test, _) in fitted.tests.iter_mut().zip(&setups.bar_of).filter(|(_, of)| **of == Some(setup)) {
                    test.bar_error_mm += estimate.value;
                }
            }
        }
    }
    for ((setup, is_target), turn) in turns {
        let of = if is_target { &setups.spindle_ball_of } else { &setups.pivot_of };
        let with = fitted.tests.iter_mut().zip(of).filter(|(_, of)| **of == setup);
        for part in with.filter_map(|(test, _)| test.reading.part_mut()) {
            let axes = if is_target { &mut part.target_axes } else { &mut part.instrument_axes };
            *axes = rotation(&turn) * *axes;
        }
    }
    for &(axis, component, value) in &fit.linear_axes.squareness {
        fitted.machine.axes[axis].location_errors[component.index()] = value;
    }
    for (axis, error) in &fit.linear_axes.displacements {
        add(&mut fitted.machine.axes[*axis].component_errors, error);
    }
    fitted
}

/// Adds a component error to those that a machine file states, one form per component.
fn add(stated: &mut Vec<ComponentError>, error: &ComponentError) {
    let Some(same) = stated.iter_mut().find(|other| other.component == error.component) else {
        stated.push(error.clone());
        return;
    };
    let position = match (&same.form, &error.form) {
        (ComponentForm::Table { position: one, .. }, ComponentForm::Table { position: other, .. }) => {
            let mut both: Vec<f64> = one.iter().chain(other).copied().collect();
            both.sort_by(f64::total_cmp);
            both.dedup();
            both
        }
        // a formula stays as it is stated: a table would lose its short waves for the sake of a fraction of a micrometre
        _ => return,
    };
    let value = position.iter().map(|&q| same.form.value(q) + error.form.value(q)).collect();
    same.form = ComponentForm::Table { position, value };
}
