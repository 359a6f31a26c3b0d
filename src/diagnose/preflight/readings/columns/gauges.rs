//! Displacements of gauges with another sense or unit, undone. Which mistake was made is for others to judge.

use super::undone::{Undone, is_of};
use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::RECORDER;
use crate::diagnose::preflight::doubts::MOST_NOISE_UM;
use crate::identify::{FreePrior, Problem, residual_mm};
use crate::readings::Kind;
use crate::session::{Session, Setups, Test};
use crate::statistics::{median, noise_of_rows, rms};
use crate::units::OtherUnit;

/// The largest scatter of a gauge about the nominal chain, its zero wherever it fits best, at the size at which it was read.
pub(super) fn gauges_mm(session: &Session, scale_of: &dyn Fn(&Test) -> f64) -> Option<f64> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, Vec::new()).ok()?;
    let residual_mm = residual_mm(&problem, &[]);
    let scatter = |test: usize| {
        let read = || residual_mm[test].iter().copied().filter(|value| value.is_finite());
        let zero = median(read())?;
        Some(rms(read().map(|value| value - zero)) / scale_of(&session.tests[test]))
    };
    (0..session.tests.len()).filter(|&test| is_gauge(&session.tests[test])).filter_map(scatter).max_by(f64::total_cmp)
}

fn is_gauge(test: &Test) -> bool {
    test.reading.part().is_some_and(|part| part.kind == Kind::Displacement)
}

/// Whether a gauge is off by more than a machine errs and scatters from row to row by more than a gauge in order.
fn beyond_any_machine(session: &Session) -> bool {
    let is_far = gauges_mm(session, &|_| 1.0).is_some_and(|mm| mm > FreePrior::of(&session.machine).length_mm);
    let of = session.tests.iter().filter(|test| is_gauge(test)).filter_map(|test| test.recording.as_ref());
    is_far && of.map(|recording| 1e3 * noise_of_rows(&recording.length_mm)).fold(0.0, f64::max) > MOST_NOISE_UM
}

/// Senses and units of displacements: of one gauge, undone.
pub(super) fn mistakes_of_gauges(session: &Session) -> Vec<Undone> {
    let in_unit =
        |unit: OtherUnit| (unit.size, FaultKind::Unit, format!("is in {}: convert the column to mm", unit.name));
    let factors = [
        (-1.0, FaultKind::ReadingSign, "has the other sign: turn its direction, or the sign of the column".to_string()),
        in_unit(OtherUnit::METRES),
        in_unit(OtherUnit::MICROMETRES),
        in_unit(OtherUnit::INCHES),
    ];
    let mut gauges: Vec<&Test> = Vec::new();
    for test in session.tests.iter().filter(|test| is_gauge(test)) {
        if !gauges.iter().any(|gauge| gauge.pivot == test.pivot && gauge.stated_name() == test.stated_name()) {
            gauges.push(test);
        }
    }
    let are_no_mm = beyond_any_machine(session);
    let every: Vec<String> = gauges.iter().map(|gauge| gauge.stated_name().to_string()).collect();
    let mut groups: Vec<Vec<String>> = every.iter().map(|name| vec![name.clone()]).collect();
    if every.len() > 1 {
        groups.push(every);
    }
    let of = |names: &Vec<String>| {
        let whom = match names.len() {
            1 => format!("the displacement of {}", names[0]),
            _ => "every displacement".to_string(),
        };
        factors.each_ref().map(|&(factor, kind, ref words)| {
            let mut undone = session.clone();
            for test in undone.tests.iter_mut().filter(|test| is_gauge(test) && is_of(test, names)) {
                let lengths = test.recording.iter_mut().flat_map(|recording| &mut recording.length_mm);
                lengths.for_each(|value| *value *= factor);
            }
            let (components, says) = (vec!["displacement".to_string()], format!("{whom} {words}"));
            // so large and so restless no reading in mm is: how much smaller it gets says nothing more
            let scale = if are_no_mm && factor < 1.0 { 1.0 } else { factor.abs() };
            Undone { kind, place: RECORDER, components, says, session: undone, scale: (scale, Some(names.clone())) }
        })
    };
    groups.iter().flat_map(of).collect()
}
