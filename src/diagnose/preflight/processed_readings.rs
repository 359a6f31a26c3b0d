//! Sessions whose readings a gauge's software changed before it wrote them: zeroed at the start of each recording, or without mean or
//! centre. Which mistake was made is for others to judge.

use super::data_fault::RECORDER;
use super::places::misplaced::names;
use super::suspicion::{OFTEN, Suspicion};
use crate::session::{Recording, Session, Test, Zero};

pub(crate) const READING_PROCESSED: &str = "readings-processed";

/// Figures that every recording has alike are no chance when they agree to this, mm: cups are set to tens of micrometres.
const ALIKE_MM: f64 = 1e-4;

/// Recordings that must agree: two may.
const LEAST_TESTS: usize = 3;

/// Arc over which a centre can be taken off, deg.
const FULL_TURN_DEG: f64 = 340.0;

/// Spread of the balls of a test whose centre is not its own, mm.
const ANY_CENTRE_MM: f64 = 1.0;

/// Readings by what the recordings have in common: their first deviation, their mean one, no eccentricity.
pub(crate) fn processed(session: &Session, whole: &Session) -> Vec<Suspicion> {
    own_zeros(session, whole).into_iter().chain(centred(session, whole)).collect()
}

/// Recordings with one first deviation, or one mean.
pub(crate) fn own_zeros(session: &Session, whole: &Session) -> Vec<Suspicion> {
    let mut list = Vec::new();
    let deviations: Vec<Vec<f64>> = whole.tests.iter().filter_map(deviations).collect();
    if deviations.len() < LEAST_TESTS || deviations.len() < session.tests.len() {
        return list;
    }
    let every: Vec<usize> = (0..session.tests.len()).collect();
    let own_zero = "state 'bar_setup' and 'zero: free' for each test, or export them as they were read";
    let firsts: Vec<f64> = deviations.iter().filter_map(|deviations| deviations.first().copied()).collect();
    if are_alike(&firsts) {
        let says = format!("the gauge was zeroed at the start of every recording: zero it once a session; {own_zero}");
        list.push(suspected(session, &every, says, with_own_zero(session)));
    }
    let means: Vec<f64> =
        deviations.iter().map(|deviations| deviations.iter().sum::<f64>() / deviations.len() as f64).collect();
    if are_alike(&means) {
        let says = format!("the mean was taken off the readings of every recording: {own_zero}");
        list.push(suspected(session, &every, says, with_own_zero(session)));
    }
    list
}

/// Full turns without eccentricity.
fn centred(session: &Session, whole: &Session) -> Option<Suspicion> {
    let every = 0..session.tests.len();
    let turns: Vec<usize> = every.filter(|&test| eccentricity_mm(&whole.tests[test]).is_some()).collect();
    let centred = turns.iter().filter_map(|&test| eccentricity_mm(&whole.tests[test])).all(|mm| mm < ALIKE_MM);
    (turns.len() >= LEAST_TESTS && centred).then(|| {
        let says = "the centre was taken off the readings of every full turn, and with it what location errors do: export the readings as they were read".to_string();
        suspected(session, &turns, says, with_own_centre(session, &turns))
    })
}

fn are_alike(figures: &[f64]) -> bool {
    let first = figures.first().copied().unwrap_or(0.0);
    figures.iter().all(|figure| (figure - first).abs() < ALIKE_MM)
}

fn suspected(session: &Session, tests: &[usize], says: String, undone: Session) -> Suspicion {
    let names = if tests.len() == session.tests.len() { Vec::new() } else { names(session, tests) };
    let mut found = Suspicion::new(READING_PROCESSED, RECORDER, names, says, undone);
    found.components = vec!["length".into()];
    found.weight = OFTEN;
    found
}

/// Readings less the bar's length, mm; `None` without a bar.
fn deviations(test: &Test) -> Option<Vec<f64>> {
    let (bar, recording) = (test.bar_length_mm?, test.recording.as_ref()?);
    let finite = recording.length_mm.iter().filter(|length| length.is_finite());
    Some(finite.map(|length| length - bar).collect())
}

/// Amplitude of one wave a turn in a full turn of one axis, mm; `None` for other recordings.
fn eccentricity_mm(test: &Test) -> Option<f64> {
    let recording: &Recording = test.recording.as_ref().filter(|recording| recording.axes.len() == 1)?;
    let angles = recording.positions.first()?;
    let (least, most) = angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), q| (a.min(*q), b.max(*q)));
    if (most - least).to_degrees() < FULL_TURN_DEG || (most - least).to_degrees() > 2.0 * FULL_TURN_DEG {
        return None;
    }
    // least squares of mean, cosine and sine
    let mut normal = nalgebra::Matrix3::zeros();
    let mut right = nalgebra::Vector3::zeros();
    let middle = test.bar_length_mm.unwrap_or(0.0);
    for (angle, length) in angles.iter().zip(&recording.length_mm).filter(|(_, length)| length.is_finite()) {
        let row = nalgebra::Vector3::new(1.0, angle.cos(), angle.sin());
        normal += row * row.transpose();
        right += row * (length - middle);
    }
    normal.lu().solve(&right).map(|fit| fit[1].hypot(fit[2]))
}

fn with_own_zero(session: &Session) -> Session {
    let mut undone = session.clone();
    for (index, test) in undone.tests.iter_mut().enumerate() {
        test.bar_setup = Some(format!("zeroed for {index}"));
        test.zero = Zero::Free;
    }
    undone
}

fn with_own_centre(session: &Session, tests: &[usize]) -> Session {
    let mut undone = session.clone();
    for &index in tests {
        let test = &mut undone.tests[index];
        test.pivot.setup = Some(format!("centred for {index}"));
        test.pivot.spread_mm = Some(ANY_CENTRE_MM);
    }
    undone
}
