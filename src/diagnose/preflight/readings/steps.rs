//! Digits with which columns were written: steps of which all values are multiples, and what readings lost that were cut to them.

use super::processed::deviations_mm;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::Sampled;
use crate::diagnose::preflight::data_fault::RECORDER;
use crate::diagnose::preflight::suspicion::Suspicion;
use crate::session::Session;

/// Steps of columns that are looked for, mm or degrees; finer ones do no harm.
const STEPS: [f64; 5] = [10.0, 1.0, 0.1, 0.01, 0.001];

/// How near to a multiple of its step a value lies, mm or degrees: a tenth of the last digit that files have.
pub(crate) const ON_STEP: f64 = 1e-7;

/// The largest step of which all values are multiples.
pub(crate) fn step<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> Option<f64> {
    let is_on = |step: &f64| {
        values().all(|value| {
            let steps = value / step;
            (steps - steps.round()).abs() * step < ON_STEP
        })
    };
    STEPS.into_iter().find(is_on)
}

/// The step of which all lengths, or all deviations from the bars' lengths, are multiples, mm.
pub(crate) fn step_of_readings(session: &Session) -> Option<f64> {
    let recorded = || session.tests.iter().filter_map(|test| Some((test.bar_length_mm, test.recording.as_ref()?)));
    let finite = |value: &f64| value.is_finite();
    let lengths = || recorded().flat_map(|(_, recording)| recording.length_mm.iter().copied()).filter(finite);
    let deviations = || {
        let of_bars = recorded().filter_map(|(bar_mm, recording)| Some((bar_mm?, &recording.length_mm)));
        of_bars.flat_map(|(bar_mm, lengths)| lengths.iter().map(move |length| length - bar_mm)).filter(finite)
    };
    let of_lengths = lengths().next().and_then(|_| step(lengths));
    let of_deviations = deviations().next().and_then(|_| step(deviations));
    of_lengths.into_iter().chain(of_deviations).reduce(f64::max)
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
