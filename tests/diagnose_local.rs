//! Errors about one position of an axis and deflection by acceleration, concealed by a simulator of other code and forms or by the
//! library's own; and what few rows and the order of tests must not change.

use crate::examples::blind_trial::{case, recordings};
use crate::noisy::{gallery, noisy};
use fiveaxis::diagnose::{Diagnosis, Verdict, diagnose};
use fiveaxis::identify::Options;
use fiveaxis::load::load_session;
use fiveaxis::machine::{Effect, Outlet, Place};
use fiveaxis::session::{Clock, Session};
use fiveaxis::units::ARCSEC_PER_RAD;

fn diagnosed(session: &Session) -> Diagnosis {
    diagnose(session, &Options::default()).expect("diagnosis")
}

/// The first cause that is told, with its place, and the others for a failure's message.
fn first(found: &Diagnosis) -> (&str, &str) {
    let cause = |k: usize| found.findings.get(k).map(|finding| &finding.cause);
    println!("{:?} {:?}", cause(0), cause(1));
    cause(0).map_or(("nothing", ""), |cause| (cause.effect.as_str(), cause.place.as_str()))
}

/// A session of the blind trial with one effect, and where it acts.
fn concealed(effect: &str, number: u64) -> (Session, String) {
    let wishes = case::Wishes { effect: Some(effect.into()), ..case::Wishes::default() };
    let case = case::make(616_263, number - 1, &wishes);
    let folder = tempfile::tempdir().expect("folder");
    recordings::write(folder.path(), &case.name, &case.plan, &case.order, &case.recordings).expect("session");
    let session = load_session(&folder.path().join("session.yaml")).expect("loads");
    (session, case.truth["effects"][0]["place"].as_str().expect("place").to_string())
}

#[test]
fn dirt_on_a_scale_and_a_leaning_column_of_another_simulator_are_found() {
    // bells with two flanks, where the catalogue has raised cosines
    for (effect, number) in [
        ("local-positioning-error", 3),
        ("local-positioning-error", 4),
        ("local-positioning-error", 7),
        ("inertia-deflection", 4),
    ] {
        let (session, place) = concealed(effect, number);
        assert_eq!(first(&diagnosed(&session)), (effect, place.as_str()), "session {number}");
    }
}

#[test]
fn an_angle_that_is_off_at_one_place_is_no_worn_guideway() {
    let machine = gallery("01-worm-gear").machine;
    let c = machine.axis_index("C").expect("C");
    let own = Outlet::own(&machine, c);
    let dirt = Effect::new("local-positioning-error", Place::Axis(c));
    let number = |value: f64| fiveaxis::machine::ParameterValue::Number(value);
    let dirt = dirt.with("centre", number(2.4)).with("width", number(0.5)).size(own, "bump", 20.0 / ARCSEC_PER_RAD);
    let found = diagnosed(&noisy("01-worm-gear", vec![dirt]));
    assert_eq!(first(&found), ("local-positioning-error", "C"));
    let size = &found.findings[0].size;
    assert!((size.value - 20.0).abs() < 3.0 * size.sigma && size.sigma < 4.0, "{size:?}");
}

/// Every `step`-th row of all recordings from a first one on.
fn thinned(mut session: Session, step: usize, from: usize) -> Session {
    fn pick(column: &mut Vec<f64>, step: usize, from: usize) {
        *column = column.iter().copied().skip(from).step_by(step).collect();
    }
    for recording in session.tests.iter_mut().filter_map(|test| test.recording.as_mut()) {
        recording.positions.iter_mut().for_each(|column| pick(column, step, from));
        pick(&mut recording.length_mm, step, from);
        if let Clock::TimeS(time) = &mut recording.clock {
            pick(time, step, from);
        }
    }
    session
}

#[test]
fn recordings_of_eight_rows_were_not_processed() {
    let found = diagnosed(&thinned(gallery("07-nothing-wrong"), 18, 2));
    assert_ne!(found.verdict, Verdict::DataFault, "{:?}", found.data_fault);
}

#[test]
fn what_is_proposed_next_goes_by_time_and_not_by_the_file() {
    let session = gallery("04-warming-spindle");
    let mut turned = session.clone();
    turned.tests.reverse();
    let proposed = |session: &Session| {
        let found = diagnosed(session);
        let next: Vec<String> = found
            .findings
            .iter()
            .filter_map(|finding| finding.next_test.as_ref())
            .map(|next| next.says.clone())
            .collect();
        (next, found.uncovered_by.iter().map(|test| test.says.clone()).collect::<Vec<_>>())
    };
    let (one, other) = (proposed(&session), proposed(&turned));
    assert!(!one.1.is_empty());
    assert_eq!(one, other);
}
