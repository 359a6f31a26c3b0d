//! How far the fit had to pull balls, bars and location errors from what was stated of them. It fits nothing.

use super::linear_model::LinearModel;
use crate::identify::{Options, Quantity, Unknown};
use crate::session::{Session, Setups};

/// Setups are given so many times their stated spread: a pivot that a knock moved by three sigmas is no missing physics.
pub(crate) const WIDER_SETUPS: f64 = 2.5;

/// What is fitted anyway beside effects.
pub(crate) fn fitted_anyway(session: &Session, options: &Options, setups: &Setups) -> Vec<Unknown> {
    let mut unknowns = options.unknowns(session, setups);
    for unknown in unknowns.iter_mut().filter(|unknown| unknown.quantity.is_setup()) {
        unknown.prior_sigma *= WIDER_SETUPS;
    }
    unknowns
}

/// Degrees of freedom of the t distribution of what was stated: one cup set carelessly is far off, and no sign of physics.
const FREEDOM: f64 = 8.0;

/// Penalties by ball, bar and location error.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PriorPenalty(Vec<f64>);

impl PriorPenalty {
    /// Of unknowns that a fit changed by so many of their priors.
    pub(crate) fn of(model: &LinearModel, changed: impl Fn(usize) -> f64) -> PriorPenalty {
        let unknowns = &model.problem.unknowns;
        // by ball, bar or location error: sum of squares and number of coordinates
        let mut things: Vec<(Quantity, f64, f64)> = Vec::new();
        for (k, unknown) in unknowns.iter().enumerate() {
            let pull = model.beyond[k] + changed(k);
            let thing = match unknown.quantity {
                Quantity::Pivot { setup, .. } => Quantity::Pivot { setup, coordinate: 0 },
                Quantity::SpindleBall { setup, .. } => Quantity::SpindleBall { setup, coordinate: 0 },
                other => other,
            };
            match things.iter_mut().find(|(other, ..)| *other == thing) {
                Some((_, squares, count)) => (*squares, *count) = (*squares + pull * pull, *count + 1.0),
                None => things.push((thing, pull * pull, 1.0)),
            }
        }
        let penalty = |squares: f64, count: f64| (FREEDOM + count) * (squares / FREEDOM).ln_1p();
        PriorPenalty(things.into_iter().map(|(_, squares, count)| penalty(squares, count)).collect())
    }

    /// Twice the negative log likelihood of what was stated, less a constant.
    pub(crate) fn misfit(&self) -> f64 {
        self.0.iter().sum()
    }

    /// Fall of the misfit to that of others, without what falls most: one thing alone may simply not be where it was stated to be.
    pub(crate) fn shared_relief(&self, after: &PriorPenalty) -> f64 {
        let falls = || self.0.iter().zip(&after.0).map(|(before, after)| before - after);
        falls().sum::<f64>() - falls().fold(0.0, f64::max)
    }
}
