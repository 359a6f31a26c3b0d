//! Location errors beside what was found, with what other explanations would make of them. It searches nothing.

use crate::diagnose::findings::size::form_error;
use crate::diagnose::findings::standing::Standing;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::prior_penalty::WIDER_SETUPS;
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::model::whitened::WhitenedData;
use crate::diagnose::preflight::doubts::{Place, strained_among};
use crate::diagnose::selection::selected::{Candidate, Search, SelectedEffect};
use crate::diagnose::validation::hidden_shifts::HiddenShift;
use crate::effects::{CandidateFamily, UNLISTED_BY_CURVES};
use crate::identify::{Fit, Quantity};
use crate::units::Measure;
use nalgebra::DMatrix;
use std::sync::Arc;

/// A location error before and after the effects were modelled, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    pub name: String,
    pub measure: Measure,
    pub before: f64,
    pub after: f64,
    /// With what rivals of the findings, and causes that the session cannot show, may have moved.
    pub sigma: f64,
    /// Without what unseen causes may have moved.
    pub seen_sigma: f64,
    pub determined: bool,
    /// Unseen causes that may have moved it by more than [`Moved::seen_sigma`], the largest first.
    pub hangs_on: Vec<HangsOn>,
}

/// Standard deviations beyond which a location error has moved.
pub const MOVED_SIGMAS: f64 = 2.0;

impl Moved {
    /// How far the findings move it, mm or rad.
    fn change(&self) -> f64 {
        (self.after - self.before).abs()
    }

    /// The same in standard deviations without what unseen causes may have moved.
    pub fn change_in_sigmas(&self) -> f64 {
        self.change() / self.seen_sigma.max(f64::MIN_POSITIVE)
    }

    /// Whether the findings move it by more than its uncertainty.
    pub fn is_moved(&self) -> bool {
        self.change() > MOVED_SIGMAS * self.seen_sigma
    }

    /// Whether unseen causes may have moved it as far.
    pub fn is_within_unseen(&self) -> bool {
        self.change() < self.sigma
    }
}

/// An unseen cause that moves a location error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HangsOn {
    /// Its place in the list of unseen causes.
    pub unseen: usize,
    /// Shift of the location error by one display unit of the cause, mm or rad.
    pub per_unit: f64,
}

/// Unseen causes named beside a location error, at most.
const MOST_NAMED: usize = 3;

/// Location errors of the fit with and without the effects that were found.
///
/// Their variance is that of the fit with these effects and what rivals of each add: `Σ w (σ² + (β − β₀)²)` over the causes that
/// the readings allow in its place, `w` their probabilities, `β₀` the value beside the chosen ones; the form error of each, as a
/// share of what modelling it moves; the same of the set that was not taken; and what unseen causes may have moved.
pub(crate) fn moved(
    fine: &LinearModel,
    families: &[CandidateFamily],
    fit: &Fit,
    (search, regression, covariance): (&Search, &Regression, &DMatrix<f64>),
    hidden: &[HiddenShift],
) -> Vec<Moved> {
    let unknowns = &fine.problem.unknowns;
    let mut variance: Vec<f64> = (0..unknowns.len()).map(|k| covariance[(k, k)]).collect();
    add_forms(fine, families, search, regression, &mut variance);
    let located = unknowns.iter().enumerate();
    located
        .filter(|(_, unknown)| matches!(unknown.quantity, Quantity::Location { .. }))
        .map(|(k, unknown)| {
            let seen = variance[k].max(0.0);
            let unseen: f64 = hidden.iter().map(|shift| shift.variance[k]).sum();
            Moved {
                name: unknown.label.clone(),
                measure: unknown.measure,
                before: fit.estimates[k].value,
                after: fit.estimates[k].value + regression.nuisance(k) * unknown.prior_sigma,
                sigma: (seen + unseen).sqrt() * unknown.prior_sigma,
                seen_sigma: seen.sqrt() * unknown.prior_sigma,
                determined: fit.estimates[k].determined,
                hangs_on: hangs_on(hidden, k, seen, unknown.prior_sigma),
            }
        })
        .collect()
}

/// The ball or bar that stands too far from its stated place beside what was found, in words.
pub(crate) fn strained_beside(
    fine: &LinearModel,
    fit: &Fit,
    (regression, covariance): (&Regression, &DMatrix<f64>),
) -> Option<String> {
    let setups = fine.problem.unknowns.iter().enumerate().filter(|(_, unknown)| unknown.quantity.is_setup());
    let places: Vec<Place> = setups
        .map(|(k, unknown)| {
            let fitted = (fit.estimates[k].value - unknown.prior_mean) / unknown.prior_sigma;
            let off = fitted + regression.nuisance(k);
            Place { unknown, off, variance: covariance[(k, k)], widened: WIDER_SETUPS }
        })
        .collect();
    strained_among(&places)
}

/// Unseen causes that may have moved an unknown by more than its variance without them.
fn hangs_on(hidden: &[HiddenShift], unknown: usize, seen: f64, prior_sigma: f64) -> Vec<HangsOn> {
    let listed = hidden.iter().filter_map(|shift| Some((shift.cause?, shift)));
    let mut large: Vec<(usize, &HiddenShift)> = listed.filter(|(_, shift)| shift.variance[unknown] > seen).collect();
    large.sort_by(|(_, a), (_, b)| b.variance[unknown].total_cmp(&a.variance[unknown]));
    let named = large.into_iter().take(MOST_NAMED);
    named.map(|(unseen, shift)| HangsOn { unseen, per_unit: shift.per_unit[unknown] * prior_sigma }).collect()
}

/// Adds to the variances of the unknowns, in units of their priors, what the form error of each effect and its rivals would
/// change.
fn add_forms(
    fine: &LinearModel,
    families: &[CandidateFamily],
    search: &Search,
    chosen: &Regression,
    variance: &mut [f64],
) {
    let own = variance.to_vec();
    if search.found.is_empty() {
        return;
    }
    let whitened = Arc::new(WhitenedData::new(fine, &search.noise_after, &fine.kept));
    let of_other = |other: &Regression, probability: f64| -> Vec<f64> {
        let covariance = other.covariance();
        let shift = |k: usize| other.nuisance(k) - chosen.nuisance(k);
        (0..own.len()).map(|k| probability * (covariance[(k, k)] - own[k] + shift(k).powi(2))).collect()
    };
    let mut add = |more: Vec<f64>| variance.iter_mut().zip(more).for_each(|(variance, more)| *variance += more);
    for (index, found) in search.found.iter().enumerate() {
        let with = |instead: Option<&Candidate>| {
            let of = |(k, other): (usize, &SelectedEffect)| -> Vec<Accepted> {
                let taken = if k == index { instead } else { Some(&other.chosen) };
                taken.into_iter().flat_map(Candidate::accepted).collect()
            };
            let of_found = search.found.iter().enumerate().flat_map(of);
            let columns: Vec<Accepted> = of_found.chain(search.beside.iter().cloned()).collect();
            Regression::on(whitened.clone(), &columns)
        };
        let without = with(None);
        // where a curve only describes, something else may be at work as well
        let form_error = match found.chosen.is_free() {
            true => UNLISTED_BY_CURVES.sqrt(),
            false => form_error(fine, &found.chosen.effect),
        };
        let of_form = |k: usize| (form_error * (chosen.nuisance(k) - without.nuisance(k))).powi(2);
        add((0..own.len()).map(of_form).collect());
        for (rival, probability) in Standing::of(fine, families, found).forms {
            add(of_other(&with(Some(rival)), probability));
        }
    }
    if let Some(other) = &search.other {
        add(of_other(&Regression::on(whitened.clone(), &other.columns), other.probability()));
    }
}
