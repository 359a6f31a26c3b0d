//! What may act beside the eight location errors: slides, ball and bar within their limits, and physics that the reductions leave out.

use std::f64::consts::TAU;

use super::design::Axis;

/// Nothing by default: then the machine has its eight location errors alone.
#[derive(Clone, Default)]
pub struct Besides {
    /// Place of the spindle ball in the spindle, µm; drawn where it is not given.
    pub ball_um: Option<[f64; 3]>,
    /// Places of the slides, mm, each with what they miss it by, µm.
    pub slides: Vec<([f64; 3], [f64; 3])>,
    /// By circle, in the order of the design: cosine and sine of the axis's angle in the bar's reading, µm.
    pub waves_um: Vec<[f64; 2]>,
    pub physics: Option<Physics>,
}

/// One cause.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Physics {
    /// The spindle ball sits elsewhere from a circle on.
    Seat { from_circle: usize, by_um: [f64; 3] },
    /// The spindle grows, `by (1 − e^(−t/τ))` over the session's time.
    Growth { by_um: [f64; 3], tau_s: f64 },
    /// A rotary axis moves along itself once a turn.
    Axial { axis: Axis, cosine_um: f64, sine_um: f64 },
    /// A guideway is off about one place of its slide (0 X, 1 Y, 2 Z): a raised cosine of this width.
    Worn { slide: usize, centre_mm: f64, width_mm: f64, by_um: [f64; 3] },
}

impl Besides {
    /// By how much the spindle ball is off its place in a circle, without its own place in the spindle, µm.
    pub fn spindle_um(&self, circle: usize, place_mm: [f64; 3], time_s: f64) -> [f64; 3] {
        let is_here = |other: &[f64; 3]| (0..3).all(|k| (other[k] - place_mm[k]).abs() < 1e-6);
        let missed = self.slides.iter().find(|(place, _)| is_here(place)).map_or([0.0; 3], |(_, by)| *by);
        let (by_um, share) = match self.physics {
            Some(Physics::Seat { from_circle, by_um }) => (by_um, f64::from(circle >= from_circle)),
            Some(Physics::Growth { by_um, tau_s }) => (by_um, 1.0 - (-time_s / tau_s).exp()),
            Some(Physics::Worn { slide, centre_mm, width_mm, by_um }) => {
                let off_mm = place_mm[slide] - centre_mm;
                let raised = (1.0 + (TAU * off_mm / width_mm).cos()) / 2.0;
                (by_um, if off_mm.abs() < width_mm / 2.0 { raised } else { 0.0 })
            }
            Some(Physics::Axial { .. }) | None => ([0.0; 3], 0.0),
        };
        std::array::from_fn(|k| missed[k] + share * by_um[k])
    }

    /// By how much the bar reads a circle wrongly, µm.
    pub fn reading_um(&self, circle: usize, at_deg: f64) -> f64 {
        let [cosine, sine] = self.waves_um.get(circle).copied().unwrap_or_default();
        let at = at_deg.to_radians();
        cosine * at.cos() + sine * at.sin()
    }

    /// By how much a rotary axis at an angle has moved along itself, mm.
    pub fn along_mm(&self, axis: Axis, at_deg: f64) -> f64 {
        match self.physics {
            Some(Physics::Axial { axis: of, cosine_um, sine_um }) if of == axis => {
                let at = at_deg.to_radians();
                (cosine_um * at.cos() + sine_um * at.sin()) * 1e-3
            }
            _ => 0.0,
        }
    }
}
