//! A quick look at every family: its best cell on the grid, judged against what a stage has fitted. It refines nothing.

use rayon::prelude::*;

use super::candidates::family_terms;
use super::screening_grid::ScreeningGrid;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::model::regression::Regression;
use crate::diagnose::model::whitened::LastShape;
use crate::diagnose::selection::selected::Candidate;
use crate::effects::CandidateFamily;
use crate::effects::{Profile, Signature, is_a};
use crate::machine::{Effect, ParameterValue};

/// The stage at which a family is judged: all rows for fast ones.
pub fn stage_of<'s, 'g, 'a>(
    regressions: &'s [Regression<'g, 'a>; 2],
    family: &CandidateFamily,
) -> &'s Regression<'g, 'a> {
    &regressions[usize::from(!family.fast)]
}

/// Cells of a long periodic grid that are judged exactly after a quick look at all.
const SPECTRAL_CELLS: usize = 5;
/// Periodic grids longer than this get the quick look.
const LONG_GRID: usize = 24;

/// The best cell of every family, best first.
pub fn screen(regressions: &[Regression; 2], families: &[CandidateFamily], cells: &ScreeningGrid) -> Vec<Candidate> {
    let machine = regressions[0].model.context.machine();
    let matched = regressions[0].matched();
    let mut list: Vec<Candidate> = families
        .par_iter()
        .enumerate()
        .filter_map(|(index, family)| {
            let regression = stage_of(regressions, family);
            let mut last = LastShape::default();
            let mut judged = |effect: &Effect, terms: &[Term], profiles: &[Profile]| {
                let judgement = regression.judge_shape((index, effect), (profiles, terms), family.plausible, &mut last);
                let log_odds = judgement.log_evidence;
                // the columns follow when the candidate is refined
                let columns = Vec::new();
                Candidate { family: index, effect: effect.clone(), terms: terms.to_vec(), columns, log_odds, judgement }
            };
            let better = |a: &Candidate, b: &Candidate| a.log_odds.total_cmp(&b.log_odds);
            let best = if family.fast {
                let grid: Vec<&Effect> = if is_a(family.kind, Signature::Period) && family.grid.len() > LONG_GRID {
                    loudest(regression.model, family, &matched)
                } else {
                    family.grid.iter().collect()
                };
                let cells = grid.into_iter().filter_map(|effect| {
                    let terms = family_terms(machine, family, effect, regression.model.tests());
                    Some(judged(effect, &terms, &regression.model.profiles(effect).ok()?))
                });
                cells.max_by(better)
            } else {
                let cells = cells.of_family(index).iter();
                cells.map(|cell| judged(cell.effect, &cell.terms, &cell.profiles)).max_by(better)
            };
            let mut best = best?;
            best.log_odds -= (family.grid.len() as f64).ln() + family.rarity;
            Some(best)
        })
        .filter(|candidate| candidate.log_odds > 0.0)
        .collect();
    list.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
    list
}
/// The periods of a grid whose sine or cosine the matched residual holds most of, over tests in which the axis moves.
fn loudest<'f>(model: &LinearModel, family: &'f CandidateFamily, matched: &[Vec<f64>]) -> Vec<&'f Effect> {
    let Some(axis) = family.place.axis() else { return Vec::new() };
    let gains = model.gains(&family.outlets[0]);
    let tests: Vec<usize> = (0..model.tests())
        .filter(|&test| model.context.motion(test).moving.contains(&axis) && !gains[test].is_empty())
        .collect();
    let rows: Vec<(f64, f64, f64)> = tests
        .iter()
        .flat_map(|&test| {
            let gain = &gains[test];
            let positions = model.context.motion(test).axis(axis);
            positions.zip(gain.iter().zip(&matched[test])).map(|(q, (g, m))| (q, g * m, g * g)).collect::<Vec<_>>()
        })
        .collect();
    let frequencies: Vec<f64> = family.grid.iter().map(|effect| angular_frequency(effect).unwrap_or(0.0)).collect();
    let mut order: Vec<(usize, f64)> = powers(&rows, &frequencies).into_iter().enumerate().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    order.into_iter().take(SPECTRAL_CELLS).map(|(index, _)| &family.grid[index]).collect()
}

/// How much of a score each of some evenly spaced angular frequencies holds; a row is a position, its score and its weight.
fn powers(rows: &[(f64, f64, f64)], frequencies: &[f64]) -> Vec<f64> {
    let step = match frequencies {
        [first, second, ..] => second - first,
        _ => 0.0,
    };
    let first = frequencies.first().copied().unwrap_or(0.0);
    // one turn of every row's phasor leads from a frequency to the next
    let turns: Vec<(f64, f64)> = rows.iter().map(|(q, ..)| (step * q).sin_cos()).collect();
    let mut phasors: Vec<(f64, f64)> = rows.iter().map(|(q, ..)| (first * q).sin_cos()).collect();
    frequencies
        .iter()
        .map(|_| {
            let (mut c, mut s, mut cc, mut ss) = (0.0, 0.0, 0.0, 0.0);
            for ((&(_, gm, gg), phasor), (turn_sin, turn_cos)) in rows.iter().zip(&mut phasors).zip(&turns) {
                let (sin, cos) = *phasor;
                c += gm * cos;
                s += gm * sin;
                cc += gg * cos * cos;
                ss += gg * sin * sin;
                *phasor = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
            }
            c * c / cc.max(f64::MIN_POSITIVE) + s * s / ss.max(f64::MIN_POSITIVE)
        })
        .collect()
}

/// Phase per mm or rad of the first order or period of an effect.
fn angular_frequency(effect: &Effect) -> Option<f64> {
    match (effect.parameter("orders"), effect.parameter("periods")) {
        (Some(ParameterValue::List(orders)), _) => orders.first().copied(),
        (_, Some(ParameterValue::List(periods))) => periods.first().map(|period| std::f64::consts::TAU / period),
        _ => None,
    }
}
