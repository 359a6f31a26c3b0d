//! Which left-out physics turns the thesis's three methods against each other, and that a diagnosis finds it or says it is blind.

use crate::examples::thesis_mismatch::{causes, designs, outcome};
use crate::shipped;
use causes::{CAUSES, LeftOut, seed_of};
use outcome::{ByMethod, ORIENTATIONS, Outcome, by_method, outcomes, shown};

fn cause(part: &str) -> (LeftOut, u64) {
    let index = CAUSES.iter().position(|cause| cause.name.contains(part)).unwrap_or_else(|| panic!("no cause {part}"));
    (CAUSES[index], seed_of(index))
}

fn methods(part: &str) -> [ByMethod; 4] {
    let (cause, seed) = cause(part);
    by_method(&designs::designs().unwrap(), &cause, seed).unwrap()
}

/// What the cause alone does: with it minus without, the same draws in both.
fn alone(part: &str) -> [ByMethod; 4] {
    let (cause, seed) = cause(part);
    of_cause_alone(&cause, seed)
}

fn of_cause_alone(cause: &LeftOut, seed: u64) -> [ByMethod; 4] {
    let designs = designs::designs().unwrap();
    let mut errors = by_method(&designs, cause, seed).unwrap();
    for (with, without) in errors.iter_mut().zip(by_method(&designs, &CAUSES[0], seed).unwrap()) {
        with.value.iter_mut().zip(without.value).for_each(|(with, without)| *with -= without);
    }
    errors
}

fn of<'a>(errors: &'a [ByMethod; 4], name: &str) -> &'a ByMethod {
    &errors[ORIENTATIONS.iter().position(|other| *other == name).unwrap()]
}

#[test]
fn with_nothing_left_out_the_methods_agree_and_are_right() {
    let errors = methods("nothing");
    for (by, name) in errors.iter().zip(ORIENTATIONS) {
        println!("{name}: {:?} ± {:?}, {:.2} sigma", by.value, by.sigma, by.in_sigmas());
        assert!(by.in_sigmas() < 3.0, "{name}");
        let inserted = designs::INSERTED.iter().find(|(other, _)| *other == name).unwrap().1;
        // chapter 6 has the longest arms
        assert!((by.value[2] - inserted).abs() < 4.0 * by.sigma[2], "{name}: {}", by.value[2]);
    }
}

#[test]
fn what_acts_on_one_of_two_circles_turns_the_methods_against_each_other() {
    // closed form: an axial motion a sin q of the turning axis adds (h/L) a sin q to a bar that sweeps a cone, which the
    // reduction to its plane of radius R reads as a centre moved by (h/R) a, so a tilt of a/R
    let axial = methods("EZC");
    let expected = 3e-3 / 100.0 * fiveaxis::units::ARCSEC_PER_RAD;
    for name in ["EA0C", "EB0C"] {
        println!("{name} under axial motion of C: {:?}, closed form {expected:.2}", of(&axial, name).value);
    }
    // chapter 4's pivot stands on x: sine is EA0C there; chapter 5's on y, 90° on: EB0C there
    let (a, b) = (of(&axial, "EA0C"), of(&axial, "EB0C"));
    assert!(((a.value[0] - a.value[2]).abs() - expected).abs() < 0.5, "{:?}", a.value);
    assert!(((b.value[1] - b.value[2]).abs() - expected).abs() < 1.0, "{:?}", b.value);
    assert!(a.in_sigmas() > 10.0 && b.in_sigmas() > 5.0);
    // the two methods that share their lever arms disagree with each other as well
    assert!((a.value[0] - a.value[1]).abs() > 5.0);
    // a wrong seat of the ball: 3.2 µm in z over 111.8 mm, over 550 mm in chapter 6; both go to −x after the first change,
    // so the two angles have the same sign
    let seat = methods("seats anew");
    let expected = 3.2e-3 * (1.0 / 111.803 - 1.0 / 550.0) * fiveaxis::units::ARCSEC_PER_RAD;
    let by = of(&seat, "EB0A");
    assert!(((by.value[0] - by.value[2]).abs() - expected).abs() < 1.0, "{:?}, {expected}", by.value);
    for part in ["EXA", "EYX"] {
        let errors = methods(part);
        let worst = errors.iter().map(ByMethod::in_sigmas).fold(0.0, f64::max);
        println!("{part}: {worst:.1} sigma");
        assert!(worst > 6.0, "{part}: {worst}");
    }
}

/// Mean over the runs of a circle of `1 − e^(−t/τ)`, the time counted over the session, and where X stands in it, mm.
fn grown(design: &designs::Design, circle: &str) -> (f64, f64) {
    let x = design.session.machine.axis_index("X").unwrap();
    let runs: Vec<_> = design.session.tests.iter().filter(|test| test.name.starts_with(circle)).collect();
    let share = |time_s: f64| 1.0 - (-time_s / 1800.0).exp();
    let of_run = |test: &&fiveaxis::session::Test| {
        let time_s = test.recording.as_ref().and_then(fiveaxis::session::Recording::time_s).unwrap();
        time_s.iter().map(|time| share(test.started_at_s + time)).sum::<f64>() / time_s.len() as f64
    };
    (runs.iter().map(of_run).sum::<f64>() / runs.len() as f64, runs[0].positions[x].unwrap())
}

/// Growth does less than what sits in one circle alone: an axis's two circles follow each other within a quarter of an hour.
#[test]
fn growth_sets_the_methods_apart_by_what_it_grows_between_two_circles() {
    let designs = designs::designs().unwrap();
    // growth g along z moves the axis away from the ball: EB0A = (g2 − g1)/(x2 − x1); along y: EC0A the other way
    for (part, name, size_um) in [("grows down", "EB0A", 15.0), ("sideways", "EC0A", -10.0)] {
        let found = alone(part);
        let circles = [["a-short", "a-extended"], ["a-short", "a-extended"], ["a-position-1", "a-position-2"]];
        let predicted: Vec<f64> = designs
            .iter()
            .zip(circles)
            .map(|(design, circles)| {
                let [(first, from_mm), (second, to_mm)] = circles.map(|circle| grown(design, circle));
                size_um * 1e-3 * (second - first) / (to_mm - from_mm) * fiveaxis::units::ARCSEC_PER_RAD
            })
            .collect();
        println!("{part} {name}: {:?}, closed form {predicted:?}", of(&found, name).value);
        for (value, predicted) in of(&found, name).value.iter().zip(&predicted) {
            // a run's own growth is not its mean: over the arc it is taken for a little of the centre
            assert!((value - predicted).abs() < 0.05, "{part}: {value} for {predicted}");
        }
        let spread = predicted.iter().copied().fold(0.0_f64, |worst, value| worst.max((value - predicted[2]).abs()));
        assert!((of(&found, name).spread() - spread).abs() < 0.1, "{part}: {spread}");
    }
}

#[test]
fn what_acts_on_both_circles_alike_does_not() {
    for part in ["own axis tilts", "runs out", "sags", "not square", "pivots off", "calibrated wrongly"] {
        let errors = methods(part);
        for (by, name) in errors.iter().zip(ORIENTATIONS) {
            // no two methods differ by more than four of their standard deviations; with an arcsec of room for those of
            // five degrees of freedom that come out too small
            assert!(by.in_sigmas() < 4.0 || by.spread() < 1.0, "{part}, {name}: {:?} ± {:?}", by.value, by.sigma);
        }
    }
    // yet all three are wrong together: squareness of 20″ stands in each
    let inserted = designs::INSERTED.iter().find(|(name, _)| *name == "EB0C").unwrap().1;
    let by = methods("not square")[3].clone();
    for value in by.value {
        assert!(((value - inserted).abs() - 20.0).abs() < 2.0, "{value}");
    }
}

#[test]
fn axial_motion_gives_the_largest_disagreement_per_size() {
    // of the cause alone: noise adds up to 0.2″ per µm to what the smaller causes show
    let per_unit = |index: usize| {
        let errors = of_cause_alone(&CAUSES[index], seed_of(index));
        errors.iter().map(ByMethod::spread).fold(0.0, f64::max) / CAUSES[index].size
    };
    let lengths = (1..CAUSES.len()).filter(|&index| CAUSES[index].unit == "um");
    let mut ranked: Vec<(f64, &str)> = lengths.map(|index| (per_unit(index), CAUSES[index].name)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!("{ranked:#?}");
    assert!(ranked[..2].iter().all(|(_, name)| name.contains("along its axis")), "{ranked:?}");
    // next a place that one circle alone stands on: its arm is the distance of the two, 111.8 mm
    let over_d = fiveaxis::units::ARCSEC_PER_RAD / 111.803e3;
    assert!(ranked[2].1.contains("worn") && (ranked[2].0 - over_d).abs() < 0.03, "{ranked:?}");
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn axial_motion_is_listed_as_out_of_sight_and_found_once_the_design_can_show_it() {
    found_or_listed(&["EZC", "EXA"]);
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn a_seat_and_a_bow_are_found_or_listed_as_out_of_sight_and_found_once_the_design_can_show_them() {
    found_or_listed(&["seats anew", "EZX"]);
}

/// In every design found or listed as blind; found in the extension. The first cause alone, all of them with
/// `FIVEAXIS_TESTS=all`.
fn found_or_listed(parts: &[&str]) {
    let designs = designs::designs().unwrap();
    let count = if shipped::is_thorough() { parts.len() } else { 1 };
    for part in &parts[..count] {
        let (cause, seed) = cause(part);
        for (outcome, chapter) in outcomes(&designs, &cause, seed).unwrap().iter().zip([4, 5, 6]) {
            println!("{}, chapter {chapter}: {outcome:?}", cause.name);
            assert!(matches!(outcome, Outcome::Found { .. } | Outcome::Blind(_)), "{}, chapter {chapter}", cause.name);
        }
        let (session, outcome) = shown(&designs, &cause, seed).unwrap().unwrap();
        println!("{}, {session}: {outcome:?}", cause.name);
        assert!(matches!(outcome, Outcome::Found { .. }), "{}, {session}", cause.name);
    }
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn growth_is_found_when_the_first_tests_are_run_again_at_the_end() {
    let designs = designs::designs().unwrap();
    // growth lies near the limit of two designs (docs/thesis_mismatch.md); the repeat at the end must show it
    let (growth, seed) = cause("grows down");
    let (session, outcome) = shown(&designs, &growth, seed).unwrap().unwrap();
    println!("{}, {session}: {outcome:?}", growth.name);
    assert!(matches!(outcome, Outcome::Found { .. }), "{session}");
}
