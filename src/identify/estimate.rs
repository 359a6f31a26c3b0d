//! What a fit gives: estimates with covariance, residuals by test, what cannot be told apart. It fits nothing.

use nalgebra::DMatrix;

use super::ambiguity::Ambiguity;
use crate::identify::model::problem::Problem;
use crate::identify::model::unknowns::{Quantity, Unknown};
use crate::machine::{Component, ComponentError};
use crate::session::Zero;
use crate::statistics::{NoiseModel, rms};

/// Result of a fit.
#[derive(Debug, Clone)]
pub struct Fit {
    pub unknowns: Vec<Unknown>,
    pub estimates: Vec<Estimate>,
    /// Covariance of the estimates, priors and the budget of the linear axes included, mm and rad.
    pub covariance: DMatrix<f64>,
    /// What the linear axes do within their budget, as fitted beside the unknowns.
    pub linear_axes: FittedSlides,
    /// Noise of a reading, by test.
    pub noise: Vec<NoiseModel>,
    pub tests: Vec<TestFit>,
    /// Root mean square of all residuals that were kept, mm.
    pub rms_mm: f64,
    pub ambiguities: Vec<Ambiguity>,
}

/// A location error among the unknowns of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FreeLocation {
    /// Its place among the unknowns.
    pub unknown: usize,
    pub axis: usize,
    /// Index in [`Component::ALL`](crate::machine::Component::ALL).
    pub component: usize,
}

impl Fit {
    /// Location errors among the unknowns with their covariance, mm and rad.
    pub fn location_covariance(&self) -> (Vec<FreeLocation>, DMatrix<f64>) {
        let location = |(k, unknown): (usize, &Unknown)| match unknown.quantity {
            Quantity::Location { axis, component } => {
                Some(FreeLocation { unknown: k, axis, component: component.index() })
            }
            _ => None,
        };
        let free: Vec<FreeLocation> = self.unknowns.iter().enumerate().filter_map(location).collect();
        let covariance =
            DMatrix::from_fn(free.len(), free.len(), |i, j| self.covariance[(free[i].unknown, free[j].unknown)]);
        (free, covariance)
    }

    /// Values of the unknowns, mm or rad.
    pub fn values(&self) -> Vec<f64> {
        self.estimates.iter().map(|estimate| estimate.value).collect()
    }

    /// Readings that were left out as gross outliers.
    pub fn left_out(&self) -> usize {
        self.tests.iter().map(|test| test.left_out.len()).sum()
    }

    /// Readings that took part.
    pub fn readings(&self) -> usize {
        self.tests.iter().map(TestFit::readings).sum()
    }

    /// Share of the readings that were left out, 0 to 1.
    pub fn left_out_share(&self) -> f64 {
        self.left_out() as f64 / (self.readings() + self.left_out()).max(1) as f64
    }

    /// Standard deviation of one reading's noise, root mean square over the tests, mm.
    pub fn noise_mm(&self) -> f64 {
        let squares = self.noise.iter().map(|noise| noise.rms_mm().powi(2)).sum::<f64>();
        (squares / self.noise.len().max(1) as f64).sqrt()
    }

    /// Noise of the first sweep; of the first test when there is none. `None` without tests.
    pub fn sweep_noise(&self) -> Option<&NoiseModel> {
        self.noise.iter().find(|model| model.ar_mm > 0.0).or(self.noise.first())
    }

    /// Root mean square of the residuals that are smaller than a limit, those left out too, mm.
    pub fn rms_below_mm(&self, limit_mm: f64) -> f64 {
        let all = self.tests.iter().flat_map(|test| &test.residual_mm).copied();
        rms(all.filter(|residual| residual.abs() < limit_mm))
    }

    /// Zeros set by hand that no reading tells: what they are is the spread of the balls and no measurement.
    pub fn untold_zeros(&self) -> impl Iterator<Item = (&Unknown, &Estimate)> {
        self.unknowns.iter().zip(&self.estimates).filter(|(unknown, estimate)| {
            matches!(unknown.quantity, Quantity::Bar { .. })
                && unknown.prior_sigma == Zero::Free.spread_mm(0.0)
                && !estimate.determined
        })
    }

    /// Rows that took part, by test.
    pub fn kept_rows(&self) -> Vec<Vec<bool>> {
        self.tests.iter().map(|test| test.kept.clone()).collect()
    }

    /// Estimate of a location error by its ISO 230-1 name; `None` for one that was not free.
    ///
    /// ```
    /// use fiveaxis::identify::{Options, identify};
    /// use fiveaxis::load::load_session;
    ///
    /// let session = load_session("examples/thesis/chapter5/session.yaml".as_ref())?;
    /// let fit = identify(&session, &Options::default())?;
    /// let y = fit.error("EY0C").ok_or("not free")?;
    /// println!("EY0C {:.1} ± {:.1} µm", 1e3 * y.value, 1e3 * y.sigma);
    /// assert!(y.determined && (1e3 * y.value + 52.5).abs() < 0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn error(&self, name: &str) -> Option<&Estimate> {
        let is_it = |unknown: &Unknown| {
            matches!(unknown.quantity, Quantity::Location { .. }) && unknown.label.eq_ignore_ascii_case(name)
        };
        self.unknowns.iter().position(is_it).map(|index| &self.estimates[index])
    }

    /// Standard deviation of a weighted sum of unknowns (place in the list, weight), and whether the data fix it.
    ///
    /// With weights a, covariance C and priors σ_j the variance is `aᵀCa`, of which `Σ_j ((Ca)_j/σ_j)²` stems from the priors; less than half
    /// of it may, spindle balls not counted that are known to within their spread. Of errors that are seen in one sum only, none alone is fixed.
    pub fn sum_of(&self, weights: &[(usize, f64)], spindle_ball_spread_mm: f64) -> Summed {
        let with = |row: usize| weights.iter().map(|&(k, weight)| self.covariance[(row, k)] * weight).sum::<f64>();
        let variance = weights.iter().map(|&(k, weight)| weight * with(k)).sum::<f64>();
        let counts = |(_, unknown): &(usize, &Unknown)| {
            !matches!(unknown.quantity, Quantity::SpindleBall { .. }) || unknown.prior_sigma > spindle_ball_spread_mm
        };
        let by_priors: f64 = (self.unknowns.iter().enumerate().filter(counts))
            .map(|(j, unknown)| (with(j) / unknown.prior_sigma).powi(2))
            .sum();
        // of a fit that is not to be believed nothing is fixed
        let is_believed = self.estimates.iter().any(|estimate| estimate.determined);
        Summed { sigma: variance.max(0.0).sqrt(), determined: is_believed && 2.0 * by_priors < variance }
    }

    /// Leaves values and residuals as they are, but says of none that the data determine it: for a fit that does not fit.
    pub fn claim_nothing(&mut self) {
        for estimate in &mut self.estimates {
            estimate.determined = false;
            estimate.relative_to_spindle_ball = false;
        }
    }
}

/// What a fit says of a sum of unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summed {
    /// mm or rad.
    pub sigma: f64,
    pub determined: bool,
}

/// Estimate of one unknown, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    pub value: f64,
    /// Standard deviation, priors and the budget of the linear axes included.
    pub sigma: f64,
    /// Standard deviation if the spindle balls stood exactly where the session says.
    pub sigma_to_spindle_ball: f64,
    /// Standard deviation if the linear axes were exact too: what the noise of the readings leaves.
    pub sigma_noise: f64,
    /// Share of the variance that comes from priors other than the spindle balls', which are held here as the linear axes
    /// are, 0 to 1: `Σ_j (C_kj/σ_j)² / C_kk` on a machine without location errors; the rest comes from the noise of the data.
    pub prior_share: f64,
    /// Share of the variance that comes from the priors of pivots, spindle balls and bars, 0 to 1.
    pub setup_share: f64,
    /// The data fix it, given the spindle balls and exact linear axes: prior share below half. How well is said by `sigma`.
    pub determined: bool,
    /// It is fixed only relative to the spindle ball: without that ball's prior the data say little.
    pub relative_to_spindle_ball: bool,
}

/// Errors of the linear axes that a fit took from their budget.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FittedSlides {
    /// Squareness: axis, component, value in rad.
    pub squareness: Vec<(usize, Component, f64)>,
    /// Displacements, by axis.
    pub displacements: Vec<(usize, ComponentError)>,
}

impl FittedSlides {
    pub(super) fn of(problem: &Problem, values: &[f64]) -> FittedSlides {
        let fitted: Vec<(Quantity, f64)> =
            problem.unknowns.iter().map(|unknown| unknown.quantity).zip(values.iter().copied()).collect();
        let budget = &fitted[problem.asked..];
        let square = budget.iter().filter_map(|&(quantity, value)| match quantity {
            Quantity::Location { axis, component } => Some((axis, component, value)),
            _ => None,
        });
        FittedSlides { squareness: square.collect(), displacements: problem.slides.component_errors(budget) }
    }
}

/// Fit of one test.
#[derive(Debug, Clone, PartialEq)]
pub struct TestFit {
    pub name: String,
    /// Reading minus model, mm; NaN where there is no reading.
    pub residual_mm: Vec<f64>,
    /// Rows that took part.
    pub kept: Vec<bool>,
    /// Root mean square over the rows that took part, mm.
    pub rms_mm: f64,
    /// Rows with a reading that were left out.
    pub left_out: Vec<usize>,
}

impl TestFit {
    /// Readings that took part.
    pub fn readings(&self) -> usize {
        self.kept.iter().filter(|kept| **kept).count()
    }
}
