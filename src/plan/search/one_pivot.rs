//! The best plan from one pivot setup: places ranked by what all their setups would tell, the first few tried. Collisions are checked by `greedy`.

use crate::plan::context::choice::{Choice, Reached};
use crate::plan::context::evaluation::{Evaluation, SAME_WORTH};
use crate::plan::information::posterior::Posterior;
use crate::plan::places::candidate::Candidate;

/// Places that are tried.
const TRIED: usize = 6;
/// Setups of a place whose information is added up for its rank.
const RANKED_BY: usize = 16;

impl<'a> Evaluation<'a> {
    /// Tests that all use one pivot setup.
    pub(crate) fn one_pivot_choice(&mut self) -> Choice<'a> {
        let list: &'a [Candidate] = &self.context.all.list;
        let mut by_site: Vec<Vec<&'a Candidate>> = vec![Vec::new(); self.context.all.sites.len()];
        list.iter().for_each(|candidate| by_site[candidate.site].push(candidate));
        let mut ranked: Vec<(f64, usize)> = (0..by_site.len())
            .filter(|&site| !by_site[site].is_empty())
            .map(|site| (self.promise(site, &by_site[site]), site))
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(Reached, Choice<'a>)> = None;
        for &(_, site) in ranked.iter().take(TRIED) {
            let choice = self.greedy(by_site[site].iter().copied());
            let reached = self.reached(&choice);
            let better = |other: &Reached| {
                let more = reached.determined.cmp(&other.determined);
                let quicker = reached.worth < other.worth + SAME_WORTH && reached.cost < other.cost;
                more.is_gt() || more.is_eq() && (reached.worth < other.worth - SAME_WORTH || quicker)
            };
            if best.as_ref().is_none_or(|(other, _)| better(other)) {
                best = Some((reached, choice));
            }
        }
        best.map_or_else(Choice::default, |(_, choice)| choice)
    }

    /// What a place's setups would tell if all were clear: Σ ln max(σ², goal²), smaller is better.
    fn promise(&self, site: usize, candidates: &[&'a Candidate]) -> f64 {
        let mut known = self.promises.borrow_mut();
        let variances = known.entry(site).or_insert_with(|| {
            let mut posterior = Posterior::before_with_loose_setups(&self.context.unknowns);
            let axes: std::collections::BTreeSet<usize> = candidates.iter().map(|candidate| candidate.axis).collect();
            for axis in axes {
                let mine: Vec<_> = candidates.iter().filter(|candidate| candidate.axis == axis).collect();
                let step = mine.len().div_ceil(RANKED_BY / 2).max(1);
                mine.iter().step_by(step).for_each(|candidate| posterior.add(&self.entry(candidate, None).block));
            }
            posterior.variances()
        });
        self.worth(variances)
    }
}
