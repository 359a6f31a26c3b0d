//! Parts of the diagnosis by the library: shapes judged from memory and blocks judged test by test stand as if judged anew
//! and whole; irregular motion is located.

use crate::noisy;
use fiveaxis::statistics::NoiseModel;
use std::path::Path;
use std::sync::Arc;

use fiveaxis::chain::Chain;
use fiveaxis::diagnose::{
    Accepted, CHUNK_S, Column, LastShape, LinearModel, Regression, Term, Verdict, WhitenedData, diagnose, families,
    held_out_rows, noise_floor, terms,
};
use fiveaxis::effects::Context;
use fiveaxis::identify::{self, FreePrior, Options, Problem};
use fiveaxis::load::load_session;
use fiveaxis::machine::{Component, Effect, Outlet, ParameterValue, Place};
use fiveaxis::session::{Session, Setups};
use nalgebra::DMatrix;
use noisy::{Draws, noisy};

/// Planar circles in three planes, with what `effects` and a gauge of 0.25 µm noise make of them.
fn circles(effects: Vec<Effect>) -> Session {
    noisy("06-worn-guideway", effects)
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

/// Rms of that motion over the readings of sweeps in which Y moves, beside the mean of each.
fn rms_um(session: &Session, restless: &Effect) -> f64 {
    let y = session.machine.axis_index("Y").expect("Y");
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain).expect("context");
    let at = |time_s: f64| {
        let (knot, share) = ((0.5 * time_s) as usize, 0.5 * time_s - (0.5 * time_s).floor());
        1e3 * ((1.0 - share) * restless.sizes[knot].value + share * restless.sizes[knot + 1].value)
    };
    let mut squares = Vec::new();
    for test in (0..context.tests()).filter(|test| context.motion(*test).moving.contains(&y)) {
        let motion: Vec<f64> =
            (0..context.motion(test).rows()).map(|row| at(context.session_time_s(test, row))).collect();
        let mean = motion.iter().sum::<f64>() / motion.len() as f64;
        squares.extend(motion.iter().map(|value| (value - mean).powi(2)));
    }
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn an_irregular_motion_is_located_and_has_no_form() {
    let quiet = circles(Vec::new());
    let clean = diagnose(&quiet, &Options::default()).expect("diagnosis");
    assert!(clean.findings.is_empty(), "{:?}", clean.findings.iter().map(|f| &f.cause).collect::<Vec<_>>());
    let restless = restless(&quiet);
    let expected = rms_um(&quiet, &restless);
    let found = diagnose(&circles(vec![restless]), &Options::default()).expect("diagnosis");
    let [finding] = found.findings.as_slice() else { panic!("{} findings", found.findings.len()) };
    assert_eq!(finding.cause.effect, "unknown");
    let places = std::iter::once(&finding.cause).chain(finding.rivals.iter().map(|(rival, _)| rival));
    let named: Vec<(&str, &str)> = places.map(|c| (c.place.as_str(), c.components[0].as_str())).collect();
    assert!(named.contains(&("Y", "EYY")), "{named:?}");
    // nothing but the motion along Y: the ball that Y carries is all that may stand for it
    assert!(named.iter().all(|place| [("Y", "EYY"), ("spindle-ball", "spindle-ball-y")].contains(place)), "{named:?}");
    assert!((finding.size.value / expected - 1.0).abs() < 0.15, "{} for {expected}", finding.size.value);
}

/// Works with the circles fitted and laid out for a search, and the noise of every test.
fn with_ground(work: impl FnOnce(&Session, &LinearModel, &[NoiseModel])) {
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
    let ground = LinearModel::new(&context, &problem, &values, kept);
    let noise = NoiseModel { white_mm: 2e-4, ar_mm: 1e-4, ar_rho: 0.9, drift_mm: 5e-5, offset_mm: 5e-5 };
    let noise = vec![noise; ground.tests()];
    work(&session, &ground, &noise);
}

#[test]
fn a_slow_vibration_is_no_noise() {
    with_ground(|_, ground, _| {
        // some thirty turns in every trace: correlated noise could follow them
        let mut shaken = ground.residual_mm.clone();
        let mut fold = ground.kept.clone();
        for (test, residual) in shaken.iter_mut().enumerate() {
            let time_s = ground.context.motion(test).time_s.as_ref().expect("times");
            for (row, (value, time_s)) in residual.iter_mut().zip(time_s).enumerate() {
                *value += 1.5e-3 * (std::f64::consts::TAU * 0.8 * time_s + test as f64).cos();
                fold[test][row] &= ((time_s / 5.0) as usize).is_multiple_of(2);
            }
        }
        // with all readings; those of a fold have gaps, through which a line is followed less exactly
        for (kept, most) in [(ground.kept.clone(), 1.1), (fold, 2.0)] {
            let ground = ground.with_rows(kept);
            let rms_mm = |residual_mm: &[Vec<f64>]| noise_floor(&ground, residual_mm)[0].rms_mm();
            let (quiet, shaken) = (rms_mm(&ground.residual_mm), rms_mm(&shaken));
            assert!(shaken < most * quiet && quiet < most * shaken, "{shaken} for {quiet}");
        }
    });
}

#[test]
fn what_shows_in_most_sweeps_is_no_noise() {
    with_ground(|session, ground, _| {
        // a ripple of X that is no line of the spectrum: two planes of three show it
        let x = session.machine.axis_index("X").expect("X");
        let mut loud = ground.residual_mm.clone();
        for (test, residual) in loud.iter_mut().enumerate() {
            let motion = ground.context.motion(test);
            if !motion.moving.contains(&x) {
                continue;
            }
            let time_s = motion.time_s.as_ref().expect("times");
            for ((value, time_s), x_mm) in residual.iter_mut().zip(time_s).zip(motion.axis(x)) {
                *value += 2e-3 * (std::f64::consts::TAU * x_mm / 25.0).sin() * (1.8 * time_s).sin();
            }
        }
        let rms_mm = |residual_mm: &[Vec<f64>]| noise_floor(ground, residual_mm)[0].rms_mm();
        let (quiet, loud) = (rms_mm(&ground.residual_mm), rms_mm(&loud));
        assert!(loud < 1.2 * quiet && quiet < 1.2 * loud, "{loud} for {quiet}");
    });
}

#[test]
fn a_bow_is_as_high_as_it_stands_over_its_end_points() {
    let session = circles(Vec::new());
    let x = session.machine.axis_index("X").expect("X");
    let outlet = Outlet::Motion { axis: x, component: Component::EY };
    let numbers = |values: &[f64]| ParameterValue::List(values.to_vec());
    let (square_um, cube_um) = (6.0, 4.0);
    let bow = Effect::new("straightness", Place::Axis(x))
        .with("degrees", numbers(&[2.0, 3.0]))
        .with("half_travel", ParameterValue::Number(100.0))
        .size(outlet, "degree2", 1e-3 * square_um)
        .size(outlet, "degree3", 1e-3 * cube_um);
    let found = diagnose(&circles(vec![bow]), &Options::default()).expect("diagnosis");
    let finding = &found.findings[0];
    assert_eq!((finding.cause.effect.as_str(), finding.cause.place.as_str()), ("straightness", "X"));
    // over the travel from -1 to 1 the line through the end points is square + cube u
    let over_ends = |u: f64| (square_um * (u * u - 1.0) + cube_um * (u * u * u - u)).abs();
    let height_um = (-100..=100).map(|k| over_ends(0.01 * f64::from(k))).fold(0.0, f64::max);
    let size = &finding.size;
    assert!((size.value / height_um - 1.0).abs() < 0.1, "{} ± {} for {height_um}", size.value, size.sigma);
}

#[test]
fn a_column_from_the_wrong_end_is_named_where_slides_follow_too() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/gallery/01-worm-gear/session.yaml");
    let mut session = load_session(&file).expect("session");
    let c = session.machine.axis_index("C").expect("C");
    for test in session.tests.iter_mut().filter(|test| test.name.starts_with("sync-c") && test.name.ends_with("-cw")) {
        let recording = test.recording.as_mut().expect("recording");
        let column = recording.axes.iter().position(|axis| *axis == c).expect("column of C");
        recording.positions[column].reverse();
    }
    let fault = diagnose(&session, &Options::default()).expect("diagnosis").data_fault.expect("data fault");
    assert_eq!((fault.kind.name(), fault.components.as_slice()), ("angle-reversed", ["C".to_string()].as_slice()));
    assert!(fault.tests.iter().any(|test| test == "sync-c-radial-cw"), "{:?}", fault.tests);
    assert!(fault.after_um < 0.1 * fault.before_um, "{} to {}", fault.before_um, fault.after_um);
}

#[test]
fn beginnings_and_places_of_sweeps_are_in_both_folds() {
    with_ground(|session, ground, _| {
        let folds = [0, 1].map(|fold| held_out_rows(ground, fold, CHUNK_S));
        for test in 0..ground.tests() {
            for (row, kept) in ground.kept[test].iter().enumerate() {
                assert_eq!(*kept, folds[0][test][row] ^ folds[1][test][row], "every reading is held out once");
            }
            for fold in &folds {
                let held = fold[test].iter().filter(|held| **held).count();
                assert!(3 * held > fold[test].len() / 2, "{held} of {}", fold[test].len());
            }
        }
        let find = |name: &str| session.tests.iter().position(|test| test.name == name).expect(name);
        for plane in ["xy", "yz", "zx"] {
            for feed in ["f500", "f2000"] {
                let [there, back] = ["ccw", "cw"].map(|way| &folds[0][find(&format!("{plane}-{feed}-{way}"))]);
                let last = (there.len().min(back.len()) - 1) as f64;
                // held out in one of the two at the same share of the time, and at the same place of the axes
                let opposite = |share: f64| -> f64 {
                    let at = |fold: &Vec<bool>, share: f64| fold[(share * (fold.len() - 1) as f64).round() as usize];
                    f64::from(u8::from(at(there, share) != at(back, share)))
                        .min(f64::from(u8::from(at(there, share) != at(back, 1.0 - share))))
                };
                let share = (0..=last as usize).map(|row| opposite(row as f64 / last)).sum::<f64>() / (last + 1.0);
                assert!(share > 0.95, "{plane} {feed}: {share}");
            }
        }
        let begins = |test: usize| folds[0][test][5];
        assert!((0..ground.tests()).any(begins) && !(0..ground.tests()).all(begins));
    });
}

#[test]
fn noisier_sweeps_are_no_missing_physics() {
    let mut session = circles(Vec::new());
    let mut draws = Draws(777);
    // two planes of three with another, noisier bar
    for test in session.tests.iter_mut().filter(|test| !test.name.starts_with("yz")) {
        let recording = test.recording.as_mut().expect("recording");
        recording.length_mm.iter_mut().for_each(|length| *length += 0.9e-3 * draws.normal());
    }
    let found = diagnose(&session, &Options::default()).expect("diagnosis");
    assert_eq!(found.verdict, Verdict::Clean, "{:?}", found.noise_um);
}

/// Columns of a vibration along X and Z with amplitudes of its own in every test.
fn vibration(session: &Session, ground: &LinearModel, frequency: f64) -> Vec<Column> {
    let effect = Effect::new("vibration", Place::SpindleBall)
        .with("frequency", ParameterValue::Number(frequency))
        .with("wander", ParameterValue::Number(1.0))
        .with("clock", ParameterValue::Word("test".into()));
    let plain = terms(&session.machine, &effect, &[Outlet::SpindleBall(0), Outlet::SpindleBall(2)]);
    let all = (0..ground.tests()).flat_map(|test| plain.iter().map(move |term| Term { test: Some(test), ..*term }));
    ground.columns(&effect, &all.collect::<Vec<_>>()).expect("columns")
}

fn squareness(session: &Session, ground: &LinearModel) -> Vec<Column> {
    let x = session.machine.axis_index("X").expect("X");
    let effect = Effect::new("squareness", Place::Axis(x));
    let outlet = Outlet::Location { axis: x, component: Component::EC };
    ground.columns(&effect, &terms(&session.machine, &effect, &[outlet])).expect("columns")
}

#[test]
fn columns_of_single_tests_are_fitted_in_any_order() {
    with_ground(|session, ground, noise| {
        let prior = 3.0;
        let accepted = |blocks: &[&Vec<Column>]| -> Vec<Accepted> {
            blocks.iter().flat_map(|b| b.iter()).map(|column| Accepted { column: column.clone(), prior }).collect()
        };
        let stage = |blocks: &[&Vec<Column>]| Regression::new(ground, noise, &accepted(blocks), &ground.kept);
        // what a block takes off the weighted squares beside others: zᵀ (G + 1/prior²)⁻¹ z
        let takes = |beside: &[&Vec<Column>], block: &Vec<Column>| {
            let (gram, z) = stage(beside).project(block);
            let with_prior = &gram + DMatrix::identity(gram.nrows(), gram.nrows()) / (prior * prior);
            z.dot(&with_prior.cholesky().expect("definite").solve(&z))
        };
        let (shared, one, other) =
            (squareness(session, ground), vibration(session, ground, 2.0), vibration(session, ground, 7.0));
        let whole = stage(&[&shared, &one, &other]).misfit;
        for [a, b, c] in [[&shared, &one, &other], [&one, &shared, &other], [&other, &one, &shared]] {
            let by_steps = stage(&[]).misfit - takes(&[], a) - takes(&[a], b) - takes(&[a, b], c);
            assert!((by_steps / whole - 1.0).abs() < 1e-9, "{by_steps} for {whole}");
        }
    });
}

#[test]
fn a_block_judged_test_by_test_has_the_evidence_of_the_whole() {
    with_ground(|session, ground, noise| {
        let beside = vibration(session, ground, 7.0);
        let accepted: Vec<Accepted> = squareness(session, ground)
            .into_iter()
            .chain(beside)
            .map(|column| Accepted { column, prior: 3.0 })
            .collect();
        let stage = Regression::new(ground, noise, &accepted, &ground.kept);
        let block = vibration(session, ground, 2.0);
        let judged = stage.judge(&block, 30.0);
        let (gram, z) = stage.project(&block);
        let count = gram.nrows();
        let factor = (&gram + DMatrix::identity(count, count) / judged.tau.powi(2)).cholesky().expect("definite");
        let amplitudes = factor.solve(&z);
        let square = z.dot(&amplitudes);
        let log_ratio = factor.ln_determinant() + 2.0 * count as f64 * judged.tau.ln();
        // one nat stands for the choice of the prior
        let evidence = 0.5 * (square - log_ratio) - 1.0;
        assert!((judged.log_evidence - evidence).abs() < 1e-6, "{} for {evidence}", judged.log_evidence);
        assert!((judged.chi2 / square - 1.0).abs() < 1e-9, "{} for {square}", judged.chi2);
        for (one, other) in judged.amplitudes.iter().zip(amplitudes.iter()) {
            assert!((one - other).abs() < 1e-9, "{one} for {other}");
        }
    });
}

#[test]
fn a_vibration_that_wanders_follows_legendre_polynomials_over_each_recording() {
    with_ground(|session, ground, _| {
        let effect = Effect::new("vibration", Place::SpindleBall)
            .with("frequency", ParameterValue::Number(3.0))
            .with("wander", ParameterValue::Number(3.0))
            .with("clock", ParameterValue::Word("test".into()));
        let profiles = ground.profiles(&effect).expect("profiles");
        assert_eq!(profiles.len(), 8);
        for test in 0..ground.tests() {
            let time = ground.context.motion(test).time_s.as_ref().expect("times");
            let (first, last) = (time[0], time[time.len() - 1]);
            for (row, t) in time.iter().enumerate() {
                let u = 2.0 * (t - first) / (last - first) - 1.0;
                let wave = (std::f64::consts::TAU * 3.0 * (t - first)).cos();
                let legendre = [1.0, u, 0.5 * (3.0 * u * u - 1.0), 0.5 * (5.0 * u.powi(3) - 3.0 * u)];
                for (degree, expected) in legendre.iter().enumerate() {
                    let found = profiles[2 * degree][test][row];
                    let name = &session.tests[test].name;
                    assert!((found - wave * expected).abs() < 1e-9, "{name} row {row} degree {degree}: {found}");
                }
            }
        }
    });
}

#[test]
fn shapes_judged_from_memory_stand_as_judged_anew() {
    with_ground(judged_from_memory);
}

fn judged_from_memory(session: &Session, ground: &LinearModel, noise: &[NoiseModel]) {
    judged_from_memory_of(session, ground, noise, ground.kept.clone());
    // in a fold half of the rows are left
    let every_second = |kept: &Vec<bool>| kept.iter().enumerate().map(|(row, kept)| *kept && row % 2 == 0).collect();
    judged_from_memory_of(session, ground, noise, ground.kept.iter().map(every_second).collect());
}

fn judged_from_memory_of(session: &Session, ground: &LinearModel, noise: &[NoiseModel], kept: Vec<Vec<bool>>) {
    let families = families(ground);
    let accepted: Vec<Accepted> =
        squareness(session, ground).into_iter().map(|column| Accepted { column, prior: 10.0 }).collect();
    assert!(!accepted.is_empty());
    // the first stage fills the memory, the others take from it: beside another model, and under half the noise, also of every
    // second test alone
    let whitened = Arc::new(WhitenedData::new(ground, noise, &kept));
    let groups: Vec<usize> = (0..noise.len()).map(|test| test % 2).collect();
    let grouped = Arc::new(WhitenedData::new(ground, noise, &kept).grouped(groups.clone()));
    let quieter: Vec<NoiseModel> = noise.iter().map(|noise| noise.scaled(0.5)).collect();
    let of_group = |(noise, &group): (&NoiseModel, &usize)| noise.scaled(if group == 0 { 1.0 } else { 0.5 });
    let partly_quieter: Vec<NoiseModel> = noise.iter().zip(&groups).map(of_group).collect();
    let stages = [
        Regression::on(whitened.clone(), &[]),
        Regression::on(whitened.clone(), &accepted),
        Regression::weighted(whitened, vec![4.0], &accepted),
        Regression::weighted(grouped, vec![1.0, 4.0], &accepted),
    ];
    let anew = [
        Regression::new(ground, noise, &[], &kept),
        Regression::new(ground, noise, &accepted, &kept),
        Regression::new(ground, &quieter, &accepted, &kept),
        Regression::new(ground, &partly_quieter, &accepted, &kept),
    ];
    let mut judged = 0;
    for (index, family) in families.iter().enumerate().filter(|(_, family)| family.by_test.is_empty()) {
        let effect = &family.grid[family.grid.len() / 2];
        let terms = terms(&session.machine, effect, &family.outlets);
        let Ok(profiles) = ground.profiles(effect) else { continue };
        let columns = ground.columns(effect, &terms).expect("columns");
        for (stage, anew) in stages.iter().zip(&anew) {
            let mut last = LastShape::default();
            // a shape with its first column alone was judged before: what is known of that column is taken over
            let other = families.len() + index;
            stage.judge_shape((other, effect), (&profiles, &terms[..1]), family.plausible, &mut last);
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
