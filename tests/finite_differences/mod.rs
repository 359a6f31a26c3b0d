//! Derivatives of a length against differences of the forward model, with a tolerance that the step itself gives.

use fiveaxis::chain::{Chain, Composition, Geometry, LinkId, Sensitivity};
use nalgebra::Vector3;

/// Everything that a length depends on.
#[derive(Debug, Clone)]
pub struct Arguments {
    pub errors: Vec<[f64; 6]>,
    pub motion: Vec<[f64; 6]>,
    pub positions: Vec<f64>,
    pub pivot: Vector3<f64>,
    pub spindle: Vector3<f64>,
}

impl Arguments {
    pub fn length(&self, chain: &Chain, links: (LinkId, LinkId), composition: Composition) -> f64 {
        let geometry = Geometry::new(chain, &self.errors, composition);
        geometry.length((links.0, &self.pivot), (links.1, &self.spindle), &self.positions, Some(&self.motion))
    }
}

/// Steps, mm and rad: truncation and rounding are about equal for machines of a metre.
const STEP_MM: f64 = 0.5;
const STEP_RAD: f64 = 2e-3;
/// Coordinates of the chain are below this, mm; a length computed from them is rounded to a few of its last places.
const SCALE_MM: f64 = 4000.0;
/// Roundings that a chain of eight joints adds up.
const ROUNDINGS: f64 = 30.0;

/// Fourth-order central difference `(8·(f(h) − f(−h)) − (f(2h) − f(−2h))) / 12h`.
fn difference(f: &impl Fn(f64) -> f64, h: f64) -> f64 {
    (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// Compares every derivative at one pose; returns the largest difference in units of its tolerance.
pub fn check(what: &str, chain: &Chain, links: (LinkId, LinkId), at: &Arguments, composition: Composition) -> f64 {
    let geometry = Geometry::new(chain, &at.errors, composition);
    let mut s = Sensitivity::zeros(chain.axis_count());
    let (pivot, spindle) = ((links.0, &at.pivot), (links.1, &at.spindle));
    geometry.sensitivity(pivot, spindle, &at.positions, Some(&at.motion), &mut s);
    assert_eq!(s.length_mm, at.length(chain, links, composition), "{what}: length");
    let mut worst = 0.0f64;
    let mut compare = |name: String, found: f64, step: f64, shift: &dyn Fn(&mut Arguments, f64)| {
        let f = |by: f64| {
            let mut shifted = at.clone();
            shift(&mut shifted, by);
            shifted.length(chain, links, composition)
        };
        let (fine, coarse) = (difference(&f, step), difference(&f, 2.0 * step));
        // halving the step divides the truncation by 16, so the change bounds what is left
        let tolerance = (fine - coarse).abs() + ROUNDINGS * f64::EPSILON * SCALE_MM / step;
        let off = (found - fine).abs();
        worst = worst.max(off / tolerance);
        assert!(off <= tolerance, "{what}: {name} {composition:?}: {found} against {fine} ± {tolerance:e}");
    };
    for axis in 0..chain.axis_count() {
        for k in 0..6 {
            let step = if k < 3 { STEP_MM } else { STEP_RAD };
            compare(format!("location {axis} {k}"), s.location[axis][k], step, &|a, by| a.errors[axis][k] += by);
            compare(format!("motion {axis} {k}"), s.motion[axis][k], step, &|a, by| a.motion[axis][k] += by);
        }
        let step = match chain.joint(axis).kind {
            fiveaxis::machine::AxisKind::Linear => STEP_MM,
            fiveaxis::machine::AxisKind::Rotary => STEP_RAD,
        };
        compare(format!("position {axis}"), s.position[axis], step, &|a, by| a.positions[axis] += by);
    }
    for k in 0..3 {
        compare(format!("pivot {k}"), s.pivot[k], STEP_MM, &|a, by| a.pivot[k] += by);
        compare(format!("spindle {k}"), s.spindle[k], STEP_MM, &|a, by| a.spindle[k] += by);
    }
    worst
}
