//! Figures of a data sheet, and the heights that follow from them.

use crate::machine::{Directions, StructuralCode};

/// Spindle ball below the nose, mm: a stem of a usual length.
pub const GAUGE_MM: f64 = 110.0;
/// Least height of the reference point above the table, mm: a cup on the lowest stand.
const LOWEST_MM: f64 = 75.0;

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
}

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
    /// Ranges by axis name, where they are not the usual ones.
    pub ranges: Vec<(String, (f64, f64))>,
    /// Tilting axis of a table above its top; below is negative.
    pub tilt_above_table: f64,
    /// Tilting axis of a head above the spindle nose.
    pub pivot_above_nose: f64,
    /// Diameter of the spindle housing.
    pub housing: f64,
    /// An angle plate beside the table: it takes a cup for the tilting axis of a head.
    pub has_angle_plate: bool,
}

/// Why a data sheet makes no machine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct SizesError(pub String);

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
        let refuse = |says: String| Err(SizesError(says));
        let code = &self.code;
        for name in code.axis_names() {
            if !"XYZABC".contains(name.as_str()) || name.len() != 1 {
                return refuse(format!(
                    "axis '{name}' of {code}: the template knows X, Y, Z, A, B and C; write the machine file by hand, as docs/formats.md shows"
                ));
            }
        }
        let (turning, sliding) =
            (rotary(&code.workpiece_side).len() + rotary(&code.tool_side).len(), code.axis_names().count());
        if turning != 2 || sliding != 5 {
            return refuse(format!(
                "{code} has {} linear and {turning} rotary axes; the template makes machines with X, Y, Z and two of A, B, C",
                sliding - turning
            ));
        }
        let lengths = [
            ("travel of X", self.travels[0]),
            ("travel of Y", self.travels[1]),
            ("travel of Z", self.travels[2]),
            ("half the table along x", self.table.half()[0]),
            ("half the table along y", self.table.half()[1]),
            ("housing", self.housing),
        ];
        for (what, length) in lengths {
            if !(10.0..=20_000.0).contains(&length) {
                return refuse(format!("{what} is {length} mm; allowed are 10 to 20,000 mm"));
            }
        }
        for (what, height) in [
            ("tilting axis above the table", self.tilt_above_table),
            ("tilting axis above the nose", self.pivot_above_nose),
        ] {
            if !(-2000.0..=2000.0).contains(&height) {
                return refuse(format!("{what} is {height} mm; allowed are -2000 to 2000 mm"));
            }
        }
        if !rotary(&code.tool_side).is_empty() && self.pivot_above_nose < 0.5 * self.housing {
            return refuse(format!(
                "the tilting axis of the head is {} mm above the nose; give --pivot-to-nose, from the nose up to the axis about which the head tilts",
                self.pivot_above_nose
            ));
        }
        let (nearest, farthest) = self.nose_to_table;
        if !(0.0 <= nearest && nearest < farthest && farthest <= 20_000.0) {
            return refuse(format!(
                "nose to table is {nearest}..{farthest} mm; allowed is a smaller and a larger distance of 0 to 20,000 mm"
            ));
        }
        if (farthest - nearest - self.travels[2]).abs() > 0.02 * self.travels[2] + 1.0 {
            return refuse(format!(
                "nose to table goes from {nearest} to {farthest} mm, which is a travel of {} mm, and Z is said to travel {} mm: look in the data sheet which is right",
                farthest - nearest,
                self.travels[2]
            ));
        }
        // zero of Z within its travel, where a cup on the lowest stand has room if the machine has it
        let lowest = (nearest - GAUGE_MM).max(LOWEST_MM);
        let table_top = -lowest.min(farthest - GAUGE_MM);
        if table_top > -1.0 {
            return refuse(format!(
                "the nose reaches {farthest} mm above the table at most; a ball on a stem of {GAUGE_MM} mm has no room there"
            ));
        }
        Ok(Frame {
            table_top,
            z_range: (nearest - GAUGE_MM + table_top, farthest - GAUGE_MM + table_top),
            table_tilt: table_top + self.tilt_above_table,
            head_tilt: GAUGE_MM + self.pivot_above_nose,
        })
    }

    /// Range of a rotary axis, degrees.
    pub fn range_of(&self, name: &str) -> (f64, f64) {
        let usual = match name {
            "C" => (-360.0, 360.0),
            _ => (-100.0, 100.0),
        };
        self.ranges.iter().find(|(axis, _)| axis == name).map_or(usual, |(_, range)| *range)
    }
}

fn rotary(side: &[String]) -> Vec<&str> {
    side.iter().map(String::as_str).filter(|name| matches!(*name, "A" | "B" | "C")).collect()
}
