//! Which figures of a data sheet make a machine, one question each; the refusals say what is allowed. It computes no machine.

use super::figures::{GAUGE_MM, SizesError, TableSize, is_rotary};
use super::inclined::Inclined;
use crate::machine::StructuralCode;

/// Lengths of a machine, mm.
const LENGTHS_MM: std::ops::RangeInclusive<f64> = 10.0..=20_000.0;
/// Heights of a tilting axis, mm.
const HEIGHTS_MM: std::ops::RangeInclusive<f64> = -2000.0..=2000.0;
/// Angles of an inclined axis from the vertical to either side, degrees.
const INCLINED_DEG: std::ops::RangeInclusive<f64> = 5.0..=85.0;
/// Largest distance between nose and table, mm.
const FARTHEST_MM: f64 = 20_000.0;
/// Distances and travel of a sheet differ by rounding: part of the travel, and mm.
const ROUNDING: (f64, f64) = (0.02, 1.0);
/// Least height of the spindle ball above the table where the nose is highest, mm.
const ROOM_MM: f64 = 1.0;

fn refuse(says: String) -> Result<(), SizesError> {
    Err(SizesError(says))
}

/// X, Y, Z and two of A, B, C.
pub fn code(code: &StructuralCode) -> Result<(), SizesError> {
    for name in code.axis_names() {
        if !"XYZABC".contains(name.as_str()) || name.len() != 1 {
            return refuse(format!(
                "axis '{name}' of {code}: the template knows X, Y, Z, A, B and C; write the machine file by hand, as docs/formats.md shows"
            ));
        }
    }
    let all = code.axis_names().count();
    let turning = code.axis_names().filter(|name| is_rotary(name)).count();
    if turning != 2 || all != 5 {
        return refuse(format!(
            "{code} has {} linear and {turning} rotary axes; the template makes machines with X, Y, Z and two of A, B, C",
            all - turning
        ));
    }
    Ok(())
}

/// An axis of the code that tilts, at an angle at which it is neither upright nor level.
pub fn inclined(inclined: &Inclined, code: &StructuralCode) -> Result<(), SizesError> {
    let Inclined { axis, angle_deg, .. } = inclined;
    let tilting: Vec<&str> = code.axis_names().map(String::as_str).filter(|name| matches!(*name, "A" | "B")).collect();
    if !tilting.contains(&axis.as_str()) {
        return refuse(format!(
            "'{axis}' cannot be the inclined axis of {code}; allowed is the axis that tilts, {}",
            tilting.join(" or ")
        ));
    }
    inclination(*angle_deg)
}

/// Angle from the vertical to an inclined axis, degrees.
pub fn inclination(angle_deg: f64) -> Result<(), SizesError> {
    if INCLINED_DEG.contains(&angle_deg.abs()) {
        return Ok(());
    }
    let degrees = angle_deg.to_degrees();
    let radians = match INCLINED_DEG.contains(&degrees.abs()) {
        true => format!("; were {angle_deg} radians, it would be {degrees:.1} deg"),
        false => String::new(),
    };
    refuse(format!(
        "{angle_deg} deg from the vertical is no inclined axis; allowed are 5 to 85 deg to either side, -85..-5 and 5..85: an upright axis is C, a level one A or B{radians}"
    ))
}

/// Travels of X, Y and Z, mm.
pub fn travels(travels: [f64; 3]) -> Result<(), SizesError> {
    let [x, y, z] = travels;
    lengths(&[("travel of X", x), ("travel of Y", y), ("travel of Z", z)])
}

/// Sizes of a table.
pub fn table(table: TableSize) -> Result<(), SizesError> {
    let [x, y] = table.half();
    lengths(&[("half the table along x", x), ("half the table along y", y)])
}

/// Diameter of the spindle housing, mm.
pub fn housing(diameter: f64) -> Result<(), SizesError> {
    lengths(&[("housing", diameter)])
}

fn lengths(named: &[(&str, f64)]) -> Result<(), SizesError> {
    match named.iter().find(|(_, length)| !LENGTHS_MM.contains(length)) {
        Some((what, length)) => refuse(format!("{what} is {length} mm; allowed are 10 to 20,000 mm")),
        None => Ok(()),
    }
}

/// Tilting axis of a table above its top, mm.
pub fn tilt_above_table(height: f64) -> Result<(), SizesError> {
    height_of("tilting axis above the table", height)
}

/// Tilting axis of a head above the spindle nose, mm.
pub fn pivot_above_nose(height: f64, housing: f64) -> Result<(), SizesError> {
    height_of("tilting axis above the nose", height)?;
    if height < 0.5 * housing {
        return refuse(format!(
            "the tilting axis of the head is {height} mm above the nose; allowed is at least half the spindle housing, {} mm; give --pivot-to-nose, from the nose up to the axis about which the head tilts",
            0.5 * housing
        ));
    }
    Ok(())
}

fn height_of(what: &str, height: f64) -> Result<(), SizesError> {
    if !HEIGHTS_MM.contains(&height) {
        return refuse(format!("{what} is {height} mm; allowed are -2000 to 2000 mm"));
    }
    Ok(())
}

/// Smallest and largest distance between nose and table, beside the travel of Z, mm.
pub fn distances((nearest, farthest): (f64, f64), z_travel: f64) -> Result<(), SizesError> {
    if !(0.0 <= nearest && nearest < farthest && farthest <= FARTHEST_MM) {
        return refuse(format!(
            "nose to table is {nearest}..{farthest} mm; allowed is a smaller and a larger distance of 0 to 20,000 mm"
        ));
    }
    let travel = farthest - nearest;
    if (travel - z_travel).abs() > ROUNDING.0 * z_travel + ROUNDING.1 {
        return refuse(format!(
            "nose to table goes from {nearest} to {farthest} mm, which is a travel of {travel} mm, and Z is said to travel {z_travel} mm: look in the data sheet which is right"
        ));
    }
    if farthest - GAUGE_MM < ROOM_MM {
        return refuse(format!(
            "the nose reaches {farthest} mm above the table at most; a ball on a stem of {GAUGE_MM} mm has no room there"
        ));
    }
    Ok(())
}
