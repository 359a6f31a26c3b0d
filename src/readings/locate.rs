//! Where instrument and target stand, found from the readings and the nominal chain: a start for the fit, not its result.
//!
//! With the target's link at rotation C and place c as the instrument's link sees it, the point s on it and the reading p:
//! `C·s + c = A·p + o`. A, o and s are found by turns: A and o by Kabsch's solution, s by least squares; then the target's
//! axes B from the rotations M that were read, `C·B = A·M`.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::rotation::{nearest_rotation, rotation, rotation_vector};
use crate::statistics::median;

/// One reading with where the nominal chain puts the target's link.
#[derive(Debug, Clone)]
pub struct Sighting {
    /// The target's link as the instrument's link sees it.
    pub rotation: Matrix3<f64>,
    /// mm.
    pub translation_mm: Vector3<f64>,
    /// Coordinates as read, mm.
    pub point_mm: Vector3<f64>,
    /// Rotation as read.
    pub turned: Option<Matrix3<f64>>,
}

/// Instrument and target.
#[derive(Debug, Clone, PartialEq)]
pub struct Located {
    /// Axes of the instrument as columns, on its link.
    pub instrument_axes: Matrix3<f64>,
    /// Origin of the instrument on its link, mm.
    pub instrument_mm: Vector3<f64>,
    /// Point of the target on its link, mm.
    pub target_mm: Vector3<f64>,
    /// Axes of the target on its link.
    pub target_axes: Matrix3<f64>,
    /// Median distance between reading and nominal chain, mm.
    pub misfit_mm: f64,
    /// The same of the rotations that were read, rad; `None` where none was.
    pub turn_misfit_rad: Option<f64>,
}

/// Distances of the places from which the search for the target starts beside its stated one, mm: near R's origin, and as far out as the end of
/// an arm. Poses of two joints alone are seen nearly as well by a target on the other side of them.
const START_MM: [f64; 2] = [150.0, 1000.0];
/// Rows that a start is judged on.
const ROWS_OF_A_START: usize = 60;
/// Steps of Gauss–Newton.
const STEPS: usize = 40;
/// A step this small ends them, mm.
const SETTLED_MM: f64 = 1e-7;

/// Where a target is, in the frame of its link, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// There: it is held.
    Known(Vector3<f64>),
    /// Anywhere; the search begins there.
    Sought(Vector3<f64>),
}

/// Finds instrument and target. `None` where fewer than three points were read.
pub fn locate(sightings: &[Sighting], target: Target) -> Option<Located> {
    if sightings.len() < 3 {
        return None;
    }
    let few: Vec<Sighting> = sightings.iter().step_by(sightings.len().div_ceil(ROWS_OF_A_START)).cloned().collect();
    let sides = START_MM
        .into_iter()
        .flat_map(|size| [0, 1, 2].into_iter().flat_map(move |k| [size, -size].map(|size| Vector3::ith(k, size))));
    let starts: Vec<Target> = match target {
        Target::Known(_) => vec![target],
        Target::Sought(near) => [near].into_iter().chain(sides.map(|side| near + side)).map(Target::Sought).collect(),
    };
    let tried = starts.into_iter().map(|start| refined(&few, start));
    let best = tried.min_by(|a, b| a.misfit_mm.total_cmp(&b.misfit_mm))?;
    Some(match target {
        Target::Known(_) => refined(sightings, target),
        Target::Sought(_) => refined(sightings, Target::Sought(best.target_mm)),
    })
}

/// Gauss–Newton on instrument and target from a place of the target, with weights that spare it gross errors.
fn refined(sightings: &[Sighting], start: Target) -> Located {
    let (mut target, is_known) = match start {
        Target::Known(place) => (place, true),
        Target::Sought(near) => (near, false),
    };
    let mut weights = vec![1.0; sightings.len()];
    let (mut axes, mut origin) = placed(sightings, &target, &weights);
    for _ in 0..STEPS {
        let off = |s: &Sighting| s.rotation * target + s.translation_mm - axes * s.point_mm - origin;
        let sizes: Vec<f64> = sightings.iter().map(|s| off(s).norm()).collect();
        let scale = 2.0 * median(sizes.iter().copied()).unwrap_or(0.0);
        weights = sizes.iter().map(|size| if *size > scale { scale / size } else { 1.0 }).collect();
        let mut normal = SMatrix::<f64, 9, 9>::identity() * 1e-9;
        let mut right = SVector::<f64, 9>::zeros();
        for (s, weight) in sightings.iter().zip(&weights) {
            // off = C·s + c − exp(α)·A·p − o: columns for o, α and s
            let mut columns = SMatrix::<f64, 3, 9>::zeros();
            columns.fixed_columns_mut::<3>(0).copy_from(&-Matrix3::identity());
            columns.fixed_columns_mut::<3>(3).copy_from(&(axes * s.point_mm).cross_matrix());
            if !is_known {
                columns.fixed_columns_mut::<3>(6).copy_from(&s.rotation);
            }
            let weighted = columns * *weight;
            normal += weighted.transpose() * columns;
            right -= weighted.transpose() * off(s);
        }
        // angles count at the lever of the points
        let Some(factor) = normal.cholesky() else { break };
        let step = factor.solve(&right);
        let part = |from: usize| Vector3::new(step[from], step[from + 1], step[from + 2]);
        origin += part(0);
        axes = rotation(&part(3)) * axes;
        // of a known target nothing
        target += part(6);
        if part(0).norm() + part(6).norm() < SETTLED_MM {
            break;
        }
    }
    let misfit =
        median(sightings.iter().map(|s| (s.rotation * target + s.translation_mm - axes * s.point_mm - origin).norm()));
    let turned = || sightings.iter().filter_map(|s| Some(s.rotation.transpose() * axes * s.turned?));
    let sum = turned().fold(Matrix3::zeros(), |sum, own| sum + own);
    let target_axes = if sum == Matrix3::zeros() { Matrix3::identity() } else { nearest_rotation(&sum) };
    Located {
        instrument_axes: axes,
        instrument_mm: origin,
        target_mm: target,
        target_axes,
        misfit_mm: misfit.unwrap_or(f64::INFINITY),
        turn_misfit_rad: median(turned().map(|own| rotation_vector(&(target_axes.transpose() * own)).norm())),
    }
}

/// Kabsch: axes and origin that bring the readings to where the chain puts the target.
fn placed(sightings: &[Sighting], target: &Vector3<f64>, weights: &[f64]) -> (Matrix3<f64>, Vector3<f64>) {
    let total: f64 = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let place = |s: &Sighting| s.rotation * target + s.translation_mm;
    let mean = |value: &dyn Fn(&Sighting) -> Vector3<f64>| {
        sightings.iter().zip(weights).map(|(s, weight)| value(s) * *weight).sum::<Vector3<f64>>() / total
    };
    let (there, here) = (mean(&place), mean(&|s: &Sighting| s.point_mm));
    let spread = sightings.iter().zip(weights).fold(Matrix3::zeros(), |sum, (s, weight)| {
        sum + (place(s) - there) * (s.point_mm - here).transpose() * *weight
    });
    let axes = nearest_rotation(&spread);
    (axes, there - axes * here)
}
