//! A plan from what is asked for: tests by a method or by search, indexed runs, order and forecast.

use super::plan_result::Plan;
use crate::bodies::{Bodies, Kit};
use crate::machine::Machine;
use crate::plan::context::error::PlanError;
use crate::plan::context::setting_out::with_evaluation;
use crate::plan::context::settings::Settings;
use crate::plan::search::method_tests::method_choice;

/// Plans the tests of a machine; `Err` when a method does not fit the machine.
pub fn plan(machine: &Machine, bodies: &Bodies, kit: &Kit, settings: &Settings) -> Result<Plan, PlanError> {
    with_evaluation(machine, bodies, kit, settings, |mut evaluation| {
        let about = if settings.index_spindle { Some(evaluation.spindle_direction()?) } else { None };
        let (mut choice, one_pivot) = match (settings.method, settings.pivots) {
            (Some(method), _) => (method_choice(&mut evaluation, method)?, None),
            (None, _) => evaluation.searched(),
        };
        if let Some(about) = about {
            evaluation.repeat_indexed(&mut choice, about);
            evaluation.is_indexed = choice.entries.iter().any(|entry| entry.indexed_about.is_some());
        }
        Ok(Plan { one_pivot, ..evaluation.finish(choice) })
    })
}

/// For each wanted error: lengths of setups within reach show it. Nothing is chosen, so it takes a part of a plan's time.
pub(crate) fn seen(machine: &Machine, bodies: &Bodies, kit: &Kit, settings: &Settings) -> Result<Vec<bool>, PlanError> {
    with_evaluation(machine, bodies, kit, settings, |evaluation| {
        Ok(evaluation.observability.iter().map(|one| one.is_seen).collect())
    })
}
