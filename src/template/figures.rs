//! Single figures of a data sheet: a table, a range, and how a figure is refused. Which are allowed is in `allowed`.

use super::inclined::Inclined;

/// Spindle ball below the nose, mm: a stem of a usual length.
pub const GAUGE_MM: f64 = 110.0;
/// Range of a rotary axis where none is given, deg: C, one that tilts, and an inclined one, which swivels by half a turn.
const USUAL_C_DEG: (f64, f64) = (-360.0, 360.0);
const USUAL_TILT_DEG: (f64, f64) = (-100.0, 100.0);
const USUAL_SWIVEL_DEG: (f64, f64) = (-5.0, 185.0);

/// Table of a data sheet, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TableSize {
    Disc {
        diameter: f64,
    },
    /// Along x and y.
    Rectangle {
        width: f64,
        depth: f64,
    },
}

impl TableSize {
    /// Half the sizes along x and y, mm.
    pub fn half(self) -> [f64; 2] {
        match self {
            TableSize::Disc { diameter } => [0.5 * diameter; 2],
            TableSize::Rectangle { width, depth } => [0.5 * width, 0.5 * depth],
        }
    }

    /// Radius of the circle that holds the table however it is turned, mm: to the corners of a rectangle.
    pub fn swept(self) -> f64 {
        match self {
            TableSize::Disc { diameter } => 0.5 * diameter,
            TableSize::Rectangle { width, depth } => (0.5 * width).hypot(0.5 * depth),
        }
    }
}

/// Why a data sheet makes no machine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct SizesError(pub String);

/// Whether a letter is that of a rotary axis.
pub fn is_rotary(name: &str) -> bool {
    matches!(name, "A" | "B" | "C")
}

/// Range of a rotary axis where none is given, degrees.
pub fn usual_range(name: &str, inclined: Option<&Inclined>) -> (f64, f64) {
    match inclined {
        Some(inclined) if inclined.axis == name => USUAL_SWIVEL_DEG,
        _ if name == "C" => USUAL_C_DEG,
        _ => USUAL_TILT_DEG,
    }
}

/// The sentence about a range that nobody stated, degrees.
pub(super) fn assumed_range(name: &str, range: (f64, f64), why: &str) -> String {
    format!(
        "range of {name}, {} to {} deg, is ASSUMED: {why}; check it and write the right one into the file",
        range.0, range.1
    )
}
