//! Figures of a data sheet, and the heights that follow from them. Which figures are allowed is in `allowed`.

use super::allowed;
use super::figures::{GAUGE_MM, SizesError, TableSize, assumed_range, is_rotary, usual_range};
use super::inclined::Inclined;
use crate::machine::{Directions, StructuralCode};

/// Least height of the reference point above the table, mm: a cup on the lowest stand.
const LOWEST_MM: f64 = 75.0;

/// What a data sheet says; lengths in mm, angles in degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct Sizes {
    pub name: String,
    pub code: StructuralCode,
    pub directions: Directions,
    /// Travels of X, Y and Z.
    pub travels: [f64; 3],
    /// Smallest and largest distance between spindle nose and table top.
    pub nose_to_table: (f64, f64),
    pub table: TableSize,
    /// Ranges of rotary axes by name, as given; the others are assumed.
    pub ranges: Vec<(String, (f64, f64))>,
    /// The rotary axis that is inclined against the vertical.
    pub inclined: Option<Inclined>,
    /// Tilting axis of a table above its top, an inclined one where it crosses the vertical; below is negative.
    pub tilt_above_table: f64,
    /// Tilting axis of a head above the spindle nose, an inclined one where it crosses the spindle's line.
    pub pivot_above_nose: f64,
    /// Diameter of the spindle housing.
    pub housing: f64,
    /// An angle plate beside the table: it takes a cup for the tilting axis of a head.
    pub has_angle_plate: bool,
}

/// Heights and ranges in the frame R.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Table top, mm; R is above it.
    pub table_top: f64,
    /// Range of Z, mm.
    pub z_range: (f64, f64),
    /// Height of the tilting axis of a table, and of a head, mm.
    pub table_tilt: f64,
    pub head_tilt: f64,
}

impl Sizes {
    /// Letters of the rotary axes on the workpiece side, from the workpiece on.
    pub fn turning_on_table(&self) -> Vec<&str> {
        rotary(&self.code.workpiece_side)
    }

    /// Letters of the rotary axes on the tool side, from the bed on.
    pub fn turning_on_head(&self) -> Vec<&str> {
        rotary(&self.code.tool_side)
    }

    /// Heights that follow from the distances between nose and table.
    pub fn frame(&self) -> Result<Frame, SizesError> {
        allowed::code(&self.code)?;
        if let Some(inclined) = &self.inclined {
            allowed::inclined(inclined, &self.code)?;
        }
        allowed::travels(self.travels)?;
        allowed::table(self.table)?;
        allowed::housing(self.housing)?;
        allowed::tilt_above_table(self.tilt_above_table)?;
        if self.turning_on_head().iter().any(|axis| *axis != "C") {
            allowed::pivot_above_nose(self.pivot_above_nose, self.housing)?;
        }
        allowed::distances(self.nose_to_table, self.travels[2])?;
        let (nearest, farthest) = self.nose_to_table;
        // zero of Z within its travel, where a cup on the lowest stand has room if the machine has it
        let lowest = (nearest - GAUGE_MM).max(LOWEST_MM);
        let table_top = -lowest.min(farthest - GAUGE_MM);
        Ok(Frame {
            table_top,
            z_range: (nearest - GAUGE_MM + table_top, farthest - GAUGE_MM + table_top),
            table_tilt: table_top + self.tilt_above_table,
            head_tilt: GAUGE_MM + self.pivot_above_nose,
        })
    }

    /// Range of a rotary axis, degrees.
    pub fn range_of(&self, name: &str) -> (f64, f64) {
        self.ranges.iter().find(|(axis, _)| axis == name).map_or_else(|| self.usual_range(name), |(_, range)| *range)
    }

    /// Range that is assumed of a rotary axis, degrees.
    fn usual_range(&self, name: &str) -> (f64, f64) {
        usual_range(name, self.inclined.as_ref())
    }

    /// How an axis is inclined; `None` of one along a coordinate direction.
    pub fn inclined_axis(&self, name: &str) -> Option<&Inclined> {
        self.inclined.as_ref().filter(|inclined| inclined.axis == name)
    }

    /// What no figure was given for: a sentence for each range, and one for the place of an inclined axis.
    pub fn assumed(&self) -> Vec<String> {
        let turning = self.code.axis_names().filter(|name| is_rotary(name));
        let open = turning.filter(|name| !self.ranges.iter().any(|(axis, _)| axis == *name));
        let ranges = open.map(|name| assumed_range(name, self.usual_range(name), "no range was given"));
        ranges.chain(self.inclined.as_ref().map(Inclined::assumed)).collect()
    }
}

fn rotary(side: &[String]) -> Vec<&str> {
    side.iter().map(String::as_str).filter(|name| is_rotary(name)).collect()
}
