//! Results of several methods on one machine: which disagree beyond their budgets, what would explain it, which test decides.
//!
//! | file | holds |
//! |---|---|
//! | `design` | a claim's tests as a map from readings to its errors |
//! | `budget` | the covariance of a claim's errors: repeats, bar, slides, ball |
//! | `compare` | least squares over all claims; which circles stand out |
//! | `causes` | assumptions read otherwise and physics left out, with what each does |
//! | `deciding` | the test that tells the causes left apart |
//!
//! The machine's own errors are free: nothing is said of them, only of what no one machine can show to all methods.

mod budget;
mod causes;
mod compare;
mod deciding;
mod design;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

pub use budget::{Budget, Limits};
pub use causes::{Cause, Kind};
pub use deciding::{Candidate, DecidingTest};
pub use design::{Design, Group};

use causes::Change;
use compare::{Frame, Selection, select, sizes};

use crate::machine::ErrorName;
use crate::methods::MethodError;
use crate::session::{Claim, MotionError};
use crate::simulate::SimulateError;

/// Share of consistent claims in which some disagreement may be called so by chance.
pub const FALSE_ALARMS: f64 = 0.02;

/// χ² by which a cause may do worse than the circle that it replaces: 1 % of one degree of freedom.
const REPLACED_CHI2: f64 = 6.63;
/// A cause that moves the disagreements by less than this many standard deviations per µm, mm or as a whole does not act.
const NO_EFFECT: f64 = 1e-3;

/// Why claims cannot be compared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReconcileError {
    #[error("one result alone cannot disagree; name two or more files")]
    One,
    #[error("'{claim}': {reason}")]
    Design { claim: String, reason: String },
    #[error("{method} does not tell {error}; state what the method gives, or method: fit")]
    NotOfTheMethod { error: String, method: String },
    #[error("no error is stated by two of the results; there is nothing to compare")]
    NothingInCommon,
    #[error("the uncertainties of the stated errors are not independent enough to compare; state fewer errors")]
    Covariance,
    #[error(transparent)]
    Method(#[from] MethodError),
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Simulate(#[from] SimulateError),
}

/// Claims with their designs, budgets and causes: what does not depend on the values stated.
pub struct Prepared {
    pub designs: Vec<Design>,
    pub budgets: Vec<Budget>,
    pub causes: Vec<Cause>,
    names: Vec<ErrorName>,
    /// Index of the first stacked error of each claim.
    first: Vec<usize>,
    frame: Frame,
    covariance: DMatrix<f64>,
    /// The circles' readings among the causes, as disagreements per µm.
    circles: Vec<(usize, DVector<f64>)>,
    threshold: f64,
}

/// One error stated by two claims.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    pub name: ErrorName,
    pub claims: [usize; 2],
    /// Second minus first, µm or arcsec.
    pub value: f64,
    /// By the stated scatter alone.
    pub repeatability: f64,
    /// By the budgets.
    pub sigma: f64,
    /// Beyond what chance gives in the differences compared together.
    pub is_beyond: bool,
}

/// One disagreement: a circle that would have to be off.
#[derive(Debug, Clone)]
pub struct Disagreement {
    /// Index among the causes: the bar's reading of this circle.
    pub circle: usize,
    /// µm, with its standard deviation.
    pub size: (f64, f64),
    /// What it moves in its claim, µm and arcsec: these values are one disagreement.
    pub moves: Vec<(ErrorName, f64)>,
    /// Other circles that would do as well, as causes.
    pub alike: Vec<usize>,
}

/// What became of a cause.
#[derive(Debug, Clone)]
pub struct Verdict {
    pub cause: usize,
    /// Fitted size with its standard deviation; `None` for an assumption.
    pub size: Option<(f64, f64)>,
    /// Disagreements, by index, that it does away with.
    pub explains: Vec<usize>,
    /// How many circles still stand out.
    pub leaves: usize,
    pub chi2: f64,
    /// Needs no size beyond its limit.
    pub is_plausible: bool,
}

impl Verdict {
    /// It does away with a disagreement at a plausible size.
    pub fn is_named(&self) -> bool {
        self.is_plausible && !self.explains.is_empty()
    }
}

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
    /// Prepares claims for comparison.
    pub fn of(claims: &[Claim], limits: &Limits) -> Result<Prepared, ReconcileError> {
        if claims.len() < 2 {
            return Err(ReconcileError::One);
        }
        let designs = claims.iter().map(Design::of).collect::<Result<Vec<_>, _>>()?;
        let budgets = claims
            .iter()
            .zip(&designs)
            .map(|(claim, design)| budget::budget(claim, design, limits))
            .collect::<Result<Vec<_>, _>>()?;
        let causes = causes::causes(&designs)?;
        let names: Vec<ErrorName> = designs.iter().flat_map(|design| design.names.iter().cloned()).collect();
        let mut first = vec![0];
        designs.iter().for_each(|design| first.push(first.last().copied().unwrap_or(0) + design.names.len()));
        let mut covariance = DMatrix::zeros(names.len(), names.len());
        for (budget, &at) in budgets.iter().zip(&first) {
            let count = budget.covariance.nrows();
            covariance.view_mut((at, at), (count, count)).copy_from(&budget.covariance);
        }
        let frame = Frame::new(&names, covariance.clone())?;
        let mut prepared =
            Prepared { designs, budgets, causes, names, first, frame, covariance, circles: Vec::new(), threshold: 0.0 };
        let nothing = DVector::zeros(prepared.names.len());
        let is_circle = |cause: &Cause| matches!(cause.kind, Kind::Bar { .. });
        let circles = prepared.causes.iter().enumerate().filter(|(_, cause)| is_circle(cause));
        prepared.circles = circles
            .map(|(index, cause)| (index, prepared.frame.disagreement(&prepared.stacked(cause, &nothing))))
            .collect();
        prepared.threshold = one_of(prepared.circles.len());
        Ok(prepared)
    }

    /// A cause's effect on the stacked errors, per unit or as a restatement of `values`.
    pub fn stacked(&self, cause: &Cause, values: &DVector<f64>) -> DVector<f64> {
        let mut stacked = DVector::zeros(self.names.len());
        for (claim, change) in cause.effect.iter().enumerate() {
            let (at, count) = (self.first[claim], self.designs[claim].names.len());
            match change {
                Change::None => {}
                Change::PerUnit(response) => stacked.rows_mut(at, count).copy_from(response),
                Change::Restated(matrix) => {
                    stacked.rows_mut(at, count).copy_from(&(matrix * values.rows(at, count)));
                }
            }
        }
        stacked
    }

    /// Values that an assumption restates as the given ones: `y` with `y + M y = values`.
    pub fn unrestated(&self, cause: &Cause, values: &DVector<f64>) -> DVector<f64> {
        let mut before = values.clone();
        for (claim, change) in cause.effect.iter().enumerate() {
            let Change::Restated(matrix) = change else { continue };
            let (at, count) = (self.first[claim], self.designs[claim].names.len());
            let whole = DMatrix::identity(count, count) + matrix;
            if let Some(solved) = whole.lu().solve(&values.rows(at, count).into_owned()) {
                before.rows_mut(at, count).copy_from(&solved);
            }
        }
        before
    }

    /// How many standard deviations of disagreement a change of the stacked errors makes.
    pub fn sigmas(&self, change: &DVector<f64>) -> f64 {
        self.frame.disagreement(change).norm()
    }

    /// The stated values one below the other, µm and arcsec.
    pub fn values(&self, claims: &[Claim]) -> DVector<f64> {
        let values = claims.iter().flat_map(|claim| &claim.values);
        DVector::from_iterator(
            self.names.len(),
            values.map(|value| value.name.component.measure().to_output(value.value)),
        )
    }

    /// Covariance of the stacked errors, µm and arcsec.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

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
        let deciding = deciding::deciding(self, values, &verdicts);
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
        let one = |((pick, alike), size): ((&usize, &Vec<usize>), (f64, f64))| {
            let circle = self.circles[*pick].0;
            let moved = self.stacked(&self.causes[circle], &DVector::zeros(self.names.len())) * size.0;
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
            (Some(limit), Some((size, sigma))) => size.abs() <= limit + 2.0 * sigma && sigma <= limit,
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

/// χ² of one degree of freedom that one of `count` comparisons exceeds by chance in [`FALSE_ALARMS`] of the cases.
fn one_of(count: usize) -> f64 {
    let share = FALSE_ALARMS / count.max(1) as f64;
    ChiSquared::new(1.0).map_or(f64::INFINITY, |chi2| chi2.inverse_cdf(1.0 - share))
}

/// Share of chance that lies beyond a number of standard deviations, both sides.
pub fn chance(sigmas: f64) -> f64 {
    Normal::new(0.0, 1.0).map_or(f64::NAN, |normal| 2.0 * normal.cdf(-sigmas.abs()))
}
