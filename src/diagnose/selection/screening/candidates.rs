//! The candidates of a search: what every effect of the catalogue offers for a session, and their terms. It judges nothing.

use super::ripples::ripples;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::noise::spectrum::{aliased, lines};
use crate::effects::{CandidateFamily, KINDS, Kind, Observations, Signature, kind};
use crate::machine::{Effect, Machine, Outlet, ParameterValue};

/// All families for a session, those of one place together.
pub fn families(model: &LinearModel) -> Vec<CandidateFamily> {
    families_seen(model, &observations(model))
}

/// Families whatever the residuals are: without those for which only residuals say what to try.
pub fn families_of_design(model: &LinearModel) -> Vec<CandidateFamily> {
    let seen = Observations {
        context: model.context,
        setups: model.problem.setups,
        lines_hz: Vec::new(),
        ripples: vec![Vec::new(); model.context.machine().axes.len()],
        jumps_s: vec![Vec::new(); model.tests()],
    };
    families_seen(model, &seen)
}

fn families_seen(model: &LinearModel, seen: &Observations) -> Vec<CandidateFamily> {
    let offered = |kind: &&Kind| {
        let families = (kind.candidates)(seen);
        match model.has_sweeps() {
            true => families,
            false => in_poses(kind, families).into_iter().chain((kind.candidates_of_poses)(seen)).collect(),
        }
    };
    let mut list: Vec<CandidateFamily> = KINDS.iter().flat_map(offered).collect();
    // positions too coarse for every shape of a cause leave nothing of it to search
    list.retain(|family| !family.grid.is_empty());
    list.sort_by_key(|family| family.place.axis().unwrap_or(usize::MAX));
    list
}

/// Amplitudes up to this are plausible for a joint of an arm, µm or arcsec, whatever causes them; what loads it may bend it more.
const PLAUSIBLE_OF_JOINTS: f64 = 300.0;

/// What static poses can show of the families of a kind.
fn in_poses(kind: &Kind, mut families: Vec<CandidateFamily>) -> Vec<CandidateFamily> {
    let grows = matches!(kind.signature, Signature::Growth | Signature::BarLength);
    let needs_times =
        |family: &CandidateFamily| grows && family.grid.iter().all(|effect| effect.parameter("tau").is_some());
    // curves over time and of single runs
    families.retain(|family| !kind.needs_runs && !needs_times(family) && !family.only_rival);
    for family in &mut families {
        family.plausible = family.plausible.max(PLAUSIBLE_OF_JOINTS);
        // all rows are looked at anyway; only long grids of periods get the quick look that fast families have
        family.fast = kind.signature == Signature::Period;
    }
    families
}

/// Lines of the spectrum that are tried.
const PEAKS: usize = 4;

fn observations<'m>(model: &'m LinearModel) -> Observations<'m> {
    let machine = model.context.machine();
    let mut lines_hz: Vec<f64> = lines(model, &model.residual_mm).into_iter().take(PEAKS).map(|line| line.hz).collect();
    let aliases = aliased(model, &model.residual_mm, &lines_hz);
    lines_hz.extend(aliases);
    let of_axis = |axis: usize| match model.context.travelled(axis) {
        Some(_) => ripples(model, axis, &Outlet::own(machine, axis)),
        None => Vec::new(),
    };
    Observations {
        context: model.context,
        setups: model.problem.setups,
        lines_hz,
        ripples: (0..machine.axes.len()).map(of_axis).collect(),
        jumps_s: (0..model.tests()).map(|test| jumps(model, test)).collect(),
    }
}

/// Rows compared on each side of a possible jump.
const ROWS_BESIDE_A_JUMP: usize = 6;

/// Jumps of a test that are told.
const MOST_JUMPS: usize = 2;

/// Session times of the largest jumps of a test's residual.
fn jumps(model: &LinearModel, test: usize) -> Vec<f64> {
    let residual = &model.residual_mm[test];
    let mean = |rows: std::ops::Range<usize>| -> f64 {
        let (sum, count) = rows
            .filter(|&row| model.kept[test][row])
            .fold((0.0, 0usize), |(sum, count), row| (sum + residual[row], count + 1));
        if count == 0 { f64::NAN } else { sum / count as f64 }
    };
    let mut steps: Vec<(usize, f64)> = (ROWS_BESIDE_A_JUMP..residual.len().saturating_sub(ROWS_BESIDE_A_JUMP))
        .map(|row| (row, (mean(row..row + ROWS_BESIDE_A_JUMP) - mean(row - ROWS_BESIDE_A_JUMP..row)).abs()))
        .filter(|(_, step)| step.is_finite())
        .collect();
    steps.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut chosen: Vec<usize> = Vec::new();
    for (row, _) in steps {
        if chosen.len() == MOST_JUMPS {
            break;
        }
        if chosen.iter().all(|&other| other.abs_diff(row) > 3 * ROWS_BESIDE_A_JUMP) {
            chosen.push(row);
        }
    }
    // between the last row before the jump and the first behind it
    let time =
        |row: usize| 0.5 * (model.context.session_time_s(test, row - 1) + model.context.session_time_s(test, row));
    chosen.into_iter().map(time).collect()
}

/// Terms of an effect: every function through every outlet.
pub fn terms(machine: &Machine, effect: &Effect, outlets: &[Outlet]) -> Vec<Term> {
    let Some(kind) = kind(&effect.kind) else { return Vec::new() };
    let functions = (kind.functions)(effect);
    outlets
        .iter()
        .flat_map(|outlet| {
            functions.iter().enumerate().map(|(function, name)| Term {
                outlet: *outlet,
                function,
                measure: (kind.measure)(machine, outlet, name),
                test: None,
                along: None,
            })
        })
        .collect()
}

/// Parameter of a candidate alone: the direction along which the spindle ball moves. In a machine file its x, y and z have
/// sizes in that ratio.
pub const ALONG: &str = "along";

/// Terms of a family's effect.
pub fn family_terms(machine: &Machine, family: &CandidateFamily, effect: &Effect) -> Vec<Term> {
    let mut plain = terms(machine, effect, &family.outlets);
    if let Some(kind) = kind(&effect.kind) {
        let names = (kind.functions)(effect);
        let name = |term: &Term| names[term.function].as_str();
        plain.retain(|term| family.functions.is_empty() || family.functions.contains(&name(term)));
        plain.retain(|term| family.pairs.is_empty() || family.pairs.contains(&(term.outlet, name(term))));
    }
    if let Some(ParameterValue::List(along)) = effect.parameter(ALONG)
        && let Ok(along) = <[f64; 3]>::try_from(along.as_slice())
    {
        plain.retain(|term| term.outlet == Outlet::SpindleBall(0));
        plain.iter_mut().for_each(|term| term.along = Some(along));
    }
    if family.by_test.is_empty() {
        return plain;
    }
    family.by_test.iter().flat_map(|&test| plain.iter().map(move |term| Term { test: Some(test), ..*term })).collect()
}
