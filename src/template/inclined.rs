//! A rotary axis that is inclined against the vertical, as in 45° heads and tables: its figures and its direction. Where it stands is `axes`'.

use nalgebra::Vector3;

/// Upright plane in which an axis is inclined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
    Yz,
    Zx,
}

impl Plane {
    pub const ALL: [Plane; 2] = [Plane::Yz, Plane::Zx];

    /// The plane through the vertical and the direction of a letter: of A and X that of x, of others that of y.
    pub fn of_letter(name: &str) -> Plane {
        if name == "A" { Plane::Zx } else { Plane::Yz }
    }

    pub fn name(self) -> &'static str {
        match self {
            Plane::Yz => "YZ",
            Plane::Zx => "ZX",
        }
    }

    /// Its level direction: y or x of R.
    pub fn level(self) -> Vector3<f64> {
        match self {
            Plane::Yz => Vector3::y(),
            Plane::Zx => Vector3::x(),
        }
    }

    /// The letter of its level direction.
    pub fn level_letter(self) -> &'static str {
        match self {
            Plane::Yz => "y",
            Plane::Zx => "x",
        }
    }
}

/// Which axis is inclined, how far and where to.
#[derive(Debug, Clone, PartialEq)]
pub struct Inclined {
    pub axis: String,
    /// From the vertical to the axis, degrees: positive with its upper end towards the plane's level direction.
    pub angle_deg: f64,
    pub plane: Plane,
}

impl Inclined {
    /// The axis's positive direction: with a positive part along the plane's level direction, as a level axis of that letter.
    pub fn direction(&self) -> Vector3<f64> {
        let (sin, cos) = self.angle_deg.to_radians().sin_cos();
        // + 0.0: no minus before a zero
        ((self.plane.level() * sin + Vector3::z() * cos) * sin.signum()).map(|part| part + 0.0)
    }

    /// Unit vector along the axis to its upper end.
    pub fn upward(&self) -> Vector3<f64> {
        let direction = self.direction();
        direction * direction.z.signum()
    }

    /// What is taken for granted of it, in a sentence: a data sheet has no offset.
    pub(super) fn assumed(&self) -> String {
        let side = if self.angle_deg > 0.0 { "+" } else { "-" };
        format!(
            "{} at {} deg from the vertical, its upper end towards {side}{}, is ASSUMED to cross the vertical through R; if it passes beside it, correct its origin in the file",
            self.axis,
            self.angle_deg.abs(),
            self.plane.level_letter()
        )
    }
}
