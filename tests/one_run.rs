//! Mistakes in one recording, or in the two of one run there and back of a program that was repeated: what a gauge records in one piece.

use crate::shipped::chapter5;
use fiveaxis::diagnose::{DataFault, Diagnosis, Verdict, diagnose};
use fiveaxis::identify::Options;
use fiveaxis::session::{Recording, Session};

fn changed(session: &Session, names: &[&str], change: impl Fn(&mut Recording, f64)) -> Diagnosis {
    let mut session = session.clone();
    let mut count = 0;
    for test in session.tests.iter_mut().filter(|test| names.contains(&test.name.as_str())) {
        change(test.recording.as_mut().unwrap(), test.bar_length_mm.unwrap());
        count += 1;
    }
    assert_eq!(count, names.len());
    diagnose(&session, &Options::default()).unwrap()
}

fn fault(diagnosis: &Diagnosis) -> &DataFault {
    let told: Vec<(String, f64)> =
        diagnosis.findings.iter().map(|one| (one.cause.effect.clone(), one.probability)).collect();
    assert_eq!(diagnosis.verdict, Verdict::DataFault, "{told:?}");
    diagnosis.data_fault.as_ref().unwrap()
}

const RUN: [&str; 2] = ["a-short-ccw-1", "a-short-cw-1"];

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn a_run_that_is_twice_as_large_late_or_standing_still_is_named() {
    let session = chapter5();
    let doubled = changed(&session, &RUN, |recording, bar_mm| {
        recording.length_mm.iter_mut().for_each(|length| *length += *length - bar_mm);
    });
    let doubled = fault(&doubled);
    assert_eq!(
        (doubled.kind.name(), doubled.tests.as_slice()),
        ("unit", &RUN.map(String::from)[..]),
        "{}",
        doubled.says
    );
    assert!(
        doubled.says.contains("about 2.0") && doubled.probability > 0.9,
        "{} {}",
        doubled.says,
        doubled.probability
    );
    let late = changed(&session, &RUN, |recording, _| {
        recording.length_mm.rotate_right(5);
        let first = recording.length_mm[5];
        recording.length_mm[..5].fill(first);
    });
    let late = fault(&late);
    assert_eq!((late.kind.name(), late.tests.as_slice()), ("time-shift", &RUN.map(String::from)[..]), "{}", late.says);
    assert!(late.shift_ms.is_some_and(|ms| (ms.abs() - 500.0).abs() < 100.0), "{:?}", late.shift_ms);
    // noise as that of the last rows of each recording, about its first reading
    let still = changed(&session, &RUN, |recording, _| {
        let first = recording.length_mm[0];
        let noise: Vec<f64> =
            recording.length_mm.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]) / 4.5).collect();
        let count = noise.len();
        recording.length_mm.iter_mut().enumerate().for_each(|(row, length)| *length = first + noise[row % count]);
    });
    let still = fault(&still);
    assert_eq!(
        (still.kind.name(), still.tests.as_slice()),
        ("standing-axis", &RUN.map(String::from)[..]),
        "{}",
        still.says
    );
    assert!(still.says.starts_with("no axis moved"), "{}", still.says);
}

#[test]
fn a_run_in_that_was_left_in_a_recording_is_named_with_its_rows() {
    let session = chapter5();
    let left_in = changed(&session, &["c-short-ccw-1"], |recording, _| {
        let read = recording.length_mm.clone();
        let (count, rows) = (read.len(), 20.0);
        // twenty rows of a dwell before the arc, the positions spread over them and the others
        let share = (count as f64 - 1.0 + rows) / (count as f64 - 1.0);
        recording.length_mm.iter_mut().enumerate().for_each(|(row, length)| {
            let place = (row as f64 * share - rows).max(0.0);
            let below = (place.floor() as usize).min(count - 2);
            *length = read[below] + (place - below as f64) * (read[below + 1] - read[below]);
            // a gauge that stands still scatters
            *length += if place == 0.0 { [2e-4, -1e-4, 1e-4, -2e-4, 0.0][row % 5] } else { 0.0 };
        });
    });
    let left_in = fault(&left_in);
    assert_eq!(
        (left_in.kind.name(), left_in.tests.as_slice()),
        ("dwell", &["c-short-ccw-1".to_string()][..]),
        "{}",
        left_in.says
    );
}
