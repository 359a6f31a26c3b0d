//! Simulated sessions whose linear axes err: component errors drawn as functions of its own, and how often a fit's sigmas hold.
#![allow(dead_code)] // test and example use their own parts

use std::path::Path;

use fiveaxis::chain::Composition;
use fiveaxis::identify::{Fit, Options, default_free, identify};
use fiveaxis::load::load_machine;
use fiveaxis::machine::{AxisKind, Component, ComponentError, ComponentForm, ErrorName, Harmonic, LinearAxes};
use fiveaxis::session::{Ball, Follow, Path as TestPath, Session, Spread, Test};
use fiveaxis::simulate::{Instrument, SetupErrors, simulate_with};
use fiveaxis::units::{ARCSEC_PER_RAD, UM_PER_MM};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use crate::recorded::{planned_thesis_session, recorded};

/// How the true errors of a linear axis depend on its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// The position times a wave of 0.8 to 3 m length and random phase, in each direction: everywhere as large as stated.
    Waves,
    /// A plain wave of such a length: as large as stated near zero, smaller farther out.
    PlainWaves,
    /// An error of scale along the axis and a bow across it.
    ScaleAndBow,
    /// None at all.
    Exact,
}

/// What is drawn: standard deviations, per length moved and rad.
pub const PER_LENGTH: f64 = 5e-6;
pub const SQUARENESS_RAD: f64 = 10e-6;
/// Position at which a bow has the stated standard deviation per length, mm.
const BOW_AT_MM: f64 = 150.0;

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// The session with location errors (30 µm, 10 arcsec) and linear axes that err.
pub fn with_errors(session: &Session, form: Form, seed: u64) -> Session {
    let mut truth = session.clone();
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x11ea7);
    for name in default_free(&session.machine) {
        let axis = session.machine.axis_index(&name.axis).unwrap();
        let sigma = if name.component.is_angle() { 10.0 / ARCSEC_PER_RAD } else { 30.0 / UM_PER_MM };
        truth.machine.axes[axis].location_errors[name.component.index()] = sigma * normal(&mut random);
    }
    if form == Form::Exact {
        return truth;
    }
    for axis in truth.machine.axes.iter_mut().filter(|axis| axis.kind == AxisKind::Linear) {
        let along = (0..3).find(|&k| axis.direction[k].abs() > 0.999).expect("an axis along a coordinate");
        // EC0Y, EB0Z and EA0Z: the others are zero by the choice of R
        let square: &[usize] = [&[][..], &[5], &[3, 4]][along];
        square.iter().for_each(|&k| axis.location_errors[k] = SQUARENESS_RAD * normal(&mut random));
        for direction in 0..3 {
            let form = match form {
                Form::Waves => growing_wave(&mut random),
                Form::PlainWaves => wave(&mut random),
                _ if direction == along => ComponentForm::Polynomial(vec![PER_LENGTH * normal(&mut random)]),
                _ => ComponentForm::Polynomial(vec![0.0, PER_LENGTH / BOW_AT_MM * normal(&mut random)]),
            };
            axis.component_errors.push(ComponentError { component: Component::ALL[direction], form });
        }
    }
    truth
}

/// `q·(a·cos kq + b·sin kq)` as a table of straight lines; its standard deviation is `PER_LENGTH·|q|`.
fn growing_wave(random: &mut ChaCha8Rng) -> ComponentForm {
    let frequency = std::f64::consts::TAU / random.random_range(800.0..3000.0);
    let (a, b) = (PER_LENGTH * normal(random), PER_LENGTH * normal(random));
    // farther than any axis goes; lines of 5 mm leave such waves by less than a nanometre
    let position: Vec<f64> = (-160..=160).map(|k| 5.0 * f64::from(k)).collect();
    let value = position.iter().map(|q| q * (a * (frequency * q).cos() + b * (frequency * q).sin())).collect();
    ComponentForm::Table { position, value }
}

/// `a·(cos kq − 1) + b·sin kq`: its standard deviation is `PER_LENGTH·|sin(kq/2)|·2/k`, near zero `PER_LENGTH·|q|`.
fn wave(random: &mut ChaCha8Rng) -> ComponentForm {
    let length_mm = random.random_range(800.0..3000.0);
    let frequency = std::f64::consts::TAU / length_mm;
    let sigma = PER_LENGTH / frequency;
    ComponentForm::Fourier(vec![Harmonic { frequency, cosine: sigma * normal(random), sine: sigma * normal(random) }])
}

/// Chapter 5's four tests on the C600U (A and C in the table), one run in each direction.
pub fn table_table(samples: usize) -> Session {
    planned_thesis_session(samples)
}

/// Three setups on the shipped blade mill (A in the table, B in the head) with the linear axes following, as `plan` proposes.
pub fn table_head(samples: usize) -> Session {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/table-head-ab-blade.yaml");
    let machine = load_machine(&file).expect("shipped machine");
    let axis = |name: &str| machine.axis_index(name).expect("axis");
    let (a, b) = (axis("A"), axis("B"));
    let pivot = Vector3::new(-17.5, 50.063, 50.063);
    let setups = [
        ("a-axial", a, b, -150.0, -180.0, 180.0, Follow::Axial),
        ("a-tangential", a, b, -150.0, -150.0, 60.0, Follow::Tangential),
        ("b-axial", b, a, -90.0, -45.0, 45.0, Follow::Axial),
    ];
    let mut tests = Vec::new();
    for (name, turns, stands, ball_z, from, to, follow) in setups {
        for (way, from, to) in [("ccw", from, to), ("cw", to, from)] {
            let ball =
                |link: &str, at| Ball { link: link.into(), at, setup: None, spread_mm: None, indexed_about: None };
            let mut positions = vec![None; machine.axes.len()];
            positions[stands] = Some(0.0);
            let step = f64::abs(to - from) / (samples - 1) as f64;
            tests.push(Test {
                name: format!("{name}-{way}"),
                recording_file: None,
                recording: None,
                path: Some(TestPath::Sweep { axis: turns, from, to, step, follow, length_mm: None }),
                started_at_s: 90.0 * tests.len() as f64,
                bar_length_mm: Some(100.0),
                bar_setup: None,
                zero: Default::default(),
                bar_error_mm: 0.0,
                pivot: ball("A", pivot),
                spindle_ball: ball("t", Vector3::new(0.0, 0.0, ball_z)),
                positions,
                feed_mm_per_min: Some(500.0),
                overshoot: Some(4.0),
                marks: None,
                approached: Vec::new(),
                reading: fiveaxis::readings::Reading::Length,
            });
        }
    }
    Session { name: "table and head".into(), machine_file: String::new(), machine, spread: Spread::default(), tests }
}

/// How an error came out over many sessions.
#[derive(Debug, Clone)]
pub struct Coverage {
    pub name: String,
    /// The recordings determine it, in every session.
    pub determined: bool,
    /// Share of the sessions in which the truth is within two reported sigmas, and within two sigmas of exact linear axes.
    pub within: f64,
    pub within_if_exact: f64,
    /// Root mean square of estimate minus truth in reported sigmas.
    pub rms: f64,
    /// Mean reported sigma with the budget and of noise alone, µm or arcsec.
    pub sigma: f64,
    pub sigma_exact: f64,
}

/// Sessions that are fitted with exact linear axes too.
const EXACT_TOO: u64 = 100;

/// What one session says of one error.
struct Outcome {
    in_sigmas: f64,
    sigma: f64,
    determined: bool,
    /// Deviation in sigmas and sigma of a fit that takes the linear axes as exact.
    if_exact: Option<(f64, f64)>,
}

/// Simulates, reads with the default gauge and identifies sessions; by error that is free by default, in their order.
pub fn coverage(planned: &Session, form: Form, seeds: std::ops::Range<u64>) -> Vec<Coverage> {
    let mut exact = planned.clone();
    exact.machine.linear_axes = LinearAxes::EXACT;
    let names = default_free(&planned.machine);
    let first = seeds.start;
    let rows: Vec<Vec<Outcome>> = seeds
        .into_par_iter()
        .map(|seed| {
            let truth = with_errors(planned, form, seed);
            let traces = simulate_with(&truth, Composition::Exact, &SetupErrors::drawn(&truth, seed)).unwrap();
            let traces = Instrument::default().read(&truth, traces, seed).unwrap();
            let fitted = |planned: &Session| {
                let fit = identify(&recorded(planned, &traces), &Options::default());
                fit.unwrap_or_else(|why| panic!("seed {seed}: {why}"))
            };
            let fit = fitted(planned);
            let fit_exact = (seed - first < EXACT_TOO).then(|| fitted(&exact));
            let outcome = |name: &ErrorName| {
                let axis = truth.machine.axis_index(&name.axis).unwrap();
                let inserted = truth.machine.axes[axis].location_errors[name.component.index()];
                let k = fit.unknowns.iter().position(|unknown| unknown.label == name.to_string()).unwrap();
                let of = |fit: &Fit| {
                    let estimate = &fit.estimates[k];
                    let sigma = fit.unknowns[k].measure.to_output(estimate.sigma);
                    ((estimate.value - inserted) / estimate.sigma, sigma)
                };
                let (in_sigmas, sigma) = of(&fit);
                let determined = fit.estimates[k].determined;
                Outcome { in_sigmas, sigma, determined, if_exact: fit_exact.as_ref().map(of) }
            };
            names.iter().map(outcome).collect()
        })
        .collect();
    names.iter().enumerate().map(|(k, name)| summary(name, rows.iter().map(|row| &row[k]).collect())).collect()
}

fn summary(name: &ErrorName, outcomes: Vec<&Outcome>) -> Coverage {
    let share = |offs: &[f64]| offs.iter().filter(|off| off.abs() <= 2.0).count() as f64 / offs.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let offs: Vec<f64> = outcomes.iter().map(|outcome| outcome.in_sigmas).collect();
    let (offs_exact, sigmas_exact): (Vec<f64>, Vec<f64>) =
        outcomes.iter().filter_map(|outcome| outcome.if_exact).unzip();
    Coverage {
        name: name.to_string(),
        determined: outcomes.iter().all(|outcome| outcome.determined),
        within: share(&offs),
        within_if_exact: share(&offs_exact),
        rms: mean(&offs.iter().map(|off| off * off).collect::<Vec<f64>>()).sqrt(),
        sigma: mean(&outcomes.iter().map(|outcome| outcome.sigma).collect::<Vec<f64>>()),
        sigma_exact: mean(&sigmas_exact),
    }
}

/// Share over all errors that are determined.
pub fn overall(list: &[Coverage]) -> f64 {
    let determined: Vec<f64> = list.iter().filter(|error| error.determined).map(|error| error.within).collect();
    determined.iter().sum::<f64>() / determined.len() as f64
}

/// One line an error.
pub fn table(list: &[Coverage]) -> String {
    let mut text =
        String::from("  error  within 2 σ  rms in σ  mean σ  taken as exact: within 2 σ  mean σ   (µm or arcsec)\n");
    for c in list {
        text.push_str(&format!(
            "  {:<6} {:>8.1} % {:>9.3} {:>7.2} {:>24.1} % {:>7.2}{}\n",
            c.name,
            100.0 * c.within,
            c.rms,
            c.sigma,
            100.0 * c.within_if_exact,
            c.sigma_exact,
            if c.determined { "" } else { "  not determined" }
        ));
    }
    text.push_str(&format!("  all that are determined {:.1} %\n", 100.0 * overall(list)));
    text
}
