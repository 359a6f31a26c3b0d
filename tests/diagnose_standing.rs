//! What slides do that only stand in the tests: errors of their position and reversals on their way between tests; and the
//! largest of an error motion over a turn.

mod noisy;

use fiveaxis::diagnose::{Finding, diagnose};
use fiveaxis::identify::Options;
use fiveaxis::machine::{Component, Effect, Outlet, ParameterValue, Place};
use noisy::noisy;

/// Sweeps of one rotary axis at a time, the slides at other places from test to test.
const BIDIRECTIONAL: &str = "07-nothing-wrong";

fn axis(name: &str) -> usize {
    noisy(BIDIRECTIONAL, Vec::new()).machine.axis_index(name).expect("axis")
}

fn found(effect: Effect) -> Vec<Finding> {
    diagnose(&noisy(BIDIRECTIONAL, vec![effect]), &Options::default()).expect("diagnosis").findings
}

/// Whether a finding names a cause, first or among those that it cannot be told from.
fn names(finding: &Finding, effect: &str, place: &str) -> bool {
    let mut causes = std::iter::once(&finding.cause).chain(finding.rivals.iter().map(|(rival, _)| rival));
    causes.any(|cause| cause.effect == effect && cause.place == place)
}

#[test]
fn the_scale_of_a_slide_that_only_stands_is_found() {
    let x = axis("X");
    let scale = Effect::new("linear-scale", Place::Axis(x)).size(
        Outlet::Motion { axis: x, component: Component::EX },
        "",
        60e-6,
    );
    let findings = found(scale);
    let [finding] = findings.as_slice() else { panic!("{} findings", findings.len()) };
    assert!(names(finding, "linear-scale", "X"), "{:?} {:?}", finding.cause, finding.rivals);
    if finding.cause.effect == "linear-scale" {
        let size = &finding.size;
        assert!((size.value - 60.0).abs() < 3.0 * size.sigma, "{} ± {}", size.value, size.sigma);
    }
}

#[test]
fn a_joint_may_tip_with_a_slide_that_moves_between_tests_alone() {
    let a = axis("A");
    let tip = Effect::new("lateral-play", Place::Axis(a))
        .with("of", ParameterValue::Word("X".into()))
        .with("gap", ParameterValue::Number(0.01))
        .size(Outlet::Motion { axis: a, component: Component::EC }, "", 10.0 / fiveaxis::units::ARCSEC_PER_RAD);
    let findings = found(tip);
    assert!(!findings.is_empty());
    assert!(names(&findings[0], "lateral-play", "A"), "{:?} {:?}", findings[0].cause, findings[0].rivals);
}

#[test]
fn an_error_motion_is_as_large_as_its_largest_component_over_a_turn() {
    let c = axis("C");
    let (two_um, five_um) = (3.0, 1.5);
    let outlet = Outlet::Motion { axis: c, component: Component::EX };
    let wobble = Effect::new("rotary-error-motion", Place::Axis(c))
        .with("orders", ParameterValue::List(vec![2.0, 5.0]))
        .size(outlet, "cos2", 1e-3 * two_um)
        .size(outlet, "sin5", 1e-3 * five_um);
    let findings = found(wobble);
    let finding = &findings[0];
    assert_eq!((finding.cause.effect.as_str(), finding.cause.place.as_str()), ("rotary-error-motion", "C"));
    let over_a_turn = (0..720).map(|k| f64::from(k).to_radians() / 2.0);
    let largest_um =
        over_a_turn.map(|q| two_um * (2.0 * q).cos() + five_um * (5.0 * q).sin()).fold(0.0, |a: f64, b| a.max(b.abs()));
    let size = &finding.size;
    assert!((size.value - largest_um).abs() < 2.0 * size.sigma, "{} ± {} for {largest_um}", size.value, size.sigma);
    assert!(size.sigma < 0.3 * largest_um, "± {}", size.sigma);
}
