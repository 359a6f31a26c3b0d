//! `reconcile` on recordings: three designs played with one planted cause, reduced by the thesis's estimators, then compared.
//!
//! Kinematics, noise, slides, bar and causes are those of `examples/thesis_sessions`, which uses nothing of the library. All three
//! methods see one machine with chapter 4's errors; ball, slides and bar are drawn within the limits of the budget.

use crate::examples::thesis_sessions::{besides, design, session};
use std::path::Path;

use besides::{Besides, Physics};
use design::{Axis, Design, Mounting, designs};
use fiveaxis::load::load_claim;
use fiveaxis::methods::{chapter4, chapter5, chapter6};
use fiveaxis::reconcile::{Cause, Kind, Limits, Prepared};
use fiveaxis::session::{Claim, ClaimedValue, Reduction, Session};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Draws of each kind; `FIVEAXIS_RECONCILE_DRAWS` sets another number, 200 for the figures of docs/thesis.md.
fn draws() -> usize {
    std::env::var("FIVEAXIS_RECONCILE_DRAWS").ok().and_then(|text| text.parse().ok()).unwrap_or(4)
}

/// The published results, whose sessions are the designs.
fn claims() -> Vec<Claim> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis/published");
    [4, 5, 6].map(|chapter| load_claim(&root.join(format!("chapter{chapter}.yaml"))).unwrap()).into()
}

/// One machine in all designs.
fn errors() -> [f64; 8] {
    designs()[0].errors
}

/// Ball, slides and bar of one method, anywhere within the limits of the budget.
fn within_the_limits(design: &Design, limits: &Limits, random: &mut ChaCha8Rng) -> Besides {
    let mut any = |limit: f64| random.random_range(-limit..limit);
    let mut besides = Besides { ball_um: Some([(); 3].map(|()| any(limits.ball_um))), ..Besides::default() };
    for test in design.mountings.iter().flat_map(|mounting| &mounting.tests) {
        besides.waves_um.push([(); 2].map(|()| any(limits.bar_um)));
        if besides.slides.iter().all(|(place, _)| *place != test.spindle_mm) {
            besides.slides.push((test.spindle_mm, [(); 3].map(|()| any(limits.slides_um))));
        }
    }
    besides
}

/// What a method states of a played design when it takes it to be `declared`.
fn stated(declared: &Claim, played: &session::Session) -> Claim {
    let mut read = declared.session.clone();
    assert_eq!(read.tests.len(), played.runs.len());
    for (test, run) in read.tests.iter_mut().zip(&played.runs) {
        assert_eq!(test.name, run.name);
        let recording = test.recording.as_mut().expect("recorded");
        assert_eq!(recording.length_mm.len(), run.rows.len());
        recording.length_mm = run.rows.iter().map(|[_, _, length_mm]| *length_mm).collect();
    }
    let estimate = match declared.reduction {
        Reduction::Chapter4 => chapter4(&read),
        Reduction::Chapter5 => chapter5(&read),
        Reduction::Chapter6 | Reduction::Fit => chapter6(&read),
    };
    let estimate = estimate.unwrap();
    let value = |stated: &ClaimedValue| {
        let found = estimate.values.iter().find(|value| value.name == stated.name).unwrap();
        ClaimedValue { name: found.name.clone(), value: found.value, deviation: found.mean_deviation.unwrap() }
    };
    Claim { values: declared.values.iter().map(value).collect(), ..declared.clone() }
}

/// Physics of a cause at a size in µm; `None` for an assumption.
fn physics(session: &Session, kind: &Kind, size_um: f64) -> Option<Physics> {
    let along = |coordinate: usize| std::array::from_fn(|k| if k == coordinate { size_um } else { 0.0 });
    let name = |axis: usize| session.machine.axes[axis].name.as_str();
    match *kind {
        Kind::Seat { from_group, coordinate } => {
            Some(Physics::Seat { from_circle: from_group, by_um: along(coordinate) })
        }
        Kind::Growth { coordinate, .. } => Some(Physics::Growth { by_um: along(coordinate), tau_s: 1800.0 }),
        Kind::AxialMotion { axis, is_sine } => {
            let axis = if name(axis) == "A" { Axis::A } else { Axis::C };
            let [cosine_um, sine_um] = if is_sine { [0.0, size_um] } else { [size_um, 0.0] };
            Some(Physics::Axial { axis, cosine_um, sine_um })
        }
        Kind::WornGuideway { axis, centre_mm, coordinate } => {
            let slide = ["X", "Y", "Z"].iter().position(|slide| *slide == name(axis)).unwrap();
            Some(Physics::Worn { slide, centre_mm, width_mm: 160.0, by_um: along(coordinate) })
        }
        _ => None,
    }
}

/// A design as it really stood when an assumption about it is wrong; `size` in mm where it has one.
fn really(mut design: Design, session: &Session, kind: &Kind, size: f64) -> Design {
    let axis = match *kind {
        Kind::LeverSign { axis }
        | Kind::LeverLength { axis, .. }
        | Kind::PivotSide { axis }
        | Kind::PlaceAlong { axis } => session.machine.axes[axis].name.as_str(),
        _ => return design,
    };
    let axis = if axis == "A" { Axis::A } else { Axis::C };
    let along = if axis == Axis::A { 0 } else { 2 };
    // an axis's tests have a pivot of their own where the other's stays
    let of_axis = |mounting: &Mounting, axis: Axis| {
        let tests: Vec<_> = mounting.tests.iter().filter(|test| test.axis == axis).cloned().collect();
        (!tests.is_empty()).then(|| Mounting { tests, ..mounting.clone() })
    };
    let mountings = design.mountings.iter().flat_map(|mounting| [Axis::A, Axis::C].map(|axis| of_axis(mounting, axis)));
    design.mountings = mountings.flatten().collect();
    for mounting in design.mountings.iter_mut().filter(|mounting| mounting.tests[0].axis == axis) {
        let place = |at: f64| match *kind {
            Kind::LeverSign { .. } => -at,
            Kind::LeverLength { factor, .. } => factor * at,
            Kind::PlaceAlong { .. } => at + size,
            _ => at,
        };
        mounting.pivot_mm[along] = place(mounting.pivot_mm[along]);
        mounting.tests.iter_mut().for_each(|test| test.spindle_mm[along] = place(test.spindle_mm[along]));
        if matches!(kind, Kind::PivotSide { .. }) {
            (0..3).filter(|k| *k != along).for_each(|k| mounting.pivot_mm[k] *= -1.0);
        }
    }
    design
}

/// The session as someone describes it who takes D as eq. 3.13 prints it, 50√2 for 50√5.
fn with_printed_d(claim: &Claim) -> Claim {
    let mut declared = claim.clone();
    for test in declared.session.tests.iter_mut().filter(|test| test.name.contains("extended")) {
        let along = if test.name.starts_with("a-") { 0 } else { 2 };
        // the spindle ball stands D from the pivot's circle, towards −x on A and +z on C
        let away = if along == 0 { -1.0 } else { 1.0 };
        test.spindle_ball.at[along] -= away * 50.0 * (5f64.sqrt() - 2f64.sqrt());
    }
    declared
}

/// The three results when a cause of a size acts; `None`: nothing acts.
fn triple(claims: &[Claim], planted: Option<(&Cause, f64)>, seed: u64) -> Vec<Claim> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let limits = Limits::default();
    let one = |(index, design): (usize, Design)| {
        let claim = &claims[index];
        let mut besides = within_the_limits(&design, &limits, &mut random);
        let acting = planted.filter(|(cause, _)| cause.claim.is_none_or(|of| of == index));
        let mut design = Design { errors: errors(), ..design };
        let Some((cause, size)) = acting else {
            return stated(claim, &session::play_with(design, seed, 1.0, &besides));
        };
        besides.physics = physics(&claim.session, &cause.kind, size);
        design = really(design, &claim.session, &cause.kind, size);
        let declared = if cause.kind == Kind::PrintedD { with_printed_d(claim) } else { claim.clone() };
        let result = stated(&declared, &session::play_with(design, seed, 1.0, &besides));
        let mut result = Claim { session: claim.session.clone(), ..result };
        if let Kind::OuterTilt { outer, inner, left_in } = &cause.kind {
            let at = |name: &fiveaxis::machine::ErrorName| {
                result.values.iter().position(|value| value.name == *name).unwrap()
            };
            let (outer, inner) = (at(outer), at(inner));
            result.values[inner].value += left_in * result.values[outer].value;
        }
        result
    };
    designs().into_iter().enumerate().map(one).collect()
}

#[test]
fn consistent_recordings_are_not_accused() {
    let claims = claims();
    let accused: usize = (0..draws() as u64)
        .into_par_iter()
        .map(|draw| {
            let results = triple(&claims, None, 22_000 + draw);
            let prepared = Prepared::of(&results, &Limits::default()).unwrap();
            let found = prepared.judge(&prepared.values(&results));
            usize::from(found.verdicts.iter().any(|verdict| verdict.is_named()))
        })
        .sum();
    println!("{accused} of {} consistent triples of recordings accused", draws());
    // 2 % of the draws
    assert!(accused * 50 <= draws().max(50), "{accused} of {}", draws());
}

/// A disagreement of this many standard deviations shows in nearly every draw: threshold 3.4, scatter 1.
const VISIBLE: f64 = 6.5;

/// Causes drawn at random with sizes, those that show at all: indices and sizes (µm, mm, or 0 for an assumption).
fn visible_causes(prepared: &Prepared, claims: &[Claim]) -> Vec<(usize, f64)> {
    let mut random = ChaCha8Rng::seed_from_u64(23);
    let first = prepared.values(claims);
    let truth = nalgebra::DVector::from_fn(first.len(), |k, _| first[k % 8]);
    let mut found = Vec::new();
    while found.len() < draws() {
        let index = random.random_range(0..prepared.causes.len());
        let cause = &prepared.causes[index];
        let sign = if random.random_bool(0.5) { -1.0 } else { 1.0 };
        let size = cause.limit.map_or(0.0, |limit| limit * sign * random.random_range(0.3..1.0));
        let change = match cause.limit {
            Some(_) => prepared.stacked(cause, &truth) * size,
            None => prepared.unrestated(cause, &truth) - &truth,
        };
        // a bar within its limit is part of the budget
        if !matches!(cause.kind, Kind::Bar { .. }) && prepared.sigmas(&change) >= VISIBLE {
            found.push((index, size));
        }
    }
    found
}

#[test]
fn a_cause_planted_in_recordings_is_among_those_named() {
    let claims = claims();
    let prepared = Prepared::of(&claims, &Limits::default()).unwrap();
    let planted = visible_causes(&prepared, &claims);
    let named: usize = planted
        .par_iter()
        .enumerate()
        .map(|(draw, (index, size))| {
            let cause = &prepared.causes[*index];
            let results = triple(&claims, Some((cause, *size)), 23_000 + draw as u64);
            let prepared = Prepared::of(&results, &Limits::default()).unwrap();
            assert_eq!(prepared.causes[*index].kind, cause.kind);
            let found = prepared.judge(&prepared.values(&results));
            let own = found.verdicts.iter().find(|verdict| verdict.cause == *index);
            let is_named = own.is_some_and(|verdict| verdict.is_named());
            if !is_named {
                println!("missed {:?} {size:+.1} in {:?}: {own:?}", cause.kind, cause.claim);
            }
            usize::from(is_named)
        })
        .sum();
    println!("{named} of {} causes planted in recordings named", planted.len());
    assert!(named * 100 >= 95 * planted.len(), "{named} of {}", planted.len());
}
