//! Claims with their designs, budgets and causes, stacked for comparison: what does not depend on the values stated.

use nalgebra::{DMatrix, DVector};

use super::budget::{Budget, Limits, budget};
use super::causes::{Cause, Change, Kind, causes};
use super::chance::one_of;
use super::compare::Frame;
use super::design::Design;
use super::error::ReconcileError;
use crate::machine::ErrorName;
use crate::session::Claim;

/// Claims with their designs, budgets and causes: what does not depend on the values stated.
pub struct Prepared {
    pub designs: Vec<Design>,
    pub budgets: Vec<Budget>,
    pub causes: Vec<Cause>,
    pub(super) names: Vec<ErrorName>,
    /// Index of the first stacked error of each claim.
    pub(super) first: Vec<usize>,
    pub(super) frame: Frame,
    pub(super) covariance: DMatrix<f64>,
    /// The circles' readings among the causes, as disagreements per µm.
    pub(super) circles: Vec<(usize, DVector<f64>)>,
    pub(super) threshold: f64,
}

impl Prepared {
    /// Prepares claims for comparison.
    pub fn of(claims: &[Claim], limits: &Limits) -> Result<Prepared, ReconcileError> {
        if claims.len() < 2 {
            return Err(ReconcileError::One);
        }
        refuse_two_machines(claims)?;
        let designs = claims.iter().map(Design::of).collect::<Result<Vec<_>, _>>()?;
        let budgets = claims
            .iter()
            .zip(&designs)
            .map(|(claim, design)| budget(claim, design, limits))
            .collect::<Result<Vec<_>, _>>()?;
        let causes = causes(&designs)?;
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

    /// Values that an assumption restates as the given ones: `y` with `y + M y = values`. Tests make claims
    /// with a known cause by it.
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
}

/// Results of one machine have its name, its code and its axes.
fn refuse_two_machines(claims: &[Claim]) -> Result<(), ReconcileError> {
    let Some((first, others)) = claims.split_first() else { return Ok(()) };
    let of = |claim: &Claim| {
        let [first_machine, machine] = first.session.machine.told_from(&claim.session.machine)?;
        Some(ReconcileError::TwoMachines {
            first: first.name.clone(),
            first_machine,
            claim: claim.name.clone(),
            machine,
        })
    };
    others.iter().find_map(of).map_or(Ok(()), Err)
}
