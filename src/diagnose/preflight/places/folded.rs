//! Sessions in which positions of a rotary axis were written without their sign. Whether they were is for others to judge.

use super::misplaced::names;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::{Sampled, keep_few_rows};
use crate::diagnose::preflight::data_fault::{RECORDER, listed};
use crate::diagnose::preflight::suspicion::{Detail, SOMETIMES, Suspicion};
use crate::session::Recording;

/// Rows on either side of a turn at least.
const LEAST_ROWS_BESIDE: usize = 6;

/// Which part of a recording had a negative sign: the rows before it turns back or those behind, in all recordings or by turns.
const NEGATIVE_FIRST: [fn(usize) -> bool; 4] = [|_| true, |_| false, |run| run % 2 == 0, |run| run % 2 == 1];

/// Recordings in which a rotary axis turns back at zero, with the signs that a sweep that goes on would have.
pub(crate) fn without_sign(sampled: Sampled<'_>, axis: usize) -> Vec<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let turn = |test: usize| {
        let recording = session.tests[test].recording.as_ref()?;
        let column = recording.swept(axis)?;
        turns_back(&recording.positions[column]).map(|row| (test, column, row))
    };
    let turns: Vec<(usize, usize, usize)> = (0..session.tests.len()).filter_map(turn).collect();
    let tests: Vec<usize> = turns.iter().map(|(test, ..)| *test).collect();
    let name = &session.machine.axes[axis].name;
    let with = |is_first: &fn(usize) -> bool| {
        let mut undone = thinned.clone();
        for (run, &(test, column, row)) in turns.iter().enumerate() {
            let mut signed: Recording = session.tests[test].recording.clone()?;
            let (before, behind) = signed.positions[column].split_at_mut(row);
            let negative = if is_first(run) { before } else { behind };
            negative.iter_mut().for_each(|position| *position = -*position);
            keep_few_rows(&mut signed);
            undone.tests[test].recording = Some(signed);
        }
        let names = names(session, &tests);
        let says = format!(
            "column {name} of {} lost its sign: it turns back at 0 where a sweep goes on; export it with its sign",
            listed(&names)
        );
        let mut found = Suspicion::new(FaultKind::AxisSign, RECORDER, names, says, undone);
        (found.components, found.weight) = (vec![name.clone()], SOMETIMES);
        // whichever part had the sign: the first that is tried stands for all
        found.detail = Detail::Way("turns back at 0");
        Some(found)
    };
    if turns.is_empty() { Vec::new() } else { NEGATIVE_FIRST.iter().filter_map(with).collect() }
}

/// Row from which a column goes away from zero again that came to it from one side.
fn turns_back(column: &[f64]) -> Option<usize> {
    let nearest = (0..column.len()).min_by(|&a, &b| column[a].abs().total_cmp(&column[b].abs()))?;
    let is_inside = nearest >= LEAST_ROWS_BESIDE && nearest + LEAST_ROWS_BESIDE < column.len();
    let step = (column.last()? - column[nearest]).abs() / (column.len() - nearest).max(1) as f64;
    let sign = column[0].signum();
    let comes = column[..=nearest].windows(2).all(|pair| sign * (pair[1] - pair[0]) <= 0.0);
    let goes = column[nearest + 1..].windows(2).all(|pair| sign * (pair[1] - pair[0]) >= 0.0);
    (is_inside && column[nearest].abs() <= step && comes && goes).then_some(nearest + 1)
}
