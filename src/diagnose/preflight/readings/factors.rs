//! Recordings that have one factor too many, whichever they are: the readings say which. Whether they have is for others to judge.
//!
//! With the deviations d of some tests times 1 + s, all readings leave `s²zᵀNz − 2s·zᵀr` more squares once balls, bars and errors have
//! followed ([`Sums`]); z is 1 for a test that is struck. For a given s one test after the other joins them, the one that
//! takes off most first.

use super::figures::{Figure, Linearised, Sums};
use super::processed::deviations_mm;
use super::scaled::{FACTORS, is_known, is_near_one, with_factor};
use crate::diagnose::preflight::suspicion::{RARELY, SOMETIMES, Suspicion};
use crate::diagnose::selection::shapes::judged_shape::PARAMETER_COST;
use crate::session::Session;
use statrs::function::beta::ln_beta;

/// Share of the squares that one recording more, or one less, must take off: its misfit is then lower by 2 %, below which
/// two misfits say the same.
const LEAST_GAIN: f64 = 0.04;

/// Recordings whose own factors are tried for others too: those that take off most.
const OWN_FACTORS: usize = 3;

/// Rounds in which a factor and the recordings that have it are found by turns.
const ROUNDS: usize = 4;

/// Beta distribution of the share of files that were converted wrongly, where some but not all were: one in four on average, any share
/// is possible. Which is which is not known where nearly as many have the factor as have not.
const STRUCK: [f64; 2] = [1.0, 3.0];

/// Odds from which two choices of recordings that leave the same are told as equally likely.
const AS_LIKELY: f64 = 0.5;

/// Deviations of some tests, whichever they are, with a factor undone that one conversion left on them; left as it is, all of them leave
/// so many squares, in units of the noise.
pub(crate) fn scaled_in_some(session: &Session, linearised: &Linearised, squares: f64) -> Vec<Suspicion> {
    let deviations = session.tests.iter().enumerate().map(|(test, of)| Some((test, deviations_mm(of)?)));
    let Some(figures) = deviations.map(|one| Some(Figure { by_test: vec![one?] })).collect::<Option<Vec<_>>>() else {
        return Vec::new();
    };
    let sums = linearised.sums(&figures);
    let choice = Choice { sums: &sums, squares };
    let of_known = FACTORS.iter().filter_map(|(factor, _)| {
        let made = choice.struck(size_of(*factor));
        (!made.is_empty()).then_some((*factor, made))
    });
    let mut found: Vec<(f64, Vec<usize>)> = of_known.collect();
    found.extend(choice.own_factors().into_iter().filter(|(factor, _)| !is_known(*factor) && !is_near_one(*factor)));
    let mut list: Vec<Suspicion> = Vec::new();
    for (factor, struck) in found {
        // a factor of all but some is as well the inverse of it in those
        let others: Vec<usize> = (0..session.tests.len()).filter(|test| !struck.contains(test)).collect();
        let odds = (log_prior(others.len(), struck.len()) - log_prior(struck.len(), others.len())).exp();
        let is_as_likely = odds > AS_LIKELY;
        list.extend(suspected(session, factor, &struck));
        list.extend(is_as_likely.then(|| suspected(session, factor.recip(), &others)).flatten());
    }
    list.extend(from_a_time_on(session, &choice));
    list
}

/// A factor of its own from a time of the session on, or until then, where it takes off most: a gauge calibrated anew, a setting of its software.
/// Fewer recordings were wrong rather than more.
fn from_a_time_on(session: &Session, choice: &Choice) -> Option<Suspicion> {
    let mut order: Vec<usize> = (0..session.tests.len()).collect();
    order.sort_by(|&a, &b| session.tests[a].started_at_s.total_cmp(&session.tests[b].started_at_s));
    let Sums { normal, right } = choice.sums;
    let chances = order.len().saturating_sub(1) as f64;
    // from the last test on one joins after the other
    let (mut square, mut linear) = (0.0, 0.0);
    let mut told: Vec<(f64, f64, usize)> = Vec::new();
    for begin in (1..order.len()).rev() {
        let test = order[begin];
        let with_later: f64 = order[begin + 1..].iter().map(|&later| normal[(test, later)]).sum();
        square += normal[(test, test)] + 2.0 * with_later;
        linear += right[test];
        let size = linear / square;
        told.push((Choice::left(size, (square, linear)), size, begin));
    }
    let told = told.into_iter().filter(|(left, size, _)| left.is_finite() && *size > -1.0);
    let (left, size, begin) = told.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let factor = (1.0 + size).recip();
    let (earlier, later) = order.split_at(begin);
    let (struck, factor) = if later.len() > earlier.len() { (earlier, factor.recip()) } else { (later, factor) };
    let is_told = -left > LEAST_GAIN * choice.squares && factor.is_finite() && !is_near_one(factor);
    let found = is_told.then(|| with_factor(session, struck, factor))?;
    Some(Suspicion { log_figures: -PARAMETER_COST - chances.ln(), weight: RARELY, ..found })
}

/// What is added to deviations, as a share of them, to undo a factor.
fn size_of(factor: f64) -> f64 {
    factor.recip() - 1.0
}

/// Logarithm of the probability that just these files are struck, by how many they are.
fn log_prior(struck: usize, others: usize) -> f64 {
    let [a, b] = STRUCK;
    ln_beta(a + struck as f64, b + others as f64) - ln_beta(a, b)
}

fn suspected(session: &Session, factor: f64, struck: &[usize]) -> Option<Suspicion> {
    let others = session.tests.len() - struck.len();
    if struck.is_empty() || others == 0 {
        return None;
    }
    let found = with_factor(session, struck, factor);
    let figures = if is_known(factor) { 0.0 } else { PARAMETER_COST };
    Some(Suspicion { log_figures: log_prior(struck.len(), others) - figures, weight: SOMETIMES, ..found })
}

/// Which recordings have a factor.
struct Choice<'s> {
    sums: &'s Sums,
    squares: f64,
}

impl Choice<'_> {
    /// Squares more with a share of the deviations of some tests added to them, by their zᵀNz and zᵀr.
    fn left(size: f64, (square, linear): (f64, f64)) -> f64 {
        size * (size * square - 2.0 * linear)
    }

    /// zᵀNz and zᵀr.
    fn of(&self, struck: &[usize]) -> (f64, f64) {
        let pairs = struck.iter().flat_map(|&one| struck.iter().map(move |&other| (one, other)));
        (pairs.map(|pair| self.sums.normal[pair]).sum(), struck.iter().map(|&test| self.sums.right[test]).sum())
    }

    /// The tests in which undoing a factor leaves least, by one test more or less at a time.
    fn struck(&self, size: f64) -> Vec<usize> {
        let Sums { normal, right } = self.sums;
        let tests = right.len();
        let mut is_struck = vec![false; tests];
        // Nz
        let mut with_struck = vec![0.0; tests];
        let (mut of, mut left) = ((0.0, 0.0), 0.0);
        let sign_of = |is_struck: bool| if is_struck { -1.0 } else { 1.0 };
        for _ in 0..2 * tests {
            let toggled = (0..tests).map(|test| {
                let sign = sign_of(is_struck[test]);
                let square = of.0 + 2.0 * sign * with_struck[test] + normal[(test, test)];
                let of = (square, of.1 + sign * right[test]);
                (Self::left(size, of), of, test)
            });
            let Some((less, next, test)) = toggled.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            if left - less < LEAST_GAIN * (self.squares + left).max(0.0) {
                break;
            }
            let sign = sign_of(is_struck[test]);
            with_struck.iter_mut().enumerate().for_each(|(other, sum)| *sum += sign * normal[(other, test)]);
            is_struck[test] = !is_struck[test];
            (of, left) = (next, less);
        }
        (0..tests).filter(|&test| is_struck[test]).collect()
    }

    /// Factors that single recordings want, with all that have them.
    fn own_factors(&self) -> Vec<(f64, Vec<usize>)> {
        let tests = self.sums.right.len();
        let mut alone: Vec<(f64, f64)> = (0..tests)
            .map(|test| {
                let size = self.sums.right[test] / self.sums.normal[(test, test)];
                (Self::left(size, self.of(&[test])), size)
            })
            .filter(|(left, size)| left.is_finite() && *size > -1.0)
            .collect();
        alone.sort_by(|a, b| a.0.total_cmp(&b.0));
        alone.truncate(OWN_FACTORS);
        let mut found: Vec<(f64, Vec<usize>)> = Vec::new();
        for (_, mut size) in alone {
            let mut struck = Vec::new();
            for _ in 0..ROUNDS {
                let next = self.struck(size);
                if next.is_empty() || next == struck {
                    break;
                }
                struck = next;
                let (square, linear) = self.of(&struck);
                size = linear / square;
            }
            let factor = (1.0 + size).recip();
            let is_factor = factor > 0.0 && factor.is_finite() && !struck.is_empty();
            if is_factor && !found.iter().any(|(_, tests)| *tests == struck) {
                found.push((factor, struck));
            }
        }
        found
    }
}
