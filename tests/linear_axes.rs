//! Linear axes that err within their budget: the truth lies within the stated sigmas, and the budget acts where it should.

use crate::erring;
use crate::planned;
use crate::recorded;
use erring::{Form, coverage, overall, table, table_head, table_table, with_errors};
use fiveaxis::chain::Composition;
use fiveaxis::diagnose::diagnose;
use fiveaxis::identify::{Fit, Options, identify, parse_free};
use fiveaxis::machine::{LinearAxes, LinearClass};
use fiveaxis::session::{Session, Spread, Test};
use fiveaxis::simulate::{Instrument, SetupErrors, simulate_with};
use planned::planned;
use recorded::recorded;

/// Sessions of each design.
const SESSIONS: u64 = 500;
/// Share of a normal distribution within two standard deviations, and three standard deviations of that share of 500.
const SHARE: f64 = 0.9545;
const SCATTER: f64 = 0.028;

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn the_truth_lies_within_two_sigmas_when_linear_axes_err() {
    for (design, session) in [("table-table", table_table(24)), ("table-head", table_head(24))] {
        let list = coverage(&session, Form::Waves, 0..SESSIONS);
        println!("{design}, seeds 0 to {}\n{}", SESSIONS - 1, table(&list));
        let all = overall(&list);
        assert!((0.93..=0.97).contains(&all), "{design}: {:.1} % of all", 100.0 * all);
        for error in list.iter().filter(|error| error.determined) {
            let off = error.within - SHARE;
            assert!(off.abs() < SCATTER, "{design} {}: {:.1} %", error.name, 100.0 * error.within);
        }
        // the test can fail: sigmas of exact linear axes do not hold
        assert!(list.iter().any(|error| error.determined && error.within_if_exact < 0.5), "{design}");
    }
}

/// A fit of one simulated run.
fn fitted(planned: &Session, form: Form, free: &str, seed: u64) -> Fit {
    let truth = with_errors(planned, form, seed);
    let traces = simulate_with(&truth, Composition::Exact, &SetupErrors::drawn(&truth, seed)).unwrap();
    let traces = Instrument::default().read(&truth, traces, seed).unwrap();
    let free = Some(parse_free(free, &planned.machine).unwrap());
    identify(&recorded(planned, &traces), &Options { free, ..Options::default() })
        .unwrap_or_else(|why| panic!("{free_words} seed {seed}: {why}", free_words = planned.name))
}

fn with_budget(planned: &Session, budget: LinearAxes) -> Session {
    let mut session = planned.clone();
    session.machine.linear_axes = budget;
    session
}

#[test]
fn worse_classes_state_larger_sigmas_and_the_same_noise() {
    // from 24 readings a sweep two models of the noise are as likely as each other
    let planned = table_table(60);
    let fits: Vec<Fit> = LinearClass::ALL
        .iter()
        .map(|&class| fitted(&with_budget(&planned, LinearAxes::of(class)), Form::Exact, "rotary", 1))
        .collect();
    let exact = fitted(&with_budget(&planned, LinearAxes::EXACT), Form::Exact, "rotary", 1);
    for (k, unknown) in exact.unknowns.iter().enumerate().filter(|(_, unknown)| !unknown.quantity.is_setup()) {
        // each over its own noise: readings are left out and weighted anew in every fit
        let grown: Vec<f64> = fits.iter().map(|fit| fit.estimates[k].sigma / fit.estimates[k].sigma_noise).collect();
        assert!(grown.windows(2).all(|pair| pair[0] <= pair[1] * (1.0 + 1e-6)), "{}: {grown:?}", unknown.label);
        let of = &exact.estimates[k];
        assert!((of.sigma_to_spindle_ball / of.sigma_noise - 1.0).abs() < 1e-9, "{}", unknown.label);
        for fit in &fits {
            assert_eq!(fit.estimates[k].determined, of.determined, "{}", unknown.label);
            assert!((fit.estimates[k].sigma_noise / of.sigma_noise - 1.0).abs() < 0.01, "{}", unknown.label);
            assert!(fit.estimates[k].sigma_noise <= fit.estimates[k].sigma_to_spindle_ball * (1.0 + 1e-9));
        }
    }
    // what the C turn with the short bar alone says of the tilt of C is as uncertain as the squareness of Z beside it
    let tilt = exact.unknowns.iter().position(|unknown| unknown.label == "EA0C").unwrap();
    for (class, fit) in LinearClass::ALL.iter().zip(&fits) {
        assert!(fit.estimates[tilt].sigma >= LinearAxes::of(*class).squareness_rad, "{class:?}");
    }
}

#[test]
fn linear_axes_that_stay_at_zero_or_at_one_place_add_what_they_should() {
    let mut at_zero = table_table(24);
    at_zero.tests.retain(|test| test.name.contains("short"));
    let fit = fitted(&at_zero, Form::Waves, "rotary", 2);
    for (unknown, estimate) in fit.unknowns.iter().zip(&fit.estimates) {
        // at their zeros linear axes err by nothing
        let ratio = estimate.sigma_to_spindle_ball / estimate.sigma_noise;
        assert!((ratio - 1.0).abs() < 1e-9, "{}: {ratio}", unknown.label);
    }
    // far from zero all tests share one misplacement: balls move with it, and nothing blows up
    let mut at_one_place = at_zero.clone();
    for test in &mut at_one_place.tests {
        let x = at_one_place.machine.axis_index("X").unwrap();
        test.positions[x] = Some(200.0);
        test.spindle_ball.at.x -= 200.0;
    }
    let fit = fitted(&at_one_place, Form::Waves, "rotary", 2);
    for (unknown, estimate) in fit.unknowns.iter().zip(&fit.estimates) {
        let measure = unknown.measure.to_output(estimate.sigma_to_spindle_ball);
        assert!(estimate.sigma.is_finite() && measure >= 0.0, "{}", unknown.label);
    }
    let moved = fit.unknowns.iter().position(|unknown| unknown.label == "EX0C").unwrap();
    let (with, without) = (fit.estimates[moved].sigma_to_spindle_ball, fit.estimates[moved].sigma_noise);
    // 5 µm/m on 200 mm
    assert!(((with * with - without * without).sqrt() * 1e3 - 1.0).abs() < 0.02, "{with} and {without}");
}

#[test]
fn squareness_without_circles_converges_and_names_the_circle() {
    let planned = table_head(60);
    for seed in 0..20 {
        let fit = fitted(&planned, Form::Waves, "rotary,squareness", seed);
        let open: Vec<&str> = fit
            .unknowns
            .iter()
            .zip(&fit.estimates)
            .filter(|(unknown, estimate)| !unknown.quantity.is_setup() && !estimate.determined)
            .map(|(unknown, _)| unknown.label.as_str())
            .collect();
        let square: Vec<&str> = ["EC0Y", "EB0Z", "EA0Z"].into_iter().filter(|name| open.contains(name)).collect();
        assert!(!square.is_empty(), "seed {seed}: {open:?}");
        let says: Vec<String> = fit.ambiguities.iter().map(|ambiguity| ambiguity.says()).collect();
        for name in square {
            let mine: Vec<&String> = says.iter().filter(|says| says.contains(name)).collect();
            assert!(mine.iter().any(|says| says.contains("a circle of")), "seed {seed} {name}: {says:?}");
        }
    }
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn what_linear_axes_of_their_class_leave_is_no_finding_at_a_rotary_axis() {
    // slides that follow two joints of a head over half their travel: in the plan's tests they look like error motion of C
    let (machine, tests) = planned("fig-1-1-head-head-cb.yaml");
    let mut started_at_s = 0.0;
    let mut both_ways: Vec<Test> = Vec::new();
    for planned in &tests {
        for test in planned.both_ways() {
            both_ways.push(Test { started_at_s, ..test });
            started_at_s += (planned.minutes * 30.0).ceil();
        }
    }
    let is_rotary: Vec<String> = ["C", "B"].map(String::from).to_vec();
    let session = Session {
        name: "plan".into(),
        machine_file: String::new(),
        machine,
        spread: Spread::default(),
        tests: both_ways,
    };
    let mut left_to_them = 0;
    for seed in 0..SEEDS {
        let truth = with_errors(&session, Form::Waves, seed);
        let traces = simulate_with(&truth, Composition::Exact, &SetupErrors::drawn(&truth, seed)).unwrap();
        let traces = Instrument::default().read(&truth, traces, seed).unwrap();
        let diagnosis = diagnose(&recorded(&session, &traces), &Options::default()).unwrap();
        for finding in &diagnosis.findings {
            let claimed = is_rotary.contains(&finding.cause.place) && finding.probability > 0.5;
            assert!(!claimed, "seed {seed}: {:?} {}", finding.cause, finding.probability);
        }
        left_to_them +=
            usize::from(diagnosis.warnings.iter().any(|warning| warning.contains("linear axes of their class")));
    }
    assert!(left_to_them > 0, "none of {SEEDS} looks like another cause");
}

/// Sessions of a plan that are diagnosed.
const SEEDS: u64 = 4;
