//! Sessions whose readings a gauge's software changed before it wrote them: zeroed at the start of each recording, or without mean.
//! Which mistake was made is for others to judge. A centre taken off looks like a machine without location errors.

use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::Sampled;
use crate::diagnose::preflight::data_fault::RECORDER;
use crate::diagnose::preflight::suspicion::{Detail, OFTEN, Suspicion};
use crate::session::{Session, Test, Zero};
use crate::statistics::{mean, median};

/// Deviations that differ by less are equal, mm: files have seven digits after the point at most.
pub(crate) const NO_DIGIT_MM: f64 = 5e-8;

/// Figures that every recording has alike are no chance when they agree to this, mm: cups are set to tens of micrometres.
const ALIKE_MM: f64 = 1e-4;

/// Recordings that must agree: two may.
const LEAST_TESTS: usize = 3;

/// Recordings with one first deviation, or one mean.
pub(crate) fn own_zeros(sampled: Sampled<'_>) -> Vec<Suspicion> {
    let Sampled { few_rows: session, all_rows: whole } = sampled;
    let mut list = Vec::new();
    let read = |deviations: Vec<f64>| deviations.into_iter().filter(|deviation| deviation.is_finite()).collect();
    let deviations: Vec<Vec<f64>> = whole.tests.iter().filter_map(deviations_mm).map(read).collect();
    // deviations in too small a unit are all alike
    let range_mm = |deviations: &Vec<f64>| {
        let (least, most) =
            deviations.iter().fold((f64::MAX, f64::MIN), |(least, most), d| (least.min(*d), most.max(*d)));
        most - least
    };
    let hardly_change = median(deviations.iter().map(range_mm)).is_none_or(|range_mm| range_mm < ALIKE_MM);
    if hardly_change || deviations.len() < LEAST_TESTS || deviations.len() < session.tests.len() {
        return list;
    }
    let own_zero = "state 'bar_setup' and 'zero: free' for each test, or export them as they were read";
    let firsts: Vec<f64> = deviations.iter().filter_map(|deviations| deviations.first().copied()).collect();
    if are_alike(&firsts) {
        let says = format!("the gauge was zeroed at the start of every recording: zero it once a session; {own_zero}");
        list.push(suspected(session, says, "first"));
    }
    let means: Vec<f64> =
        deviations.iter().map(|deviations| mean(deviations.iter().copied()).unwrap_or(f64::NAN)).collect();
    if are_alike(&means) {
        let says = format!("the mean was taken off the readings of every recording: {own_zero}");
        list.push(suspected(session, says, "mean"));
    }
    list
}

fn are_alike(figures: &[f64]) -> bool {
    let first = figures.first().copied().unwrap_or(0.0);
    figures.iter().all(|figure| (figure - first).abs() < ALIKE_MM)
}

fn suspected(session: &Session, says: String, way: &'static str) -> Suspicion {
    let mut found = Suspicion::new(FaultKind::ReadingsProcessed, RECORDER, Vec::new(), says, with_own_zero(session));
    (found.components, found.detail) = (vec!["length".into()], Detail::Way(way));
    found.weight = OFTEN;
    found
}

/// Readings less the bar's length, mm, NaN where there is no reading; `None` without a bar.
pub(crate) fn deviations_mm(test: &Test) -> Option<Vec<f64>> {
    let (bar_mm, recording) = (test.bar_length_mm?, test.recording.as_ref()?);
    Some(recording.length_mm.iter().map(|length| length - bar_mm).collect())
}

fn with_own_zero(session: &Session) -> Session {
    let mut undone = session.clone();
    for (index, test) in undone.tests.iter_mut().enumerate() {
        test.bar_setup = Some(format!("zeroed for {index}"));
        test.zero = Zero::Free;
    }
    undone
}
