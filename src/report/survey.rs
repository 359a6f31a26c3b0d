//! The survey as CSV, JSON and words for the terminal. It plans nothing; the page is `survey_page`'s.

use serde_json::{Value, json};

use crate::survey::{Outcome, tallies};
use crate::units::Measure;

/// Header of the survey's table.
pub const HEADER: &str = "code,family,errors,visible,determined,undetermined,tests,pivot_setups,minutes,\
worst_position_um,worst_orientation_arcsec,one_pivot_determined,one_pivot_minutes,fully_tested_from_one_pivot,setups_considered";

/// One line of the table, without a line's end.
pub fn row(outcome: &Outcome) -> String {
    let number =
        |value: Option<f64>, digits: usize| value.map_or_else(String::new, |value| format!("{value:.digits$}"));
    [
        outcome.code.to_string(),
        outcome.family.name().to_string(),
        outcome.errors.to_string(),
        outcome.visible.to_string(),
        outcome.determined.to_string(),
        outcome.undetermined.join(" "),
        outcome.tests.to_string(),
        outcome.pivot_setups.to_string(),
        format!("{:.2}", outcome.minutes),
        number(outcome.position_mm.map(|mm| Measure::Length.to_output(mm)), 3),
        number(outcome.orientation_rad.map(|rad| Measure::Angle.to_output(rad)), 3),
        outcome.one_pivot.map_or_else(String::new, |one| one.determined.to_string()),
        number(outcome.one_pivot.map(|one| one.minutes), 2),
        if outcome.is_fully_tested_from_one_pivot() { "yes" } else { "no" }.to_string(),
        outcome.considered.to_string(),
    ]
    .join(",")
}

/// The whole table.
pub fn csv(outcomes: &[Outcome]) -> String {
    let mut text = format!("{HEADER}\n");
    for outcome in outcomes {
        text.push_str(&row(outcome));
        text.push('\n');
    }
    text
}

/// The survey for programs.
pub fn survey_json(outcomes: &[Outcome]) -> Value {
    let rows: Vec<Value> = outcomes
        .iter()
        .map(|outcome| {
            json!({
                "code": outcome.code.to_string(),
                "family": outcome.family.name(),
                "errors": outcome.errors,
                "visible": outcome.visible,
                "determined": outcome.determined,
                "undetermined": outcome.undetermined,
                "tests": outcome.tests,
                "pivot_setups": outcome.pivot_setups,
                "minutes": outcome.minutes,
                "worst_position_um": outcome.position_mm.map(|mm| rounded(Measure::Length.to_output(mm))),
                "worst_orientation_arcsec": outcome.orientation_rad.map(|rad| rounded(Measure::Angle.to_output(rad))),
                "one_pivot_determined": outcome.one_pivot.map(|one| one.determined),
                "one_pivot_minutes": outcome.one_pivot.map(|one| one.minutes),
                "fully_tested_from_one_pivot": outcome.is_fully_tested_from_one_pivot(),
                "setups_considered": outcome.considered,
            })
        })
        .collect();
    let families: Vec<Value> = tallies(outcomes)
        .iter()
        .map(|tally| {
            json!({
                "family": tally.family.name(),
                "topologies": tally.topologies,
                "all_determined": tally.all_determined,
                "all_visible_determined": tally.all_visible_determined,
                "fully_tested_from_one_pivot": tally.from_one_pivot,
                "without_test": tally.without_test,
            })
        })
        .collect();
    json!({ "topologies": outcomes.len(), "families": families, "rows": rows })
}

fn rounded(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}
