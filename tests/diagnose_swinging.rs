//! Vibrations that breathe many times in a recording, and the direction along which a ball swings; growth that a gauge whose
//! zero wanders does as well.

use crate::noisy;
use std::f64::consts::TAU;

use fiveaxis::chain::Chain;
use fiveaxis::diagnose::{Verdict, diagnose};
use fiveaxis::effects::{Context, kind};
use fiveaxis::identify::Options;
use fiveaxis::machine::{Component, Effect, Outlet, ParameterValue, Place, Size};
use fiveaxis::session::{Clock, Session};
use noisy::{gallery, noisy, recorded};

/// Sweeps of one rotary axis at a time, and circles in planes.
const SWEEPS: &str = "05-table-bearing";
const PLANAR: &str = "03-lost-motion";

fn number(value: f64) -> ParameterValue {
    ParameterValue::Number(value)
}

/// B-spline of a degree on knots `from`, `from` + 1, … by the recursion of Cox and de Boor.
fn b_spline(degree: u32, from: f64, x: f64) -> f64 {
    if degree == 0 {
        return if (from..from + 1.0).contains(&x) { 1.0 } else { 0.0 };
    }
    let width = f64::from(degree);
    let rises = (x - from) / width * b_spline(degree - 1, from, x);
    rises + (from + width + 1.0 - x) / width * b_spline(degree - 1, from + 1.0, x)
}

#[test]
fn a_wander_with_knots_follows_splines_that_add_up_to_the_plain_wave() {
    let session = gallery(SWEEPS);
    let (hz, every, wander) = (3.0, 4.0, 9usize);
    let vibration = Effect::new("vibration", Place::SpindleBall)
        .with("frequency", number(hz))
        .with("clock", ParameterValue::Word("test".into()))
        .with("wander", number(wander as f64))
        .with("every", number(every));
    let chain = Chain::of(&session.machine);
    let context = Context::of(&session, &chain).expect("context");
    let kind = kind("vibration").expect("kind");
    assert_eq!((kind.functions)(&vibration)[2..4], ["cos-k1", "sin-k1"]);
    let profiles = kind.shape(&context, &vibration).expect("profiles");
    assert_eq!(profiles.len(), 2 * (wander + 1));
    for test in 0..context.tests() {
        let time = context.motion(test).time_s.as_ref().expect("times");
        for (row, t) in time.iter().enumerate() {
            let (sin, cos) = (TAU * hz * (t - time[0])).sin_cos();
            // constant beyond the last knot but one
            let x = ((t - time[0]) / every).min(wander as f64 - 2.0);
            for k in 0..=wander {
                // a cubic one spans four intervals, two on each side of its centre k − 1
                let expected = b_spline(3, k as f64 - 3.0, x);
                let found = [profiles[2 * k][test][row], profiles[2 * k + 1][test][row]];
                let off = (found[0] - cos * expected).abs().max((found[1] - sin * expected).abs());
                assert!(off < 1e-9, "test {test} row {row} knot {k}: off by {off}");
            }
            let sum: f64 = profiles.iter().step_by(2).map(|profile| profile[test][row]).sum();
            assert!((sum - cos).abs() < 1e-9, "test {test} row {row}: {sum} for {cos}");
        }
    }
}

/// A vibration of the spindle ball along a direction, mm, whose amplitude swells by a share at a rate: three lines.
fn breathing(along: [f64; 3], (hz, breath_hz, share): (f64, f64, f64)) -> Vec<Effect> {
    let line = |hz: f64, size: f64| {
        let effect = Effect::new("vibration", Place::SpindleBall).with("frequency", number(hz));
        (0..3).fold(effect, |effect, k| effect.size(Outlet::SpindleBall(k), "cos", size * along[k]))
    };
    vec![line(hz, 1.0), line(hz + breath_hz, 0.5 * share), line(hz - breath_hz, 0.5 * share)]
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn a_ball_that_swings_along_one_direction_and_breathes_is_one_vibration_of_its_size() {
    for (direction, hz) in [([0.60, 0.48, -0.64], 1.9), ([-0.28, 0.1, 0.95], 2.7), ([0.36, -0.93, 0.08], 7.3)] {
        let length = f64::sqrt(direction.iter().map(|x| x * x).sum());
        let along = direction.map(|x| 2.5e-3 * x / length);
        let session = noisy(SWEEPS, breathing(along, (hz, 0.07, 0.3)));
        let found = diagnose(&session, &Options::default()).expect("diagnosis");
        let causes: Vec<_> = found.findings.iter().map(|finding| (&finding.cause, &finding.size)).collect();
        let [finding] = &found.findings[..] else { panic!("{causes:?}") };
        assert_eq!((finding.cause.effect.as_str(), finding.cause.place.as_str()), ("vibration", "spindle-ball"));
        assert!((finding.size.value / 2.5 - 1.0).abs() < 0.1, "{:?}", finding.size);
        assert_eq!(found.verdict, Verdict::Explained);
        // the file has one motion in the ratio of the direction
        let effects = || found.findings.iter().flat_map(|finding| &finding.effects);
        assert!(effects().all(|effect| effect.parameters.iter().all(|(name, _)| name != "along")));
        let unit = along.map(|x| x / 2.5e-3);
        // parts behind the first tell what is left of it, some along one axis
        for effect in finding.effects.iter().take(1) {
            for function in effect.sizes.iter().map(|size| &size.function) {
                let of = |k: usize| {
                    let own = |size: &&Size| size.outlet == Outlet::SpindleBall(k) && size.function == *function;
                    effect.sizes.iter().find(own).expect("size").value
                };
                let told = [of(0), of(1), of(2)];
                let product: f64 = told.iter().zip(unit).map(|(a, b)| a * b).sum();
                let length = f64::sqrt(told.iter().map(|x| x * x).sum());
                assert!(product.abs() > 0.99 * length, "{told:?} for {along:?}");
            }
        }
    }
}

#[test]
fn a_slide_that_breathes_many_times_in_a_recording_is_followed_by_splines() {
    // a swing of four fifths in eleven seconds: no polynomial of the third degree over a minute has it
    let y = gallery(PLANAR).machine.axis_index("Y").expect("Y");
    let line = |hz: f64, size: f64| {
        let own = Outlet::Motion { axis: y, component: Component::EY };
        Effect::new("vibration", Place::Axis(y)).with("frequency", number(hz)).size(own, "cos", size)
    };
    let breathing = vec![line(3.1, 3e-3), line(3.19, 1.2e-3), line(3.01, 1.2e-3)];
    let found = diagnose(&noisy(PLANAR, breathing), &Options::default()).expect("diagnosis");
    let [finding] = &found.findings[..] else { panic!("{}", found.findings.len()) };
    assert!(finding.effects.iter().any(|effect| effect.number("every").is_some()));
    // the square of the whole is that of three lines
    let size = 3.0 * f64::sqrt(1.0 + 2.0 * 0.4 * 0.4);
    assert!((finding.size.value / size - 1.0).abs() < 0.1, "{:?} for {size}", finding.size);
    assert!(found.rms_after_um < 0.3, "{}", found.rms_after_um);
    // readings between those that it was learnt from as well
    let proof = found.proof.expect("proof");
    assert!(proof.after_um < 0.35, "{proof:?}");
}

/// A gauge whose zero follows the tide: a slow wave over the session, mm.
fn with_tide(mut session: Session, (tide_mm, period_s, phase): (f64, f64, f64)) -> Session {
    for test in &mut session.tests {
        let began = test.started_at_s;
        let recording = test.recording.as_mut().expect("recording");
        let rows = recording.length_mm.len() as f64;
        for (row, length) in recording.length_mm.iter_mut().enumerate() {
            // sweeps of half a minute: what counts is when they were
            let t = began + 30.0 * row as f64 / rows;
            *length += tide_mm * (TAU * t / period_s + phase).sin();
        }
    }
    session
}

#[test]
fn a_zero_that_wanders_with_the_tide_is_no_growth() {
    for (period_s, phase) in [(1200.0, 0.4), (2000.0, 2.0), (2400.0, 5.1), (3100.0, 3.6)] {
        let session = with_tide(recorded(gallery("04-warming-spindle"), Vec::new()), (0.2e-3, period_s, phase));
        let found = diagnose(&session, &Options::default()).expect("diagnosis");
        let causes: Vec<_> = found.findings.iter().map(|finding| (&finding.cause, &finding.size)).collect();
        assert!(found.findings.is_empty(), "{period_s} s: {causes:?}");
    }
}

#[test]
fn a_spindle_that_grows_a_little_is_told_beside_the_tide() {
    let session = gallery("04-warming-spindle");
    let z = session.machine.axis_index("Z").expect("Z");
    let grows = Effect::new("thermal-growth", Place::Axis(z)).with("tau", ParameterValue::List(vec![900.0]));
    let grows = grows.size(Outlet::Motion { axis: z, component: Component::EZ }, "growth1", 4e-3);
    let session = with_tide(recorded(session, vec![grows]), (0.2e-3, 2000.0, 2.0));
    let found = diagnose(&session, &Options::default()).expect("diagnosis");
    let causes: Vec<_> = found.findings.iter().map(|finding| (&finding.cause, &finding.size)).collect();
    assert_eq!(found.findings.first().map(|first| first.cause.effect.as_str()), Some("thermal-growth"), "{causes:?}");
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn readings_that_are_far_off_do_not_hide_under_a_vibration() {
    let mut session = noisy(SWEEPS, breathing([0.5e-3, 1.8e-3, -1.2e-3], (2.7, 0.07, 0.3)));
    let mut stray = Vec::new();
    for (test, row) in [(1, 40), (6, 77), (12, 130), (18, 11)] {
        // far less than eight times what the vibration moves from row to row
        session.tests[test].recording.as_mut().expect("recording").length_mm[row] += 12e-3;
        stray.push((test, row));
    }
    let found = diagnose(&session, &Options::default()).expect("diagnosis");
    let [finding] = &found.findings[..] else { panic!("{:?}", found.findings.len()) };
    assert_eq!((finding.cause.effect.as_str(), finding.cause.place.as_str()), ("vibration", "spindle-ball"));
    let left_out = |(test, row): &(usize, usize)| !found.tests[*test].kept[*row];
    assert!(stray.iter().all(left_out));
    assert_eq!(found.tests.iter().flat_map(|test| &test.kept).filter(|kept| !**kept).count(), stray.len());
    assert!(found.rms_after_um < 0.26, "{} for 0.25", found.rms_after_um);
}

#[test]
fn a_recording_of_one_row_spoils_nothing() {
    // a sine is zero all over it: its column is none
    let mut session = noisy(SWEEPS, breathing([1.5e-3, 1.2e-3, -1.6e-3], (1.9, 0.07, 0.3)));
    // both ways of one test: a file that is shorter than its repeats is cut short
    let stem = |name: &str| name.trim_end_matches("-ccw").trim_end_matches("-cw").to_string();
    let one = stem(&session.tests[2].name);
    for test in session.tests.iter_mut().filter(|test| stem(&test.name) == one) {
        let recording = test.recording.as_mut().expect("recording");
        if let Clock::TimeS(times) = &mut recording.clock {
            times.truncate(1);
        }
        recording.positions.iter_mut().for_each(|column| column.truncate(1));
        recording.length_mm.truncate(1);
        recording.leading_texts = std::sync::Arc::default();
    }
    let found = diagnose(&session, &Options::default()).expect("diagnosis");
    let causes: Vec<_> = found.findings.iter().map(|finding| (&finding.cause, &finding.size)).collect();
    let [finding] = &found.findings[..] else { panic!("{causes:?} {:?}", found.verdict) };
    assert!((finding.size.value / 2.5 - 1.0).abs() < 0.1, "{:?}", finding.size);
}
