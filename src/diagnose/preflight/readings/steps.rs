//! Digits with which columns were written: steps of which all values are multiples, and what readings lost that were cut to them.

use super::processed::deviations_mm;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::Sampled;
use crate::diagnose::preflight::data_fault::RECORDER;
use crate::diagnose::preflight::suspicion::Suspicion;
use crate::session::{Session, Test};

/// The step of which all lengths, or all deviations from the bars' lengths, are multiples, mm.
pub(crate) fn step_of_readings(session: &Session) -> Option<f64> {
    let recorded = session.tests.iter().filter(|test| test.recording.is_some());
    let steps: Option<Vec<f64>> = recorded.map(Test::last_digit_mm).collect();
    steps?.into_iter().reduce(f64::min)
}

/// Deviations of all recordings that were cut to whole steps towards zero, and lost half a step on average.
pub(crate) fn cut_off(sampled: Sampled<'_>) -> Option<Suspicion> {
    let Sampled { few_rows: session, all_rows: whole } = sampled;
    let all: Vec<f64> = whole.tests.iter().filter_map(deviations_mm).flatten().filter(|one| one.is_finite()).collect();
    let has_both_signs = all.iter().any(|one| *one > 0.0) && all.iter().any(|one| *one < 0.0);
    let step_mm = step_of_readings(whole).filter(|_| has_both_signs)?;
    let mut undone = session.clone();
    for test in &mut undone.tests {
        let (Some(bar_mm), Some(recording)) = (test.bar_length_mm, &mut test.recording) else { continue };
        let lost = |deviation: f64| if deviation.abs() < 0.5 * step_mm { 0.0 } else { deviation.signum() };
        recording.length_mm.iter_mut().for_each(|length| *length += 0.5 * step_mm * lost(*length - bar_mm));
    }
    let says = format!(
        "deviations were cut to whole multiples of {step_mm} mm, towards zero: export them with all their digits"
    );
    let mut found = Suspicion::new(FaultKind::ValuesRounded, RECORDER, Vec::new(), says, undone);
    found.components = vec!["length".into()];
    Some(found)
}
