//! Parts of the diagnosis by the library: shapes judged from memory stand as if judged anew; irregular motion is located.

use std::path::Path;
use std::sync::Arc;

use fiveaxis::chain::{Chain, Composition};
use fiveaxis::diagnose::{Accepted, Ground, LastShape, Stage, Whitened, diagnose, families, terms};
use fiveaxis::effects::Context;
use fiveaxis::identify::{self, FreePrior, NoiseModel, Options, Problem};
use fiveaxis::load::load_session;
use fiveaxis::machine::{Component, Effect, Outlet, ParameterValue, Place};
use fiveaxis::session::{Session, Setups};
use fiveaxis::simulate::simulate;

/// Numbers that look random and are the same everywhere (Lehmer's generator).
struct Draws(u64);

impl Draws {
    fn normal(&mut self) -> f64 {
        let mut even = || {
            self.0 = self.0 * 48_271 % 2_147_483_647;
            self.0 as f64 / 2_147_483_647.0
        };
        (0..12).map(|_| even()).sum::<f64>() - 6.0
    }
}

/// Planar circles in three planes, with what `effects` and a gauge of 0.25 µm noise make of them.
fn circles(effects: Vec<Effect>) -> Session {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/gallery/06-worn-guideway/session.yaml");
    let mut session = load_session(&file).expect("session");
    session.machine.effects = effects;
    let traces = simulate(&session, Composition::Exact).expect("lengths");
    let mut draws = Draws(20_241);
    for (test, trace) in session.tests.iter_mut().zip(traces) {
        let recording = test.recording.as_mut().expect("recording");
        recording.length_mm = trace.length_mm.iter().map(|length| length + 0.25e-3 * draws.normal()).collect();
    }
    session.machine.effects.clear();
    session
}

/// Y strays by 1.5 µm this way or that, anew every two seconds of the session.
fn restless(session: &Session) -> Effect {
    let y = session.machine.axis_index("Y").expect("Y");
    let outlet = Outlet::Motion { axis: y, component: Component::EY };
    let mut draws = Draws(7);
    let last_s = session.tests.iter().map(|test| test.started_at_s).fold(0.0, f64::max) + 120.0;
    let knots: Vec<f64> = (0..(last_s / 2.0) as usize).map(|k| 2.0 * k as f64).collect();
    let mut effect = Effect::new("table", Place::Axis(y))
        .with("driver", ParameterValue::Word("time".into()))
        .with("knots", ParameterValue::List(knots.clone()));
    for k in 1..=knots.len() {
        effect = effect.size(outlet, &format!("k{k}"), 1.5e-3 * draws.normal());
    }
    effect
}

#[test]
fn an_irregular_motion_is_located_and_has_no_form() {
    let quiet = circles(Vec::new());
    let clean = diagnose(&quiet, &Options::default()).expect("diagnosis");
    assert!(clean.findings.is_empty(), "{:?}", clean.findings.iter().map(|f| &f.cause).collect::<Vec<_>>());
    let found = diagnose(&circles(vec![restless(&quiet)]), &Options::default()).expect("diagnosis");
    let [finding] = found.findings.as_slice() else { panic!("{} findings", found.findings.len()) };
    assert_eq!(finding.cause.effect, "unknown");
    let places = std::iter::once(&finding.cause).chain(finding.rivals.iter().map(|(rival, _)| rival));
    let named: Vec<(&str, &str)> = places.map(|c| (c.place.as_str(), c.components[0].as_str())).collect();
    assert!(named.contains(&("Y", "EYY")), "{named:?}");
    // nothing but the motion along Y: the ball that Y carries is all that may stand for it
    assert!(named.iter().all(|place| [("Y", "EYY"), ("spindle-ball", "spindle-ball-y")].contains(place)), "{named:?}");
    // straight lines between the knots hold two thirds of their square
    let expected = 1.5 * (2.0f64 / 3.0).sqrt();
    assert!((finding.size.value / expected - 1.0).abs() < 0.15, "{} for {expected}", finding.size.value);
}

#[test]
fn shapes_judged_from_memory_stand_as_judged_anew() {
    let session = circles(Vec::new());
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(&session);
    let free = identify::default_free(&session.machine);
    let unknowns = identify::unknowns(&session, &setups, &free, FreePrior::of(&session.machine));
    let problem = Problem::new(&session, &chain, &setups, unknowns).expect("problem");
    let fit = identify::fit(&problem).expect("fit");
    let values: Vec<f64> = fit.estimates.iter().map(|estimate| estimate.value).collect();
    let kept: Vec<Vec<bool>> = fit.tests.iter().map(|test| test.kept.clone()).collect();
    let context = Context::of(&session, &chain).expect("context");
    let ground = Ground::new(&context, &problem, &values, kept.clone());
    let noise = NoiseModel { white_mm: 2e-4, ar_mm: 1e-4, ar_rho: 0.9, drift_mm: 5e-5, offset_mm: 5e-5 };
    let noise = vec![noise; ground.tests()];
    let families = families(&ground);
    let x = session.machine.axis_index("X").expect("X");
    let squareness = Effect::new("squareness", Place::Axis(x));
    let outlet = Outlet::Location { axis: x, component: Component::EC };
    let accepted: Vec<Accepted> = ground
        .columns(&squareness, &terms(&session.machine, &squareness, &[outlet]))
        .expect("columns")
        .into_iter()
        .map(|column| Accepted { column, prior: 10.0 })
        .collect();
    assert!(!accepted.is_empty());
    // the first stage fills the memory, the second one takes from it beside another model
    let whitened = Arc::new(Whitened::new(&ground, &noise, &kept));
    let stages = [Stage::on(whitened.clone(), &[]), Stage::on(whitened, &accepted)];
    let anew = [Stage::new(&ground, &noise, &[], &kept), Stage::new(&ground, &noise, &accepted, &kept)];
    let mut judged = 0;
    for (index, family) in families.iter().enumerate().filter(|(_, family)| !family.by_test) {
        let effect = &family.grid[family.grid.len() / 2];
        let terms = terms(&session.machine, effect, &family.outlets);
        let Ok(profiles) = ground.profiles(effect) else { continue };
        let columns = ground.columns(effect, &terms).expect("columns");
        for (stage, anew) in stages.iter().zip(&anew) {
            let mut last = LastShape::default();
            let remembered = stage.judge_shape((index, effect), (&profiles, &terms), family.plausible, &mut last);
            let expected = anew.judge(&columns, family.plausible);
            let allowed = 1e-6 * (1.0 + expected.chi2.abs());
            assert!(
                (remembered.log_evidence - expected.log_evidence).abs() < allowed,
                "{}: {} for {}",
                family.kind,
                remembered.log_evidence,
                expected.log_evidence
            );
            judged += 1;
        }
    }
    assert!(judged > 100, "{judged}");
}
