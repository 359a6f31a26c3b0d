//! A quick look at every family: its best cell on the grid, judged against what a stage has fitted. It refines nothing.

use rayon::prelude::*;

use super::candidates::family_terms;
use super::screening_grid::ScreeningGrid;
use crate::chain::sines_and_cosines;
use crate::diagnose::model::last_shape::LastShape;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::model::regression::Regression;
use crate::diagnose::model::shapes::name;
use crate::diagnose::selection::ranking::sort_by_odds;
use crate::diagnose::selection::selected::Candidate;
use crate::effects::CandidateFamily;
use crate::effects::{Profile, Signature, is_a, wave_numbers};
use crate::machine::Effect;
use crate::statistics::BlockEvidence;

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

/// Log odds of its best cell from which a family is refined: a shape between two cells, and a noise that holds what an effect
/// explains, cost a weak one several.
const WORTH_REFINING: f64 = -6.0;

/// The best cell of every family that may be worth refining, best first.
pub fn screen(regressions: &[Regression; 2], families: &[CandidateFamily], cells: &ScreeningGrid) -> Vec<Candidate> {
    screen_wanted(regressions, families, cells, |_| true)
}

/// The same of some families, by number.
pub fn screen_wanted(
    regressions: &[Regression; 2],
    families: &[CandidateFamily],
    cells: &ScreeningGrid,
    wanted: impl Fn(usize) -> bool + Sync,
) -> Vec<Candidate> {
    let machine = regressions[0].model.context.machine();
    let matched = regressions[0].matched();
    let has_long_grid = |family: &&CandidateFamily| {
        family.fast && is_a(family.kind, Signature::Period) && family.grid.len() > LONG_GRID
    };
    // families that differ in further outlets alone have the same loudest periods
    let mut long: Vec<&CandidateFamily> = Vec::new();
    let looked_at = families.iter().enumerate().filter(|(index, _)| wanted(*index)).map(|(_, family)| family);
    for family in looked_at.filter(has_long_grid) {
        if !long.iter().any(|other| have_one_look(other, family)) {
            long.push(family);
        }
    }
    let looks: Vec<Vec<usize>> =
        long.par_iter().map(|family| loudest(stage_of(regressions, family).model, family, &matched)).collect();
    let look = |family: &CandidateFamily| long.iter().position(|other| have_one_look(other, family));
    let mut list: Vec<Candidate> = families
        .par_iter()
        .enumerate()
        .filter(|(index, family)| !family.grid.is_empty() && wanted(*index))
        .filter_map(|(index, family)| {
            let regression = stage_of(regressions, family);
            let mut last = LastShape::default();
            let mut judged = |name: &str, terms: &[Term], profiles: &[Profile]| {
                regression.judge_named((index, name), (profiles, terms), family.plausible, &mut last)
            };
            let better = |a: &(&Effect, BlockEvidence), b: &(&Effect, BlockEvidence)| {
                a.1.log_evidence.total_cmp(&b.1.log_evidence)
            };
            let best = if family.fast {
                let grid: Vec<&Effect> = match Some(family).filter(has_long_grid).and_then(look) {
                    Some(look) => looks[look].iter().map(|&index| &family.grid[index]).collect(),
                    None => family.grid.iter().collect(),
                };
                let cells = grid.into_iter().filter_map(|effect| {
                    let terms = family_terms(machine, family, effect);
                    Some((effect, judged(&name(effect), &terms, &regression.model.profiles(effect).ok()?)))
                });
                cells.max_by(better)
            } else {
                let cells = cells.of_family(index).iter();
                cells.map(|cell| (cell.effect, judged(&cell.name, &cell.terms, &cell.profiles))).max_by(better)
            };
            let (effect, judgement) = best?;
            let log_odds = judgement.log_evidence;
            let terms = family_terms(machine, family, effect);
            // the columns follow when the candidate is refined
            let columns = Vec::new();
            let mut best = Candidate { family: index, effect: effect.clone(), terms, columns, log_odds, judgement };
            best.log_odds -= (family.grid.len() as f64).ln() + family.rarity;
            Some(best)
        })
        .filter(|candidate| candidate.log_odds > WORTH_REFINING)
        .collect();
    sort_by_odds(&mut list);
    list
}

/// Whether two families with long grids have the same shapes and first outlet.
fn have_one_look(one: &CandidateFamily, other: &CandidateFamily) -> bool {
    one.outlets.first() == other.outlets.first() && one.place == other.place && one.grid == other.grid
}

/// The periods of a grid whose sine or cosine the matched residual holds most of, over tests in which the axis moves.
fn loudest(model: &LinearModel, family: &CandidateFamily, matched: &[Vec<f64>]) -> Vec<usize> {
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
    let frequencies: Vec<f64> = family.grid.iter().map(|effect| wave_numbers(effect).next().unwrap_or(0.0)).collect();
    let mut order: Vec<(usize, f64)> = powers(&rows, &frequencies).into_iter().enumerate().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    order.into_iter().take(SPECTRAL_CELLS).map(|(index, _)| index).collect()
}

/// How much of a score each of some evenly spaced angular frequencies holds; a row is a position, its score and its weight.
fn powers(rows: &[(f64, f64, f64)], frequencies: &[f64]) -> Vec<f64> {
    let step = match frequencies {
        [first, second, ..] => second - first,
        _ => 0.0,
    };
    let first = frequencies.first().copied().unwrap_or(0.0);
    let turned = |per_unit: f64| sines_and_cosines(&rows.iter().map(|(q, ..)| per_unit * q).collect::<Vec<_>>());
    // one turn of every row's phasor leads from a frequency to the next
    let (turn_sines, turn_cosines) = turned(step);
    let (sines, cosines) = turned(first);
    let mut groups: Vec<Phasors> = (0..rows.len())
        .step_by(LANES)
        .map(|from| {
            let at = |of: &dyn Fn(usize) -> f64| {
                std::array::from_fn(|k| if from + k < rows.len() { of(from + k) } else { 0.0 })
            };
            Phasors {
                score: at(&|row| rows[row].1),
                weight: at(&|row| rows[row].2),
                sin: at(&|row| sines[row]),
                cos: at(&|row| cosines[row]),
                turn_sin: at(&|row| turn_sines[row]),
                turn_cos: at(&|row| turn_cosines[row]),
            }
        })
        .collect();
    let arch = pulp::Arch::new();
    frequencies.iter().map(|_| arch.dispatch(|| power_and_turn(&mut groups))).collect()
}

/// Rows that are looked at side by side.
const LANES: usize = 8;

/// Some rows with their phasors at a frequency.
struct Phasors {
    score: [f64; LANES],
    weight: [f64; LANES],
    sin: [f64; LANES],
    cos: [f64; LANES],
    turn_sin: [f64; LANES],
    turn_cos: [f64; LANES],
}

/// What the rows hold of the frequency at which their phasors are; these are turned to the next one.
#[inline(always)]
fn power_and_turn(groups: &mut [Phasors]) -> f64 {
    let (mut c, mut s, mut cc, mut ss) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for Phasors { score, weight, sin, cos, turn_sin, turn_cos } in groups {
        for k in 0..LANES {
            c[k] += score[k] * cos[k];
            s[k] += score[k] * sin[k];
            cc[k] += weight[k] * cos[k] * cos[k];
            ss[k] += weight[k] * sin[k] * sin[k];
        }
        for k in 0..LANES {
            (sin[k], cos[k]) =
                (sin[k] * turn_cos[k] + cos[k] * turn_sin[k], cos[k] * turn_cos[k] - sin[k] * turn_sin[k]);
        }
    }
    let [c, s, cc, ss] = [c, s, cc, ss].map(|lanes| lanes.iter().sum::<f64>());
    c * c / cc.max(f64::MIN_POSITIVE) + s * s / ss.max(f64::MIN_POSITIVE)
}
