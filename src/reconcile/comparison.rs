//! The comparison: which values disagree, which causes do away with it, which test decides.

use nalgebra::DVector;

use super::chance::one_of;
use super::compare::{Selection, select, sizes};
use super::deciding::{DecidingTest, deciding};
use super::prepared::Prepared;
use super::verdict::{Difference, Disagreement, Verdict};
use crate::statistics::Fitted;

/// χ² by which a cause may do worse than the circle that it replaces: 1 % of one degree of freedom.
const REPLACED_CHI2: f64 = 6.63;
/// A cause that moves the disagreements by less than this many standard deviations per µm, mm or as a whole does not act.
const NO_EFFECT: f64 = 1e-3;

/// What several claims say together.
#[derive(Debug, Clone)]
pub struct Reconciliation {
    pub differences: Vec<Difference>,
    pub chi2: f64,
    pub degrees_of_freedom: usize,
    pub disagreements: Vec<Disagreement>,
    /// Of every cause, those named first, then by what they leave.
    pub verdicts: Vec<Verdict>,
    pub deciding: Option<DecidingTest>,
}

impl Prepared {
    /// Compares values.
    pub fn judge(&self, values: &DVector<f64>) -> Reconciliation {
        let disagreement = self.frame.disagreement(values);
        let directions: Vec<DVector<f64>> = self.circles.iter().map(|(_, direction)| direction.clone()).collect();
        let selection = select(&disagreement, &directions, &[], self.threshold);
        let disagreements = self.disagreements(&disagreement, &selection);
        let mut verdicts: Vec<Verdict> = match selection.picks.is_empty() {
            true => Vec::new(),
            false => (0..self.causes.len()).map(|cause| self.verdict(cause, values, &directions, &selection)).collect(),
        };
        verdicts.sort_by(|a, b| {
            let key = |verdict: &Verdict| (!verdict.is_named(), verdict.leaves);
            key(a).cmp(&key(b)).then(a.chi2.total_cmp(&b.chi2))
        });
        let deciding = deciding(self, values, &verdicts);
        Reconciliation {
            differences: self.differences(values),
            chi2: disagreement.norm_squared(),
            degrees_of_freedom: self.frame.degrees_of_freedom,
            disagreements,
            verdicts,
            deciding,
        }
    }

    fn disagreements(&self, disagreement: &DVector<f64>, selection: &Selection) -> Vec<Disagreement> {
        let picked: Vec<&DVector<f64>> = selection.picks.iter().map(|pick| &self.circles[*pick].1).collect();
        let found = sizes(disagreement, &picked).unwrap_or_default();
        let one = |((pick, alike), size): ((&usize, &Vec<usize>), Fitted)| {
            let circle = self.circles[*pick].0;
            let moved = self.stacked(&self.causes[circle], &DVector::zeros(self.names.len())) * size.value;
            let sigma = |k: usize| self.covariance[(k, k)].sqrt();
            // what moves by less than its own uncertainty is not part of it
            let moves = (0..self.names.len()).filter(|k| moved[*k].abs() > sigma(*k));
            Disagreement {
                circle,
                size,
                moves: moves.map(|k| (self.names[k].clone(), moved[k])).collect(),
                alike: alike.iter().map(|k| self.circles[*k].0).collect(),
            }
        };
        selection.picks.iter().zip(&selection.alike).zip(found).map(one).collect()
    }

    fn verdict(&self, cause: usize, values: &DVector<f64>, circles: &[DVector<f64>], before: &Selection) -> Verdict {
        let of = &self.causes[cause];
        let stacked = self.stacked(of, values);
        let direction = self.frame.disagreement(&stacked);
        let plain = self.frame.disagreement(values);
        let after = match of.limit {
            Some(_) => select(&plain, circles, &[&direction], self.threshold),
            None => select(&self.frame.disagreement(&(values + &stacked)), circles, &[], self.threshold),
        };
        let size = of.limit.filter(|_| direction.norm() > NO_EFFECT).and_then(|_| {
            let mut model = vec![&direction];
            model.extend(after.picks.iter().map(|pick| &circles[*pick]));
            sizes(&plain, &model).and_then(|found| found.first().copied())
        });
        let is_plausible = match (of.limit, size) {
            (Some(limit), Some(Fitted { value: size, sigma })) => size.abs() <= limit + 2.0 * sigma && sigma <= limit,
            (Some(_), None) => false,
            (None, _) => true,
        };
        let replaced = before.picks.len().saturating_sub(after.picks.len());
        // each circle replaced may cost what chance costs one degree of freedom
        let does_as_well = replaced > 0 && after.chi2 <= before.chi2 + REPLACED_CHI2 * replaced as f64;
        let acts = direction.norm() > NO_EFFECT;
        let gone = |k: &usize| does_as_well && acts && !after.picks.contains(&before.picks[*k]);
        Verdict {
            cause,
            size,
            explains: (0..before.picks.len()).filter(gone).collect(),
            leaves: after.picks.len(),
            chi2: after.chi2,
            is_plausible,
        }
    }

    fn differences(&self, values: &DVector<f64>) -> Vec<Difference> {
        let mut pairs = Vec::new();
        for (k, name) in self.names.iter().enumerate() {
            pairs.extend((k + 1..self.names.len()).filter(|other| self.names[*other] == *name).map(|other| (k, other)));
        }
        let beyond = one_of(pairs.len()).sqrt();
        let claim = |k: usize| self.first.iter().rposition(|first| *first <= k).unwrap_or(0);
        let scatter = |k: usize| self.budgets[claim(k)].repeatability[k - self.first[claim(k)]];
        let difference = |(a, b): (usize, usize)| {
            let value = values[b] - values[a];
            let sigma = (self.covariance[(a, a)] + self.covariance[(b, b)]).sqrt();
            Difference {
                name: self.names[a].clone(),
                claims: [claim(a), claim(b)],
                value,
                repeatability: (scatter(a) + scatter(b)).sqrt(),
                sigma,
                is_beyond: value.abs() > beyond * sigma,
            }
        };
        pairs.into_iter().map(difference).collect()
    }
}
