//! The cheapest part of a choice that still tells what is demanded. It looks for no tests of its own.

use std::cmp::Reverse;

use crate::plan::context::choice::{Choice, Entry};
use crate::plan::context::evaluation::Evaluation;
use crate::plan::information::block::Block;
use crate::plan::information::fitted::{Fitted, fitted};
use crate::plan::information::posterior::Posterior;
use crate::plan::places::drive::Drive;

/// How much worse than the reference an error may be that does not reach the goal.
const AS_GOOD: f64 = 1.02;
/// Parts that are looked at before the best so far is taken.
const MOST_PARTS: usize = 400;

/// What a part must tell of one wanted error.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Least {
    /// Greatest variance with pivots and bars unknown, mm² or rad².
    variance: f64,
    /// Greatest share of priors in a fit.
    prior_share: f64,
}

/// What a part must tell: of each wanted error that the reference sees.
pub(crate) struct Demand(Vec<Option<Least>>);

impl Demand {
    /// Number of errors of which something is demanded.
    pub fn errors(&self) -> usize {
        self.0.iter().flatten().count()
    }

    /// By how much variances miss it: Σ ln (σ/σ demanded) over those that are too large; 0 when it is met.
    pub fn open(&self, variances: &[f64]) -> f64 {
        let over = |(variance, least): (&f64, &Option<Least>)| {
            least.map_or(0.0, |least| 0.5 * (variance / (least.variance * (1.0 + 1e-9))).ln().max(0.0))
        };
        variances.iter().zip(&self.0).map(over).sum()
    }

    /// By how much tests leave more to priors than it allows: Σ of the shares that are too large.
    pub fn open_by_priors(&self, evaluation: &Evaluation, blocks: Vec<&Block>) -> f64 {
        let over = |(fit, least): (Fitted, &Option<Least>)| {
            least.map_or(0.0, |least| (fit.prior_share - least.prior_share - 1e-9).max(0.0))
        };
        fitted(&evaluation.context.unknowns, &blocks).into_iter().zip(&self.0).map(over).sum()
    }
}

/// A branch of the search: tests decided upon so far.
struct Branch {
    kept: Vec<usize>,
    posterior: Posterior,
    minutes: f64,
}

impl<'a> Evaluation<'a> {
    /// The goals as they are, where they are out of reach what a reference reaches, and all that the reference determines.
    pub(crate) fn demand(&self, reference: &Choice<'a>) -> Demand {
        let blocks: Vec<&Block> = reference.chosen.iter().map(|&k| &*reference.entries[k].block).collect();
        let mut posterior = Posterior::before_with_loose_setups(&self.context.unknowns);
        blocks.iter().for_each(|block| posterior.add(block));
        let variances = posterior.variances();
        let of = |(k, fit): (usize, Fitted)| {
            let goal = self.goals[k].powi(2);
            (fit.is_determined() || variances[k] <= goal).then(|| Least {
                variance: goal.max(variances[k] * AS_GOOD * AS_GOOD),
                prior_share: match fit.is_determined() {
                    true => self.context.settings.sure_share.max(fit.prior_share),
                    false => 1.0,
                },
            })
        };
        Demand(fitted(&self.context.unknowns, &blocks).into_iter().enumerate().map(of).collect())
    }

    /// The cheapest part that meets a demand; `None` when the whole does not.
    pub(crate) fn cheapest_part(&self, choice: &Choice<'a>, demand: &Demand) -> Option<Choice<'a>> {
        let mut tests: Vec<&Entry<'a>> = choice.chosen.iter().map(|&k| &choice.entries[k]).collect();
        // what costs most is left out first
        tests.sort_by_key(|entry| {
            let same = |other: &&&Entry| other.candidate.site == entry.candidate.site;
            let beside = tests_beside(choice, same);
            (beside, Reverse((self.run_minutes(entry) * 1e3) as i64))
        });
        let mut search = Parts { evaluation: self, tests: &tests, demand, best: None, looked: 0 };
        let whole = Branch {
            kept: Vec::new(),
            posterior: Posterior::before_with_loose_setups(&self.context.unknowns),
            minutes: 0.0,
        };
        search.decide(0, whole);
        let (_, kept) = search.best?;
        let in_order =
            choice.chosen.iter().filter(|&&k| kept.iter().any(|&t| std::ptr::eq(tests[t], &choice.entries[k])));
        let entries: Vec<Entry<'a>> = in_order.map(|&k| choice.entries[k].clone()).collect();
        Some(Choice { chosen: (0..entries.len()).collect(), entries })
    }
}

/// Number of tests from one pivot.
fn tests_beside(choice: &Choice, same: impl Fn(&&&Entry) -> bool) -> usize {
    choice.chosen.iter().map(|&k| &choice.entries[k]).filter(|entry| same(&entry)).count()
}

/// The search for a part.
struct Parts<'d, 'a> {
    evaluation: &'d Evaluation<'a>,
    tests: &'d [&'d Entry<'a>],
    demand: &'d Demand,
    /// Minutes and indices of tests.
    best: Option<(f64, Vec<usize>)>,
    looked: usize,
}

impl Parts<'_, '_> {
    /// Decides upon the test at `next` and all after it.
    fn decide(&mut self, next: usize, branch: Branch) {
        let is_dearer = |minutes: f64| self.best.as_ref().is_some_and(|(least, _)| minutes >= *least - 1e-9);
        if is_dearer(branch.minutes) || self.looked >= MOST_PARTS {
            return;
        }
        let Some(test) = self.tests.get(next) else {
            if self.is_enough(&branch.posterior, &branch.kept) {
                self.best = Some((branch.minutes, branch.kept));
            }
            return;
        };
        // without it, unless all that may still come cannot make up for it
        if !matches!(test.candidate.drive, Drive::Circle(..)) {
            self.looked += 1;
            let mut with_rest = branch.posterior.clone();
            self.tests[next + 1..].iter().for_each(|rest| with_rest.add(&rest.block));
            if self.is_sharp(&with_rest) {
                let Branch { kept, posterior, minutes } = &branch;
                self.decide(next + 1, Branch { kept: kept.clone(), posterior: posterior.clone(), minutes: *minutes });
            }
        }
        let Branch { mut kept, mut posterior, minutes } = branch;
        let minutes = minutes + self.evaluation.cost(test, &posterior);
        kept.push(next);
        posterior.add(&test.block);
        self.decide(next + 1, Branch { kept, posterior, minutes });
    }

    fn is_sharp(&self, posterior: &Posterior) -> bool {
        self.demand.open(&posterior.variances()) == 0.0
    }

    fn is_enough(&self, posterior: &Posterior, kept: &[usize]) -> bool {
        let blocks: Vec<&Block> = kept.iter().map(|&k| &*self.tests[k].block).collect();
        self.is_sharp(posterior) && self.demand.open_by_priors(self.evaluation, blocks) == 0.0
    }
}
