//! Whether linear axes as good as the machine file states may look like a finding: every guideway is a little bent. It finds nothing.

use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::selection::naming::cause;
use crate::diagnose::selection::selected::Search;
use crate::effects::{Signature, is_a};
use crate::identify::Problem;
use crate::machine::{AxisKind, Effect};
use crate::statistics::{NoiseModel, probability_of};

/// Shapes that a search tries, about: a few thousand.
const SHAPES_TRIED: f64 = 3000.0;

/// Leaves to the linear axes what they explain as well within their class: it is taken out of what was found, and their columns stand
/// beside the rest. In words, what that is.
pub(crate) fn leave_to_linear_axes(model: &LinearModel, search: &mut Search) -> Vec<String> {
    if search.found.is_empty() {
        return Vec::new();
    }
    let class = WithinClass::of(model);
    let columns: Vec<Vec<Accepted>> = search.found.iter().map(|found| found.chosen.accepted().collect()).collect();
    let left = |k: usize| class.left_of(model, &search.noise_after, (&search.found[k].chosen.effect, k), &columns);
    // as probable as what is left of its evidence makes one of all shapes that were tried
    let share = |evidence: f64| probability_of(evidence - SHAPES_TRIED.ln());
    let shares: Vec<f64> = (0..columns.len()).map(|k| left(k).map_or(1.0, share)).collect();
    let mut warnings = Vec::new();
    let mut stays = Vec::new();
    for (found, share) in std::mem::take(&mut search.found).into_iter().zip(shares) {
        if share < 0.5 {
            let named = cause(model.context.machine(), &found.chosen, &[]);
            warnings.push(format!(
                "what looks like {} at {} is no more than linear axes of their class in the machine file leave: state a better class if \
                 they are better, or measure them",
                named.effect, named.place
            ));
        } else {
            stays.push(found);
        }
    }
    search.found = stays;
    if !warnings.is_empty() {
        search.beside = class.columns;
    }
    warnings
}

/// Squareness and displacements of the linear axes by their class, as columns of one standard deviation each.
struct WithinClass {
    columns: Vec<Accepted>,
}

impl WithinClass {
    /// None where the readings are no lengths, or the class is exact.
    fn of(model: &LinearModel) -> WithinClass {
        let session = model.context.session();
        let budget = &session.machine.linear_axes;
        let unknowns = model.problem.unknowns.clone();
        let asked = unknowns.len();
        let is_of_lengths = model.has_sweeps() && !session.has_parts();
        let problem = Problem::new(session, model.context.chain(), model.problem.setups, unknowns);
        let columns = match problem.ok().filter(|_| is_of_lengths).map(|problem| problem.with_linear_axes(budget)) {
            Some(problem) => (asked..problem.unknowns.len()).map(|k| model.unknown(&problem, k)).collect(),
            None => Vec::new(),
        };
        WithinClass { columns: columns.into_iter().map(|column| Accepted { column, prior: 1.0 }).collect() }
    }

    /// Log evidence that an effect keeps beside the others and beside linear axes within their class; `None` for what is itself an
    /// error of a linear axis, but for its straightness: of that the class tells how much is no wear.
    fn left_of(
        &self,
        model: &LinearModel,
        noise: &[NoiseModel],
        (effect, own): (&Effect, usize),
        columns: &[Vec<Accepted>],
    ) -> Option<f64> {
        let machine = model.context.machine();
        let is_of_slide = effect.place.axis().is_some_and(|axis| machine.axes[axis].kind == AxisKind::Linear);
        let is_other_error = is_of_slide && !is_a(&effect.kind, Signature::Straightness);
        if self.columns.is_empty() || is_other_error || columns[own].is_empty() {
            return None;
        }
        let others = (0..columns.len()).filter(|k| *k != own).flat_map(|k| columns[k].iter().cloned());
        let beside: Vec<Accepted> = others.chain(self.columns.iter().cloned()).collect();
        let plausible = columns[own].iter().map(|one| one.prior).fold(0.0, f64::max);
        let own: Vec<_> = columns[own].iter().map(|one| one.column.clone()).collect();
        Some(Regression::new(model, noise, &beside, &model.kept).judge(&own, plausible).log_evidence)
    }
}
