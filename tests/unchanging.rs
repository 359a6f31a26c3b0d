//! Recordings in which hardly anything changes: a machine without errors explains them best, and so nothing is claimed of it.

use crate::shipped::chapter5;
use fiveaxis::diagnose::{Verdict, diagnose, examine};
use fiveaxis::identify::{Fit, Options};
use fiveaxis::session::{Recording, Session};
use nalgebra::{DMatrix, DVector};

/// The circle's centre taken off a recording by least squares over its own arc, as software of ball bars does, and rounded to a step.
fn without_centre(recording: &mut Recording, step_mm: f64) {
    let angles = recording.positions[0].clone();
    let columns = DMatrix::from_fn(angles.len(), 3, |row, k| [1.0, angles[row].cos(), angles[row].sin()][k]);
    let read = DVector::from_vec(recording.length_mm.clone());
    let sizes = (columns.transpose() * &columns).cholesky().unwrap().solve(&columns.tr_mul(&read));
    for (length, angle) in recording.length_mm.iter_mut().zip(&angles) {
        let off = sizes[1] * angle.cos() + sizes[2] * angle.sin();
        *length = ((*length - off) / step_mm).round() * step_mm;
    }
}

fn determined(fit: &Fit) -> usize {
    fit.estimates.iter().filter(|estimate| estimate.determined).count()
}

fn nothing_is_claimed(session: &Session, what: &str) {
    let examination = examine(session, &Options::default()).unwrap();
    assert_eq!(examination.fit.as_ref().map_or(0, determined), 0, "{what}: {examination:?}");
    let diagnosis = diagnose(session, &Options::default()).unwrap();
    // physics that fits all the same stays open, or is told beside the doubt
    let is_doubted = diagnosis.warnings.iter().any(|warning| warning.starts_with("nothing but noise changes"));
    let is_claimed = diagnosis.findings.iter().any(|finding| finding.probability > 0.5) && !is_doubted;
    assert!(diagnosis.verdict != Verdict::Clean && !is_claimed, "{what}: {:?}", diagnosis.verdict);
    assert!(!diagnosis.location_errors.iter().any(|error| error.determined), "{what}: {:?}", diagnosis.location_errors);
}

#[test]
fn the_session_as_it_is_is_believed() {
    let examination = examine(&chapter5(), &Options::default()).unwrap();
    assert!(examination.is_sound() && !examination.is_doubtful, "{:?}", examination.warnings);
    assert!(determined(examination.fit.as_ref().unwrap()) > 4);
}

#[test]
fn centres_that_software_took_off_leave_nothing_to_determine() {
    let without = |step_mm: f64| {
        let mut session = chapter5();
        let recordings = session.tests.iter_mut().filter_map(|test| test.recording.as_mut());
        recordings.for_each(|one| without_centre(one, step_mm));
        session
    };
    nothing_is_claimed(&without(1e-4), "steps of 0.1 um");
    // files with more digits than a gauge has show by themselves what was taken off
    let examination = examine(&without(1e-6), &Options::default()).unwrap();
    assert_eq!(examination.fit.as_ref().map_or(0, determined), 0);
    let fault = examination.fault.unwrap();
    assert_eq!(fault.kind.name(), "readings-processed");
    assert!(fault.says.contains("the centre of the circle was taken off"), "{}", fault.says);
}

#[test]
fn an_axis_that_was_clamped_leaves_nothing_to_determine() {
    let mut session = chapter5();
    // the program ran, the axis did not turn: what is left is the noise about one length
    for test in session.tests.iter_mut().filter(|test| test.name.starts_with("a-")) {
        let recording = test.recording.as_mut().unwrap();
        let mean = recording.length_mm.iter().sum::<f64>() / recording.len() as f64;
        let smooth: Vec<f64> = recording.length_mm.windows(5).map(|rows| rows.iter().sum::<f64>() / 5.0).collect();
        let noise: Vec<f64> =
            recording.length_mm[2..].iter().zip(&smooth).map(|(read, smooth)| read - smooth).collect();
        for (row, length) in recording.length_mm.iter_mut().enumerate() {
            *length = ((mean + noise[row.min(noise.len() - 1)]) * 1e4).round() / 1e4;
        }
    }
    nothing_is_claimed(&session, "A clamped");
}
