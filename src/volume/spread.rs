//! What the uncertainty of a fit means for the volume: figures of machines drawn from the fit's covariance.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::figures::{Figures, Share, pose_errors};
use crate::chain::Chain;
use crate::identify::Fit;
use crate::inverse::{Kinematics, Tool};
use crate::machine::Machine;
use crate::statistics::mean;

/// Standard deviations of figures by the fit, and what stays unknown of the tool's pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Standard deviation of each figure.
    pub sigma: Figures,
    /// How far the drawn machines' tools stand from the fitted machine's: what a correction by this fit would leave.
    pub left: Figures,
}

/// Machines drawn: a standard deviation of so many is known to 7 %.
const DRAWS: usize = 100;
/// Poses of a drawn machine: 50 lie beyond the 95 % figure, which is known to some per cent, less than its sigma.
const POSES: usize = 1000;

/// Draws machines about the fitted one, whose errors `machine` has.
pub fn spread(machine: &Machine, fit: &Fit, tool: Tool, poses: &[Vec<f64>]) -> Spread {
    let (free, covariance) = fit.location_covariance();
    let own = covariance.symmetric_eigen();
    let root = &own.eigenvectors * DMatrix::from_diagonal(&own.eigenvalues.map(|value| value.max(0.0).sqrt()));
    // the first of them are as even over the travel as all; every so many of them are not
    let poses = &poses[..POSES.min(poses.len())];
    let chain = Chain::of(machine);
    let fitted = pose_errors(machine, &chain, tool, poses);
    let known = Kinematics::actual(machine, &chain, tool);
    let axes: Vec<_> = poses.iter().map(|pose| known.pose(pose).axis).collect();
    let mut random = ChaCha8Rng::seed_from_u64(230);
    let mut drawn = Vec::with_capacity(DRAWS);
    let mut left = Vec::new();
    for _ in 0..DRAWS {
        let normal = DVector::from_fn(free.len(), |_, _| StandardNormal.sample(&mut random));
        let change: DVector<f64> = &root * normal;
        let mut one = machine.clone();
        for (k, of) in free.iter().enumerate() {
            one.axes[of.axis].location_errors[of.component] += change[k];
        }
        let mut errors = pose_errors(&one, &chain, tool, poses);
        drawn.push(Figures::of(&errors));
        // relative to the fitted machine
        let real = Kinematics::actual(&one, &chain, tool);
        for (k, error) in errors.iter_mut().enumerate() {
            error.off_mm -= fitted[k].off_mm;
            error.turned_rad = real.pose(&poses[k]).angle_to(&axes[k]);
        }
        left.extend(errors);
    }
    Spread { sigma: deviations(&drawn), left: Figures::of(&left) }
}

/// Standard deviation of every figure.
fn deviations(drawn: &[Figures]) -> Figures {
    let of = |figure: &dyn Fn(&Figures) -> f64| -> f64 {
        let values: Vec<f64> = drawn.iter().map(figure).collect();
        let mean = mean(values.iter().copied()).unwrap_or(f64::NAN);
        (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1).max(1) as f64).sqrt()
    };
    let share = |pick: fn(&Figures) -> Share| Share {
        mean: of(&|figures| pick(figures).mean),
        p95: of(&|figures| pick(figures).p95),
        largest: of(&|figures| pick(figures).largest),
    };
    Figures {
        position_mm: share(|figures| figures.position_mm),
        zeroed_mm: share(|figures| figures.zeroed_mm),
        direction_rad: share(|figures| figures.direction_rad),
    }
}
