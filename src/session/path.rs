//! Planned paths: the sweep of one axis, with linear axes following or not, and planar circles. Positions are computed in `test_motion`.

use nalgebra::Vector3;

use crate::machine::{AxisKind, Machine};

/// How the linear axes follow a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Follow {
    /// They stand still.
    #[default]
    None,
    /// The bar points away from the turning axis.
    Radial,
    /// The bar points along the direction of turning.
    Tangential,
    /// The bar points along the turning axis.
    Axial,
}

impl Follow {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Follow::None => "none",
            Follow::Radial => "radial",
            Follow::Tangential => "tangential",
            Follow::Axial => "axial",
        }
    }
}

/// Plane of a circle of two linear axes; the first letter carries the cosine.
#[derive(Debug, Clone, PartialEq)]
pub struct CirclePlane {
    /// Axis index of the cosine.
    pub first: usize,
    /// Axis index of the sine.
    pub second: usize,
}

/// Path of a test that has no recording yet; angles in degrees as in the file, samples every `step` inclusive of both ends.
#[derive(Debug, Clone, PartialEq)]
pub enum Path {
    /// One axis from `from` to `to` (mm or deg); following linear axes keep the balls `length_mm` apart, where that is stated.
    Sweep { axis: usize, from: f64, to: f64, step: f64, follow: Follow, length_mm: Option<f64> },
    /// Circle of the spindle ball about the pivot ball's nominal place.
    Circle { plane: CirclePlane, radius_mm: f64, from: f64, to: f64, step: f64 },
}

impl Path {
    /// First and last sample, mm or deg.
    pub fn ends(&self) -> [f64; 2] {
        let (Path::Sweep { from, to, .. } | Path::Circle { from, to, .. }) = self;
        [*from, *to]
    }

    /// Way from sample to sample as stated, mm or deg.
    pub fn step(&self) -> f64 {
        let (Path::Sweep { step, .. } | Path::Circle { step, .. }) = self;
        *step
    }

    /// Distance between the balls that following linear axes keep, mm, where it is stated.
    pub fn kept_mm(&self) -> Option<f64> {
        match self {
            Path::Sweep { length_mm, .. } => *length_mm,
            Path::Circle { .. } => None,
        }
    }

    /// The same path in so many equal steps.
    pub fn in_steps(&self, steps: f64) -> Path {
        let mut path = self.clone();
        let (Path::Sweep { from, to, step, .. } | Path::Circle { from, to, step, .. }) = &mut path;
        *step = (*to - *from).abs() / steps;
        path
    }

    /// Axes that move on the path.
    pub fn moving_axes(&self, machine: &Machine) -> Vec<usize> {
        match self {
            Path::Circle { plane, .. } => vec![plane.first, plane.second],
            Path::Sweep { axis, follow: Follow::None, .. } => vec![*axis],
            Path::Sweep { axis, .. } => {
                let linear = machine.axes_of(AxisKind::Linear);
                linear.chain([*axis]).collect()
            }
        }
    }

    /// Steps between the samples.
    fn steps(&self) -> usize {
        let [from, to] = self.ends();
        ((to - from).abs() / self.step().abs()).round().max(1.0) as usize
    }

    /// Way from sample to sample along a circle whose samples lie more than so many degrees apart, mm.
    pub(super) fn arc_mm(&self, samples: usize, beyond_deg: f64) -> Option<f64> {
        let Path::Circle { radius_mm, from, to, .. } = self else { return None };
        let step_deg = (to - from).abs() / samples.saturating_sub(1).max(1) as f64;
        (step_deg > beyond_deg).then(|| radius_mm * step_deg.to_radians())
    }

    /// Number of samples.
    pub fn sample_count(&self) -> usize {
        self.steps() + 1
    }

    /// Samples of the path parameter in file units.
    pub fn samples(&self) -> Vec<f64> {
        let ([from, to], count) = (self.ends(), self.steps());
        (0..=count).map(|k| from + (to - from) * k as f64 / count as f64).collect()
    }

    /// The same path from and to other samples.
    pub fn between(&self, first: f64, last: f64) -> Path {
        let mut path = self.clone();
        let (Path::Sweep { from, to, .. } | Path::Circle { from, to, .. }) = &mut path;
        (*from, *to) = (first, last);
        path
    }

    /// Unit direction of the bar in the turning frame, for a ball at lever `arm` from the axis line.
    pub fn bar_direction(follow: Follow, about: &Vector3<f64>, arm: &Vector3<f64>) -> Option<Vector3<f64>> {
        let radial = (arm - about * about.dot(arm)).try_normalize(1e-9);
        match follow {
            Follow::None => None,
            Follow::Axial => Some(*about),
            Follow::Radial => radial,
            Follow::Tangential => radial.map(|radial| about.cross(&radial)),
        }
    }
}
