//! Evidence for a block of columns of a linear model, amplitudes drawn from a normal prior: exact, no geometry.
//!
//! With the block's projected information `G` and score `z`, and amplitudes from N(0, τ²), the log evidence against nothing is
//! `½ Σ (w² / (λ + 1/τ²) − ln(1 + τ²λ))` over the eigenvalues λ of `G`, `w` being `z` along its eigenvectors.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

/// Probability with these log odds.
pub fn probability_of(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

/// A candidate's standing.
#[derive(Debug, Clone)]
pub struct BlockEvidence {
    /// Log of the evidence ratio for the block against nothing, shape grid not counted.
    pub log_evidence: f64,
    /// Fall of the weighted sum of squares and of the prior's own square, at the best amplitudes.
    pub chi2: f64,
    /// Best amplitudes under the amplitude prior, display units.
    pub amplitudes: Vec<f64>,
    /// Prior sigma of the amplitudes that has the most evidence, display units.
    pub tau: f64,
    /// Part of the evidence that amplitudes larger than is plausible cost, log.
    pub implausibility: f64,
}

/// By how much amplitudes are less likely under the widest prior that is plausible, `tau`, than under the one that would suit them, log.
pub fn implausibility(amplitudes: &[f64], tau: f64, plausible: f64) -> f64 {
    let is_widest = AMPLITUDE_PRIORS.iter().all(|wider| *wider <= tau || *wider > plausible);
    let squares: f64 = amplitudes.iter().map(|amplitude| (amplitude / tau).powi(2)).sum();
    let count = amplitudes.len() as f64;
    if is_widest && squares > count { 0.5 * (squares - count - count * (squares / count).ln()) } else { 0.0 }
}

/// Amplitude priors that are tried, display units: the one with the largest evidence counts.
const AMPLITUDE_PRIORS: [f64; 9] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0];

/// The amplitude prior with the most evidence.
pub fn likeliest_prior(plausible: f64, evidence: impl Fn(f64) -> f64) -> f64 {
    let tried = AMPLITUDE_PRIORS.into_iter().filter(|tau| *tau <= plausible).map(|tau| (tau, evidence(tau)));
    tried.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(AMPLITUDE_PRIORS[0], |(tau, _)| tau)
}

/// The amplitude prior with the most evidence, and what was worked out with it, where evidence has one peak: from that of `near`,
/// which is quick, up to where neither neighbour has more.
pub fn climbed<R>(plausible: f64, near: impl Fn(f64) -> f64, evidence: impl Fn(f64) -> (f64, R)) -> (f64, R) {
    let last = AMPLITUDE_PRIORS.iter().filter(|tau| **tau <= plausible).count().saturating_sub(1);
    let start = likeliest_prior(plausible, near);
    let mut at = AMPLITUDE_PRIORS.iter().position(|tau| *tau == start).unwrap_or(0);
    let mut best = evidence(AMPLITUDE_PRIORS[at]);
    for up in [true, false] {
        while let Some(next) = if up { Some(at + 1).filter(|next| *next <= last) } else { at.checked_sub(1) } {
            let other = evidence(AMPLITUDE_PRIORS[next]);
            // of equals the larger one
            let is_better = if up { other.0 >= best.0 } else { other.0 > best.0 };
            if !is_better {
                break;
            }
            (at, best) = (next, other);
        }
    }
    best
}

/// Evidence of a block from its projected information and score, amplitudes being plausible up to `plausible`.
pub fn judge(information: DMatrix<f64>, z: DVector<f64>, plausible: f64) -> BlockEvidence {
    let count = z.len();
    let eigen = SymmetricEigen::new(information.clone());
    let w = eigen.eigenvectors.tr_mul(&z);
    let evidence = |tau: f64| -> f64 {
        (0..count)
            .map(|k| {
                let lambda = eigen.eigenvalues[k].max(0.0);
                0.5 * (w[k] * w[k] / (lambda + 1.0 / (tau * tau)) - (1.0 + tau * tau * lambda).ln())
            })
            .sum()
    };
    let tau = likeliest_prior(plausible, evidence);
    let mut amplitudes = DVector::zeros(count);
    let mut chi2 = 0.0;
    for k in 0..count {
        let lambda = eigen.eigenvalues[k].max(0.0);
        let precision = lambda + 1.0 / (tau * tau);
        let v = eigen.eigenvectors.column(k);
        amplitudes += v * (w[k] / precision);
        chi2 += w[k] * w[k] / precision;
    }
    // one nat for having chosen τ from the data
    let log_evidence = evidence(tau) - 1.0;
    let implausibility = implausibility(amplitudes.as_slice(), tau, plausible);
    BlockEvidence { log_evidence, chi2, tau, implausibility, amplitudes: amplitudes.iter().copied().collect() }
}

/// Amplitude priors of the parts of a block that have the most evidence together, display units, and their evidence against nothing;
/// a part that adds less than `least` beside the others has none.
///
/// All parts begin with one prior: what two explain only together is seen by neither alone.
pub fn likeliest_priors(
    (information, z): (&DMatrix<f64>, &DVector<f64>),
    parts: &[std::ops::Range<usize>],
    plausible: f64,
    least: f64,
) -> (Vec<Option<f64>>, f64) {
    let evidence = |priors: &[Option<f64>]| evidence_of_parts((information, z), parts, priors);
    let common = likeliest_prior(plausible, |tau| evidence(&vec![Some(tau); parts.len()]));
    let mut priors = vec![Some(common); parts.len()];
    let mut now = evidence(&priors);
    for _ in 0..SWEEPS {
        let before = priors.clone();
        for part in 0..parts.len() {
            let with = |tau: Option<f64>| {
                let mut tried = priors.clone();
                tried[part] = tau;
                evidence(&tried)
            };
            let tau = likeliest_prior(plausible, |tau| with(Some(tau)));
            let (there, without) = (with(Some(tau)), with(None));
            (priors[part], now) = if there - without > least { (Some(tau), there) } else { (None, without) };
        }
        if priors == before {
            break;
        }
    }
    (priors, now)
}

/// Times that the prior of every part is found anew beside the others, at most.
const SWEEPS: usize = 12;

/// Log evidence of a block whose parts have these amplitude priors, against nothing.
fn evidence_of_parts(
    (information, z): (&DMatrix<f64>, &DVector<f64>),
    parts: &[std::ops::Range<usize>],
    priors: &[Option<f64>],
) -> f64 {
    let with_prior = parts.iter().zip(priors).filter_map(|(part, tau)| Some((part, (*tau)?)));
    let columns: Vec<(usize, f64)> = with_prior.flat_map(|(part, tau)| part.clone().map(move |k| (k, tau))).collect();
    let count = columns.len();
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        let ((row, a), (column, b)) = (columns[i], columns[j]);
        a * b * information[(row, column)] + if i == j { 1.0 } else { 0.0 }
    });
    let score = DVector::from_iterator(count, columns.iter().map(|&(k, tau)| tau * z[k]));
    match Cholesky::new(scaled) {
        Some(factor) => 0.5 * (score.dot(&factor.solve(&score)) - log_determinant(&factor)),
        None => f64::NEG_INFINITY,
    }
}

/// Logarithm of the determinant of the matrix that was factored.
pub fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    let lower = factor.l_dirty();
    2.0 * (0..lower.nrows()).map(|k| lower[(k, k)].ln()).sum::<f64>()
}
