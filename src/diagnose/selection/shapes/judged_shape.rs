//! A shape of a family judged at a stage, and what refined shapes must gain. It refines nothing.

use crate::diagnose::model::last_shape::LastShape;
use crate::diagnose::model::regression::Regression;
use crate::diagnose::selection::screening::candidates::family_terms;
use crate::diagnose::selection::selected::Candidate;
use crate::effects::CandidateFamily;
use crate::machine::Effect;

/// Log evidence that a refined parameter costs.
pub(crate) const PARAMETER_COST: f64 = 1.5;

/// Terms of a vibration with knots beyond which they are too many: one direction in some fifty tests of half a minute, every
/// five seconds, has half as many, and their covariance is that many squared.
const MOST_TERMS: usize = 2400;

/// A shape of a family, judged; `cost` is taken off its evidence. Its columns are not worked out.
pub fn judged(
    regression: &Regression,
    family: &CandidateFamily,
    index: usize,
    effect: Effect,
    cost: f64,
    last: &mut LastShape,
) -> Option<Candidate> {
    let mut terms = family_terms(regression.model.context.machine(), family, &effect);
    let profiles = regression.model.profiles(&effect).ok()?;
    if effect.parameter("every").is_some() {
        // knots beyond the end of a recording; no shape of a grid has knots, so none is judged elsewhere with them
        terms.retain(|term| term.test.is_none_or(|test| !profiles[term.function][test].is_empty()));
        if terms.len() > MOST_TERMS {
            return None;
        }
    }
    let judgement = regression.judge_shape((index, &effect), (&profiles, &terms), family.plausible, last);
    let log_odds = judgement.log_evidence - cost;
    Some(Candidate { family: index, effect, terms, columns: Vec::new(), judgement, log_odds })
}
