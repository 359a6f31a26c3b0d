//! A robust fit of location errors and setups on few rows, quick enough to be made a hundred times. It knows no mistakes and no effects.

use crate::chain::Chain;
use crate::identify::{Options, Problem, Unknown, Until, Weighting, minimise_until, residual_mm};
use crate::session::{Session, Setups};
use crate::statistics::{rms, robust_sigma};

/// Residuals beyond so many robust sigmas count no more: single gross readings must not hide what a mistake does.
const CLIPPED: f64 = 15.0;

/// Offsets of balls and bars up to this are no matter of a mistake, mm: a bar may be stated ten spreads off its length.
pub(crate) const LEAST_SPREAD_MM: f64 = 0.02;

/// A ball or bar beyond so many spreads from its stated place counts as a misfit, in proportion: under all that sessions without a mistake
/// had, and short of [`MOST_STRAIN`].
const COUNTS_AS_MISFIT: f64 = 6.0;

/// A ball or bar so many spreads from its stated place stands elsewhere.
pub(crate) const MOST_STRAIN: f64 = 8.0;

/// Refits at a narrower robust scale, at most.
const REFITS: usize = 6;

/// A step that lowers the squares by a tenth of a per cent is the last: misfits are compared to 2 %. A session without a mistake
/// takes five to twenty steps; one that still goes down after twice as many has a mistake that this is not.
const QUICK: Until = Until { least_gain: 1e-3, steps: 40 };

/// First steps, up to one that does not halve the squares.
const FIRST: Until = Until { least_gain: 0.5, steps: 4 };

/// A robust scale that falls by less than this share has settled.
const SETTLED_SHARE: f64 = 0.7;

/// Largest offset of a ball or bar from its stated place, in its spreads as stated.
pub fn strain(problem: &Problem, values: &[f64], widened: f64) -> f64 {
    let setups = problem.unknowns.iter().zip(values).filter(|(unknown, _)| unknown.quantity.is_setup());
    setups
        .map(|(unknown, value)| (value / (unknown.prior_sigma / widened).max(LEAST_SPREAD_MM)).abs())
        .fold(0.0, f64::max)
}

/// A robust fit on few rows.
pub(crate) struct Refit {
    /// Rms residual, µm; every reading counts, but none for more than so many sigmas.
    pub(crate) misfit_um: f64,
    /// Largest offset of a ball or bar, in its spreads.
    pub(crate) strain: f64,
    /// What was fitted.
    pub(crate) unknowns: Vec<Unknown>,
    /// Values of the unknowns, mm or rad; behind them those of the linear axes' budget.
    pub(crate) values: Vec<f64>,
    pub(crate) residual_mm: Vec<Vec<f64>>,
}

/// Fits a session robustly: from the prior means, or from `near` where that lies nearer.
pub(crate) fn refit(session: &Session, near: Option<&[f64]>) -> Option<Refit> {
    refit_up_to(session, near, f64::INFINITY)
}

/// The same, but for what first steps leave where that is more than so much, µm.
pub(crate) fn refit_up_to(session: &Session, near: Option<&[f64]>, most_um: f64) -> Option<Refit> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let unknowns = Options::default().unknowns(session, &setups);
    let problem = Problem::new(session, &chain, &setups, unknowns.clone()).ok()?;
    let means = problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect();
    let starts = near.filter(|near| near.len() == problem.unknowns.len()).map(<[f64]>::to_vec);
    let (mut scale, mut values) = [means]
        .into_iter()
        .chain(starts)
        .map(|values| (scale_of(&residual_mm(&problem, &values)), values))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut residual_mm = Vec::new();
    let mut refits = REFITS;
    if most_um.is_finite() {
        let first = minimise_until(&problem, &values, &Weighting::Huber { scale_mm: scale }, FIRST);
        (values, residual_mm) = (first.values, first.residual_mm);
        let is_hopeless = 1e3 * robust_rms_mm(&residual_mm) > most_um;
        refits = if is_hopeless { 0 } else { REFITS };
    }
    for _ in 0..refits {
        let solution = minimise_until(&problem, &values, &Weighting::Huber { scale_mm: scale }, QUICK);
        (values, residual_mm) = (solution.values, solution.residual_mm);
        let next = scale_of(&residual_mm);
        let settled = next > SETTLED_SHARE * scale;
        scale = next;
        if settled {
            break;
        }
    }
    // offsets of balls far beyond their spreads are a misfit as well, and so are location errors that no machine has
    let strain = strain(&problem, &values, 1.0);
    let strained = 1.0 + (strain / COUNTS_AS_MISFIT - 1.0).max(0.0);
    let displaced = 1.0 + (displacement(&problem, &values) - 1.0).max(0.0);
    let misfit_um = 1e3 * robust_rms_mm(&residual_mm) * strained * displaced;
    Some(Refit { misfit_um, strain, unknowns, values, residual_mm })
}

/// Robust residual of a session by its nominal machine, mm.
pub(crate) fn nominal_mm(session: &Session) -> Option<f64> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, Vec::new()).ok()?;
    Some(robust_rms_mm(&residual_mm(&problem, &[])))
}

/// Largest location error, in units of its widest plausible size.
fn displacement(problem: &Problem, values: &[f64]) -> f64 {
    let errors = problem.unknowns.iter().zip(values).filter(|(unknown, _)| !unknown.quantity.is_setup());
    errors.map(|(unknown, value)| ((value - unknown.prior_mean) / unknown.prior_sigma).abs()).fold(0.0, f64::max)
}

/// Rms residual, each clipped at [`CLIPPED`] robust sigmas, mm.
pub(crate) fn robust_rms_mm(residual_mm: &[Vec<f64>]) -> f64 {
    let limit = CLIPPED * scale_of(residual_mm);
    let finite = residual_mm.iter().flatten().filter(|value| value.is_finite());
    rms(finite.map(|value| value.clamp(-limit, limit)))
}

/// Robust scale of residuals, mm.
fn scale_of(residual_mm: &[Vec<f64>]) -> f64 {
    robust_sigma(residual_mm.iter().flatten().copied()).max(1e-4)
}
