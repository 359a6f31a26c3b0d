//! Candidates of recorder, balls and bars. It judges nothing.

use super::family::{CandidateFamily, Refined, list_of, number, refined};
use super::growth::{channels, lag_refined, lagging};
use super::motions::slides_move;
use super::vibrations::{beats, vibrations};
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::{BALL_FORM, BALL_SLIP, BAR_LENGTH, CUP_STICTION, PIVOT_SLIP, RADIUS_LOSS, TRIGGER_LATENCY};
use crate::machine::{AxisKind, Effect, Outlet, ParameterValue, Place};

pub(super) fn setup(model: &LinearModel, list: &mut Vec<CandidateFamily>) {
    let session = model.context.session();
    let setups = model.problem.setups;
    list.push(CandidateFamily::new(TRIGGER_LATENCY.name, Place::Recorder, vec![Outlet::Delay], 200.0).fast());
    let one_test = |test: &usize| {
        let mut effect = Effect::new(TRIGGER_LATENCY.name, Place::Recorder);
        effect.tests = Some(vec![session.tests[*test].name.clone()]);
        effect
    };
    let tests = model.context.order();
    if tests.len() > 1 {
        // lengths and positions of one test that were paired with a shift of some tenths of a second or more
        let shifted: Vec<Effect> = tests.iter().map(one_test).collect();
        list.push(
            CandidateFamily::new(TRIGGER_LATENCY.name, Place::Recorder, vec![Outlet::Delay], 3000.0)
                .over(shifted)
                .fast(),
        );
    }
    let latest = tests.iter().map(|&test| model.context.ends_at_s(test)).fold(0.0, f64::max);
    let slip = |kind: &'static str,
                place: Place,
                setup_of: &[usize],
                setup: usize,
                outlets: Vec<Outlet>,
                list: &mut Vec<CandidateFamily>| {
        let mut grid = Vec::new();
        let mut first = true;
        for &test in tests.iter().filter(|&&test| setup_of[test] == setup) {
            let (from, to) = (session.tests[test].started_at_s, model.context.ends_at_s(test));
            let shares: &[f64] = if first { &[0.2, 0.4, 0.6, 0.8] } else { &[-1e-6, 0.2, 0.4, 0.6, 0.8] };
            first = false;
            let ball =
                if place == Place::Pivot { &session.tests[test].pivot } else { &session.tests[test].spindle_ball };
            let shares = shares.iter().map(|share| from + share * (to - from));
            for time in shares.chain(jumps(model, test)) {
                grid.push(
                    number(kind, place, "time", time)
                        .with("link", ParameterValue::Word(ball.link.clone()))
                        .with("at", list_of(vec![ball.at.x, ball.at.y, ball.at.z])),
                );
            }
        }
        if !grid.is_empty() {
            list.push(CandidateFamily::new(kind, place, outlets, 30.0).over(grid).fast().refine(vec![
                Refined { name: "time", least: 0.0, most: latest, step: 3.0, element: None },
                Refined { name: "creep_share", least: 0.0, most: 1.0, step: 0.3, element: None },
                Refined { name: "creep_time", least: 0.5, most: 2000.0, step: 10.0, element: None },
            ]));
        }
    };
    for setup in 0..setups.pivots.len() {
        slip(PIVOT_SLIP.name, Place::Pivot, &setups.pivot_of, setup, (0..3).map(Outlet::Pivot).collect(), list);
    }
    for setup in 0..setups.spindle_balls.len() {
        slip(
            BALL_SLIP.name,
            Place::SpindleBall,
            &setups.spindle_ball_of,
            setup,
            (0..3).map(Outlet::SpindleBall).collect(),
            list,
        );
    }
    let first_slide = session.machine.axes.iter().position(|axis| axis.kind == AxisKind::Linear);
    if let Some(axis) = first_slide.filter(|_| slides_move(model)) {
        let outlets = vec![Outlet::SlidesAcceleration { axis }];
        let all = CandidateFamily::new(RADIUS_LOSS.name, Place::Control, outlets, 1e4).fast();
        list.push(CandidateFamily { rarity: LOST_BY_ALL, ..all });
    }
    for place in [Place::Pivot, Place::SpindleBall] {
        let form = |degree: f64| number(BALL_FORM.name, place, "degree", degree);
        let family = CandidateFamily::new(BALL_FORM.name, place, vec![Outlet::Reading], ROUND_WITHIN);
        list.push(CandidateFamily { rarity: GOOD_BALLS, ..family.over([2.0, 3.0, 4.0].map(form).to_vec()) });
        let sticks = |turned: f64| number(CUP_STICTION.name, place, "turned", turned);
        let family = CandidateFamily::new(CUP_STICTION.name, place, vec![Outlet::Reading], 2.0);
        let family = family.over([2.0, 5.0, 12.0].map(sticks).to_vec()).refine(vec![refined("turned", 0.3, 60.0, 0.4)]);
        list.push(CandidateFamily { rarity: GOOD_BALLS, ..family.fast() });
    }
    vibrations(model, list);
    beats(model, list);
    let span = latest.max(60.0);
    let growing: &[&str] = if setups.bars.len() > 1 { &["by-length", "alike"] } else { &["alike"] };
    for way in growing {
        let bar_growth = Effect::new(BAR_LENGTH.name, Place::Bar).with("growing", ParameterValue::Word((*way).into()));
        let over_time = |share: f64| bar_growth.clone().with("tau", list_of(vec![share * span]));
        let mut family = CandidateFamily::new(BAR_LENGTH.name, Place::Bar, vec![Outlet::Reading], 30.0)
            .over([0.1, 0.3, 1.0].map(over_time).to_vec())
            .refine(vec![Refined { name: "tau", least: 10.0, most: 10.0 * span, step: 0.1 * span, element: Some(0) }]);
        family.functions = &["growth1"];
        list.push(family);
        for channel in channels(model) {
            let effect = bar_growth.clone().with("channel", ParameterValue::Word(channel));
            let mut family = CandidateFamily::new(BAR_LENGTH.name, Place::Bar, vec![Outlet::Reading], 30.0)
                .over(lagging(&effect, span))
                .refine(vec![lag_refined(span)]);
            family.functions = &["kelvin"];
            list.push(family);
        }
    }
    for bar in &setups.bars {
        if let Some(length) = session.tests[bar.first_test].bar_length_mm {
            let effect = number(BAR_LENGTH.name, Place::Bar, "bar", length);
            list.push(
                CandidateFamily::new(BAR_LENGTH.name, Place::Bar, vec![Outlet::Reading], 30.0).over(vec![effect]),
            );
        }
    }
}

/// Log odds against balls that are out of round or stick: they are gauges. Amplitudes of their form are plausible up to
/// some tenths, µm.
const GOOD_BALLS: f64 = 4.0;
const ROUND_WITHIN: f64 = 0.6;

/// Log odds against a radius that all slides lose: circles of a control that was set up are round.
const LOST_BY_ALL: f64 = 4.0;

/// Rows compared on each side of a possible jump.
const BESIDE: usize = 6;

/// Session times of the two largest jumps of a test's residual.
fn jumps(model: &LinearModel, test: usize) -> Vec<f64> {
    let residual = &model.residual_mm[test];
    let mean = |rows: std::ops::Range<usize>| -> f64 {
        let (sum, count) = rows
            .filter(|&row| model.kept[test][row])
            .fold((0.0, 0usize), |(sum, count), row| (sum + residual[row], count + 1));
        if count == 0 { f64::NAN } else { sum / count as f64 }
    };
    let mut steps: Vec<(usize, f64)> = (BESIDE..residual.len().saturating_sub(BESIDE))
        .map(|row| (row, (mean(row..row + BESIDE) - mean(row - BESIDE..row)).abs()))
        .filter(|(_, step)| step.is_finite())
        .collect();
    steps.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut chosen: Vec<usize> = Vec::new();
    for (row, _) in steps {
        if chosen.len() == 2 {
            break;
        }
        if chosen.iter().all(|&other| other.abs_diff(row) > 3 * BESIDE) {
            chosen.push(row);
        }
    }
    // between the last row before the jump and the first behind it
    let time =
        |row: usize| 0.5 * (model.context.session_time_s(test, row - 1) + model.context.session_time_s(test, row));
    chosen.into_iter().map(time).collect()
}
