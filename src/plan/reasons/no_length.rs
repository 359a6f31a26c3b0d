//! Why no ball-bar length tells an error, whichever setups are chosen. It chooses nothing.

use crate::machine::AxisKind;
use crate::plan::context::evaluation::Evaluation;

/// Why no length tells an error, where that is so: each rotary axis has setups within its reach and none of them shows it.
pub(crate) fn no_length_tells(evaluation: &Evaluation, k: usize) -> Option<String> {
    let has_setups = |axis: usize| evaluation.context.all.list.iter().any(|candidate| candidate.axis == axis);
    let mut rotary = evaluation.context.machine.axes_of(AxisKind::Rotary);
    let seen = &evaluation.observability[k];
    if seen.is_seen || !rotary.all(has_setups) {
        return None;
    }
    let names: Vec<String> =
        seen.partners.iter().map(|&other| evaluation.context.unknowns.errors[other].2.to_string()).collect();
    Some(match (names.is_empty(), seen.by_pivot) {
        (false, by_pivot) => only_together(&names, by_pivot),
        (true, true) => ONLY_BY_PIVOT.into(),
        (true, false) => {
            "no ball-bar length tells it, whichever setups are chosen: what moves both balls alike changes none".into()
        }
    })
}

/// Errors that lengths show in one sum only.
fn only_together(names: &[String], by_pivot: bool) -> String {
    let shared = if by_pivot { " and the pivot's place" } else { "" };
    format!("only together with {}{shared}: what moves both alike changes no ball-bar length", names.join(", "))
}

/// An error that stands for the pivot's own place.
const ONLY_BY_PIVOT: &str =
    "only through how well the pivot's place is known: what moves the whole branch changes no ball-bar length";
