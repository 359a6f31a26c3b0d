//! Where the axes stand when the pivot is put in its place, and how well that must be met. It mounts nothing.

use nalgebra::{DMatrix, DVector};

use crate::bodies::Kit;
use crate::chain::{Chain, Geometry};
use crate::machine::{AxisKind, Machine};
use crate::session::Test;

use crate::plan::information::uncertainty::Uncertainty;

/// How the operator finds the pivot's place.
#[derive(Debug, Clone, PartialEq)]
pub struct Placing {
    /// Positions of all axes at which the spindle ball stands where the pivot ball is to be, rotary axes at zero or next to
    /// it, mm and rad; `None` when the slides cannot go there.
    pub jog: Option<Vec<f64>>,
    /// How near to its place the pivot ball must be, mm.
    pub pivot_mm: f64,
    /// Why not farther.
    pub reason: String,
    /// How well the gauge length must be known, mm.
    pub gauge_length_mm: f64,
}

/// Standard deviations of a setup's spread that it may be off: 1 in 400 is farther.
const SIGMAS: f64 = 3.0;
/// Share of a gauge's half stroke that a pivot off its place may take: the other ball and the machine's errors need the rest.
const STROKE_SHARE: f64 = 0.5;
/// What keeps the equations of slides that span no space solvable; the miss shows it then.
const RIDGE: f64 = 1e-9;
/// Farthest that the solved place may be off, mm: rounding.
const MET_MM: f64 = 1e-6;

impl Placing {
    /// Jog position and tolerance of a test's pivot.
    ///
    /// A pivot off its place by p changes the bar by `dL = u·p`, at most |p| (u along the bar), and by p²/2L more. So |p| is
    /// kept within the spread that the session counts on, within the gauge's stroke, and so small that p²/2L is below the
    /// noise of a reading.
    pub fn of(machine: &Machine, kit: &Kit, test: &Test, uncertainty: &Uncertainty) -> Placing {
        let bar_mm = test.bar_length_mm.unwrap_or(kit.bar.length_mm);
        let pivot = test.pivot.spread_mm.unwrap_or(uncertainty.spread.pivot_mm);
        let limits = [
            (SIGMAS * pivot, format!("{SIGMAS} sigma of the {:.0} um that the session counts on", pivot * 1e3)),
            (STROKE_SHARE * kit.bar.half_stroke_mm, "half of the gauge's stroke".to_string()),
            ((2.0 * bar_mm * uncertainty.noise_mm).sqrt(), "beyond it p^2/2L exceeds a reading's noise".to_string()),
        ];
        let [mut least, others @ ..] = limits;
        for limit in others {
            if limit.0 < least.0 {
                least = limit;
            }
        }
        let (pivot_mm, reason) = least;
        let ball = test.spindle_ball.spread_mm.unwrap_or(uncertainty.spread.spindle_ball_mm);
        Placing { jog: jog(machine, test), pivot_mm, reason, gauge_length_mm: SIGMAS * ball }
    }
}

/// Positions at which the spindle ball stands in the pivot ball's place.
fn jog(machine: &Machine, test: &Test) -> Option<Vec<f64>> {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let links = test.links(&chain).ok()?;
    let gap = |q: &[f64]| -test.bar(&geometry, links, q);
    let mut q: Vec<f64> = machine.axes.iter().map(|axis| axis.near_zero()).collect();
    let linear: Vec<usize> = machine.axes_of(AxisKind::Linear).collect();
    let here = gap(&q);
    let ways = DMatrix::from_fn(3, linear.len(), |row, column| {
        let mut moved = q.clone();
        moved[linear[column]] += 1.0;
        (gap(&moved) - here)[row]
    });
    let normal = &ways.transpose() * &ways + DMatrix::identity(linear.len(), linear.len()) * RIDGE;
    let factor = normal.cholesky()?;
    // the second pass takes out what the ridge left
    for _ in 0..2 {
        let step = factor.solve(&(ways.transpose() * DVector::from_column_slice((-gap(&q)).as_slice())));
        linear.iter().zip(step.iter()).for_each(|(&k, way)| q[k] += way);
    }
    let inside = |k: usize| machine.axes[k].range.is_none_or(|(low, high)| q[k] >= low && q[k] <= high);
    (gap(&q).norm() < MET_MM && (0..q.len()).all(inside)).then_some(q)
}
