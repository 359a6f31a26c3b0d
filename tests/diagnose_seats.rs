//! What sits badly or comes and goes: parts that lift over a stretch of their travel, ripples that beat with time, balls out of
//! round and cups that stick; and the size of spikes that several shapes tell together.

use crate::noisy;
use fiveaxis::chain::Composition;
use fiveaxis::diagnose::{Finding, diagnose};
use fiveaxis::identify::Options;
use fiveaxis::machine::{Component, Effect, Outlet, ParameterValue, Place};
use fiveaxis::session::Session;
use fiveaxis::simulate::simulate;
use noisy::{gallery, noisy, recorded};

/// Sweeps of one rotary axis at a time, and circles in planes.
const BIDIRECTIONAL: &str = "05-table-bearing";
const PLANAR: &str = "03-lost-motion";

fn number(value: f64) -> ParameterValue {
    ParameterValue::Number(value)
}

fn the_one(session: &Session) -> Finding {
    let findings = diagnose(session, &Options::default()).expect("diagnosis").findings;
    let causes: Vec<_> = findings.iter().map(|finding| (&finding.cause, &finding.size)).collect();
    assert_eq!(findings.len(), 1, "{causes:?}");
    findings.into_iter().next().expect("finding")
}

/// Checks what a finding is called, where it is and how large; the size in its own unit.
fn tells(finding: &Finding, effect: &str, place: &str, size: f64) {
    assert_eq!((finding.cause.effect.as_str(), finding.cause.place.as_str()), (effect, place), "{:?}", finding.rivals);
    let told = &finding.size;
    assert!((told.value - size).abs() < 3.0 * told.sigma, "{} ± {} for {size}", told.value, told.sigma);
    assert!(told.sigma < 0.25 * size, "{} ± {} for {size}", told.value, told.sigma);
}

#[test]
fn a_ripple_that_beats_with_time_is_found_by_its_period_and_its_beat() {
    let x = gallery(PLANAR).machine.axis_index("X").expect("X");
    let own = Outlet::Motion { axis: x, component: Component::EX };
    // sin(2π X / 37 mm) sin(2π 0.083 Hz t) of 1.6 µm: half the sum of two waves
    let beat = Effect::new("beat", Place::Axis(x)).with("period", number(37.0)).with("frequency", number(0.083));
    let beat = beat.size(own, "cos-", 0.8e-3).size(own, "cos+", -0.8e-3);
    let finding = the_one(&noisy(PLANAR, vec![beat]));
    tells(&finding, "beat", "X", 1.6);
    let found = &finding.effects[0];
    let near = |name: &str, value: f64| (found.number(name).expect("number") / value - 1.0).abs() < 5e-3;
    assert!(near("period", 37.0) && near("frequency", 0.083), "{:?}", found.parameters);
}

#[test]
fn a_ball_out_of_round_is_told_or_named_beside_what_the_machine_could_do() {
    let form = Effect::new("ball-form", Place::SpindleBall).with("degree", number(3.0));
    let form = form.size(Outlet::Reading, "y3+3", 0.4e-3).size(Outlet::Reading, "y2-2", 0.2e-3);
    let finding = the_one(&noisy(PLANAR, vec![form]));
    let mut causes = std::iter::once(&finding.cause).chain(finding.rivals.iter().map(|(rival, _)| rival));
    assert!(causes.any(|cause| cause.effect == "ball-form"), "{:?} {:?}", finding.cause, finding.rivals);
}

#[test]
fn a_pair_of_machine_errors_is_no_ball_out_of_round() {
    let axis = |name: &str| gallery(PLANAR).machine.axis_index(name).expect("axis");
    let square = |name: &str, component, arcsec: f64| {
        let outlet = Outlet::Location { axis: axis(name), component };
        let radians = arcsec / fiveaxis::units::ARCSEC_PER_RAD;
        Effect::new("squareness", Place::Axis(axis(name))).size(outlet, "", radians)
    };
    let bow = |name: &str, component| {
        let outlet = Outlet::Motion { axis: axis(name), component };
        let bow = Effect::new("straightness", Place::Axis(axis(name)));
        let bow = bow.with("degrees", ParameterValue::List(vec![2.0])).with("half_travel", number(100.0));
        bow.size(outlet, "degree2", 3e-3)
    };
    // circles of one bar: a ball of any form could make them as well
    for (pair, causes) in [
        (vec![square("Y", Component::EC, 3.0), square("Z", Component::EA, -3.0)], "squareness"),
        (vec![bow("X", Component::EY), bow("Y", Component::EX)], "straightness"),
    ] {
        let findings = diagnose(&noisy(PLANAR, pair), &Options::default()).expect("diagnosis").findings;
        let told: Vec<&str> = findings.iter().map(|finding| finding.cause.effect.as_str()).collect();
        assert!(!told.is_empty() && told.iter().all(|effect| *effect == causes), "{told:?} for {causes}");
    }
}

#[test]
fn a_cup_that_sticks_as_runs_begin_is_found() {
    let sticks = Effect::new("cup-stiction", Place::Pivot).with("turned", number(7.0));
    let finding = the_one(&noisy(PLANAR, vec![sticks.size(Outlet::Reading, "", 1.5e-3)]));
    tells(&finding, "cup-stiction", "pivot", 1.5);
}

#[test]
fn a_clamp_is_told_by_where_it_lifts_wherever_that_is() {
    let c = gallery(BIDIRECTIONAL).machine.axis_index("C").expect("C");
    let deg = |value: f64| number(f64::to_radians(value));
    // neither edge is near a place of a coarse grid, and the stretch is no multiple of its step
    for (from, to) in [(-9.4, 102.0), (-163.0, -41.0), (71.0, 88.0)] {
        let lift = Effect::new("clamp-lift", Place::Axis(c)).with("from", deg(from)).with("to", deg(to));
        let lift = lift.with("hysteresis", deg(6.0)).with("rise", number(0.7));
        let of = |component| Outlet::Motion { axis: c, component };
        let lift = lift.size(of(Component::EZ), "", 5e-3).size(of(Component::EA), "", 3e-5);
        let finding = the_one(&noisy(BIDIRECTIONAL, vec![lift]));
        tells(&finding, "clamp-lift", "C", 5.0);
        let range = finding.range.expect("range");
        assert!((range.from - from).abs() < 2.0 && (range.to - to).abs() < 2.0, "{range:?} for {from} to {to}");
    }
}

#[test]
fn spikes_told_in_several_shapes_are_as_large_as_their_sum() {
    let session = gallery(PLANAR);
    let y = session.machine.axis_index("Y").expect("Y");
    let spike = |hz: f64, damping: f64, travel: f64, size_um: f64| {
        let spike = Effect::new("reversal-spike", Place::Axis(y)).with("servo_hz", number(hz));
        let spike = spike.with("damping", number(damping)).with("travel", number(travel));
        spike.size(Outlet::Motion { axis: y, component: Component::EY }, "", 1e-3 * size_um)
    };
    let spikes = vec![spike(4.9, 0.98, 0.02, 41.0), spike(8.4, 0.7, 0.05, -15.0), spike(1.5, 0.35, 0.3, -9.0)];
    // the bar lies along Y as Y turns round: its reading shows the whole spike
    let lengths = |effects: &[Effect]| {
        let mut session = session.clone();
        session.machine.effects = effects.to_vec();
        simulate(&session, Composition::Exact).expect("lengths")
    };
    let (with, without) = (lengths(&spikes), lengths(&[]));
    let change = with.iter().zip(&without).flat_map(|(one, other)| one.length_mm.iter().zip(&other.length_mm));
    let largest_um = change.map(|(one, other)| 1e3 * (one - other).abs()).fold(0.0, f64::max);
    assert!(largest_um < 35.0, "{largest_um}");
    let findings = diagnose(&recorded(session.clone(), spikes), &Options::default()).expect("diagnosis").findings;
    tells(&findings[0], "reversal-spike", "Y", largest_um);
    assert!((findings[0].size.value / largest_um - 1.0).abs() < 0.1, "{} for {largest_um}", findings[0].size.value);
}
