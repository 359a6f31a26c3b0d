//! Jumps that come at the same place of an axis whenever it passes there: something on that axis lifts, catches or switches, no
//! ball has slipped. It fits nothing.

use crate::diagnose::cause::Cause;
use crate::diagnose::findings::finding::{Finding, RangeFound};
use crate::diagnose::findings::forming::shows;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::selection::naming::component_name;
use crate::diagnose::validation::cross_validation::CrossValidation;
use crate::effects::{Driver, UNKNOWN};
use crate::machine::{AxisKind, Component, Outlet};

/// Jumps nearer than this share of an axis's travel are at one place of it: something that moves lets go late.
const SAME_PLACE: f64 = 0.04;
/// Most that is claimed of such a motion: no form says when it comes.
const MOST_CERTAIN: f64 = 0.97;

/// Where a jump stands on the one axis that moves then.
struct Passage {
    test: usize,
    axis: usize,
    position: f64,
}

/// Tells several jumps as one motion of an axis where each comes as that axis moves and some come back at the same place of
/// it in another sweep; the jumps stay as what draws that motion.
pub(crate) fn tell_as_one(
    model: &LinearModel,
    (columns, regression): (&[Accepted], &Regression),
    findings: &mut Vec<Finding>,
    proof: &mut Option<CrossValidation>,
) {
    if findings.len() < 2 || !findings.iter().all(|finding| finding.single) {
        return;
    }
    let passages: Option<Vec<Passage>> = findings.iter().map(|finding| passage(model, finding)).collect();
    let Some(passages) = passages else { return };
    let axis = passages[0].axis;
    let places = || passages.iter().map(|passage| passage.position);
    let (low, high) = model.context.visited(axis);
    let reach = SAME_PLACE * (high - low);
    // sweeps begin and end at the same places
    let is_inside = |passage: &Passage| low + reach < passage.position && passage.position < high - reach;
    let comes_back = |one: &Passage, other: &Passage| {
        let is_near = (one.position - other.position).abs() < reach;
        one.test != other.test && is_near && is_inside(one) && is_inside(other)
    };
    let pairs = (0..passages.len())
        .flat_map(|one| (0..one).map(move |other| (one, other)))
        .filter(|&(one, other)| comes_back(&passages[one], &passages[other]))
        .count();
    if pairs == 0 || passages.iter().any(|passage| passage.axis != axis) {
        return;
    }
    // jumps that have nothing to do with one another meet so often
    let all_pairs = (passages.len() * (passages.len() - 1) / 2) as f64;
    let chance = (all_pairs * 2.0 * SAME_PLACE).min(1.0) * (2.0 * SAME_PLACE).powi(pairs as i32 - 1);
    let machine = model.context.machine();
    let entry = &machine.axes[axis];
    let own = entry.own_component().direction_index();
    // along the axis and tilts across it: what a part that lifts does
    let moved = match entry.kind {
        AxisKind::Rotary => {
            let tilts = (1..3).map(|k| Component::ALL[3 + (own + k) % 3]);
            [Component::ALL[own]].into_iter().chain(tilts).collect()
        }
        AxisKind::Linear => vec![Component::ALL[own]],
    };
    let component = |component| component_name(machine, &Outlet::Motion { axis, component });
    let cause = Cause {
        effect: UNKNOWN.name.into(),
        driver: Driver::Position,
        place: entry.name.clone(),
        components: moved.into_iter().map(component).collect(),
    };
    let file = |q: f64| entry.kind.to_file_unit(q);
    let range = RangeFound {
        axis: entry.name.clone(),
        from: file(places().fold(f64::MAX, f64::min)),
        to: file(places().fold(f64::MIN, f64::max)),
    };
    let jumps = std::mem::take(findings);
    let known = |jump: &Finding| jump.size.value / jump.size.sigma.max(f64::MIN_POSITIVE);
    let Some(surest) = jumps.iter().max_by(|a, b| known(a).total_cmp(&known(b))) else { return };
    let mut whole = surest.clone();
    whole.size.meaning = "surest of the jumps by which it comes and goes".into();
    whole.probability = (1.0 - chance).min(MOST_CERTAIN);
    whole.rivals = vec![(jumps[0].cause.clone(), 1.0 - whole.probability)];
    whole.effects = jumps.iter().flat_map(|jump| jump.effects.clone()).collect();
    whole.columns = jumps.iter().flat_map(|jump| jump.columns.clone()).collect();
    whole.gain = jumps.iter().map(|jump| jump.gain).sum();
    (whole.tests, whole.rms_um) = shows(model, columns, &whole.columns, regression);
    (whole.cause, whole.range, whole.single, whole.next_test) = (cause, Some(range), false, None);
    findings.push(whole);
    if let Some(proof) = proof {
        proof.findings = Vec::new();
    }
}

/// `None` where a jump comes between tests, or while no axis or several move.
fn passage(model: &LinearModel, jump: &Finding) -> Option<Passage> {
    let time_s = jump.effects.first()?.number("time")?;
    let context = model.context;
    let rows = |test: usize| model.residual_mm[test].len();
    let is_within = |test: &usize| {
        rows(*test) > 1 && (context.session_time_s(*test, 0)..=context.ends_at_s(*test)).contains(&time_s)
    };
    let test = (0..model.tests()).find(is_within)?;
    let [axis] = context.motion(test).moving[..] else { return None };
    let row = (0..rows(test)).find(|&row| context.session_time_s(test, row) >= time_s)?;
    Some(Passage { test, axis, position: context.motion(test).row(row)[axis] })
}
