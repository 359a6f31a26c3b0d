//! The gauge of `simulate --instrument`: noise as stated, steps of its resolution, refusal outside its stroke.

use crate::recorded;
use std::process::Command;

use fiveaxis::chain::Composition;
use fiveaxis::simulate::{Instrument, SetupErrors, simulate, simulate_with};
use recorded::planned_thesis_session;

const UM: f64 = 1e-3;

#[test]
fn noise_has_the_stated_size_and_correlation() {
    let session = planned_thesis_session(4000);
    let ideal = simulate(&session, Composition::Exact).unwrap();
    let instrument = Instrument {
        resolution_mm: 0.0,
        white_mm: 0.2 * UM,
        correlated_mm: 0.3 * UM,
        correlation_time_s: 0.5,
        drift_mm_per_sqrt_s: 0.0,
        ..Instrument::default()
    };
    let (mut square, mut lagged, mut count, mut expected_lagged) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..20 {
        let read = instrument.read(&session, ideal.clone(), seed).unwrap();
        for (read, ideal) in read.iter().zip(&ideal) {
            let noise: Vec<f64> = read.length_mm.iter().zip(&ideal.length_mm).map(|(a, b)| (a - b) / UM).collect();
            let time = ideal.motion.time_s.as_ref().unwrap();
            for (pair, time) in noise.windows(2).zip(time.windows(2)) {
                square += pair[0] * pair[0];
                lagged += pair[0] * pair[1];
                expected_lagged += 0.09 * (-(time[1] - time[0]) / 0.5).exp();
                count += 1.0;
            }
        }
    }
    // 640,000 readings correlated over some fifty of them: the variance is known to about one per cent
    assert!((square / count - 0.13).abs() < 0.005, "{}", square / count);
    assert!((lagged - expected_lagged).abs() / count < 0.005, "{} {}", lagged / count, expected_lagged / count);
}

#[test]
fn drift_grows_with_the_root_of_time() {
    let session = planned_thesis_session(200);
    let ideal = simulate(&session, Composition::Exact).unwrap();
    let instrument = Instrument {
        resolution_mm: 0.0,
        white_mm: 0.0,
        correlated_mm: 0.0,
        drift_mm_per_sqrt_s: 0.1 * UM,
        ..Instrument::default()
    };
    let mut ratio = 0.0;
    let seeds = 400;
    for seed in 0..seeds {
        let read = instrument.read(&session, ideal.clone(), seed).unwrap();
        let off = read[0].length_mm[199] - ideal[0].length_mm[199];
        let time = ideal[0].motion.time_s.as_ref().unwrap()[199];
        ratio += off * off / (0.01 * UM * UM * time);
        assert_eq!(read[0].length_mm[0], ideal[0].length_mm[0]);
    }
    // a chi-square of 400 has a relative standard deviation of 0.07
    assert!((ratio / seeds as f64 - 1.0).abs() < 0.28, "{}", ratio / seeds as f64);
}

#[test]
fn seeds_repeat_and_tests_do_not_disturb_each_other() {
    let session = planned_thesis_session(50);
    let instrument = Instrument::default();
    let read = |session: &fiveaxis::session::Session, seed| {
        let ideal = simulate(session, Composition::Exact).unwrap();
        instrument.read(session, ideal, seed).unwrap()
    };
    let (one, two, other) = (read(&session, 5), read(&session, 5), read(&session, 6));
    assert_eq!(one, two);
    assert_ne!(one[0].length_mm, other[0].length_mm);
    let mut fewer = session.clone();
    fewer.tests.truncate(3);
    assert_eq!(read(&fewer, 5)[..], one[..3]);
    let steps = one[0].length_mm.iter().map(|length| length / 1e-4);
    assert!(steps.into_iter().all(|step| (step - step.round()).abs() < 1e-6));
}

#[test]
fn setups_are_drawn_with_their_spreads_and_shared() {
    let session = planned_thesis_session(3);
    let (mut pivot, mut ball, mut bar) = (0.0, 0.0, 0.0);
    let seeds = 2000;
    for seed in 0..seeds {
        let drawn = SetupErrors::drawn(&session, seed);
        assert!(drawn.pivot_mm.iter().all(|error| *error == drawn.pivot_mm[0]), "one pivot setup for all tests");
        pivot += drawn.pivot_mm[0].norm_squared();
        ball += drawn.spindle_mm[0].norm_squared();
        bar += drawn.bar_mm[0].powi(2);
    }
    let (pivot, ball, bar) = (pivot / 3.0 / seeds as f64, ball / 3.0 / seeds as f64, bar / seeds as f64);
    // relative standard deviation of a variance from 2000 draws: 0.032
    for (found, stated) in [(pivot, 20.0 * UM), (ball, 1.0 * UM), (bar, 0.5 * UM)] {
        assert!((found / (stated * stated) - 1.0).abs() < 0.13, "{} for {stated}", found.sqrt());
    }
    let none = simulate(&session, Composition::Exact).unwrap();
    let with_none = simulate_with(&session, Composition::Exact, &SetupErrors::none(&session)).unwrap();
    assert_eq!(none, with_none);
}

#[test]
fn lengths_outside_the_stroke_are_refused_with_test_row_and_amount() {
    let mut session = planned_thesis_session(50);
    session.tests[2].spindle_ball.at.y += 2.5;
    let ideal = simulate(&session, Composition::Exact).unwrap();
    let why = Instrument::default().read(&session, ideal, 1).map(|_| ()).unwrap_err().to_string();
    let name = &session.tests[2].name;
    assert!(why.starts_with(&format!("test '{name}', row ")), "{why}");
    assert!(why.contains("mm is ") && why.contains(" the stroke of the "), "{why}");
    // a gauge without a bar has no stroke
    session.tests.iter_mut().for_each(|test| test.bar_length_mm = None);
    let ideal = simulate(&session, Composition::Exact).unwrap();
    assert!(Instrument::default().read(&session, ideal, 1).is_ok());
}

#[test]
fn instrument_files_are_read_or_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let session = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/thesis/chapter5/session.yaml");
    let run = |text: &str| {
        let file = folder.path().join("gauge.yaml");
        std::fs::write(&file, text).unwrap();
        let out = folder.path().join("out");
        let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
            .args(["simulate", session, "--out", out.to_str().unwrap(), "--instrument", file.to_str().unwrap()])
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let good = "name: gauge\nresolution: 0.1 um\nstroke: [-1, 1]\nnoise: {white: 0.15 um, correlated: 0.1 um, correlation_time: 1.2, drift: 0.02 um}\n";
    assert_eq!(run(good), (Some(0), String::new()));
    for (text, message) in [
        ("name: g\nresolution: 0.1\n", "gauge.yaml:2:1: '0.1' has no unit; write for example '0.1 um'"),
        ("name: g\nstroke: [1, 2]\n", "stroke [1, 2] does not hold the bar's length"),
        ("name: g\nstrokes: [-1, 1]\n", "did you mean 'stroke'?"),
        ("name: g\nnoise: {correlated: 1 um}\n", "correlated noise needs a correlation_time in seconds"),
        ("name: g\nnoise: {white: 3 mm}\n", "3 mm is not allowed; 0 to 1 mm are"),
        ("name: g\nnoise: {white: 1 um, correlation_time: 0}\n", "0 is no time; write seconds above 0"),
    ] {
        let (code, found) = run(text);
        assert_eq!(code, Some(2), "{text}");
        assert!(found.contains(message), "{found}");
    }
}

#[test]
fn rows_far_apart_take_the_time_of_rows_close_together() {
    let [coarse, fine] = [2, 2000].map(|rows| simulate(&planned_thesis_session(rows), Composition::Exact).unwrap());
    assert!(!fine.is_empty());
    for (coarse, fine) in coarse.iter().zip(&fine) {
        let [coarse, fine] = [coarse, fine].map(|trace| *trace.motion.time_s.as_ref().unwrap().last().unwrap());
        // chords of 10° are shorter than their arcs by 1.3e-3; a whole turn in one step has no chord at all
        assert!(fine > 1.0 && (coarse / fine - 1.0).abs() < 2e-3, "{coarse} {fine}");
    }
}
