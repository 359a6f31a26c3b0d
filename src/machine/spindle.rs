//! The spindle as a machine file states it: where tools are clamped and which way they look.

use nalgebra::Vector3;

/// Where tools are clamped.
#[derive(Debug, Clone, PartialEq)]
pub struct SpindleSide {
    /// Name of the carrying link.
    pub link: String,
    /// Middle of the nose face, mm, in R with all axes at zero.
    pub nose: Vector3<f64>,
    /// From the tool tip into the spindle, unit length.
    pub direction: Vector3<f64>,
    /// From the nose to the spindle ball on the tool axis, mm.
    pub gauge_length_mm: f64,
}

impl SpindleSide {
    /// Spindle ball on the tool axis, mm.
    pub fn ball(&self) -> Vector3<f64> {
        self.nose - self.direction * self.gauge_length_mm
    }
}
