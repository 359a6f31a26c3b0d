//! The machine that stands for a topology: one set of travels, one table, one spindle, angle plates where a head tilts. It plans nothing.

use nalgebra::{Matrix3, Vector3};

use crate::bodies::{Bodies, Body, Mount, Outline, Solid};
use crate::chain::Pose;
use crate::machine::{Axis, AxisKind, Directions, Machine, SpindleSide, StructuralCode, letter_axis};

/// The envelope in words, for the report.
pub const ENVELOPE: &str = "X, Y and Z travel ±400 mm, A and B ±110°, C ±360°. Axes of the table meet in the spindle's \
reference point R, A and B of a head stand 200 mm above it. Table: a disc of 400 mm, its top 110 mm below R, on the last \
link of the workpiece side. Spindle housing: 140 mm wide, its nose 110 mm above R, on the last link of the tool side. An \
angle plate stands 420 mm beside R for each of A and B on the tool side, facing along that axis, on the last link of the \
workpiece side that no rotary axis carries. Nothing else stands in the way.";

/// Travel of a linear axis either way, mm.
const TRAVEL_MM: f64 = 400.0;
/// Travel of A and B either way, deg.
const TILT_DEG: f64 = 110.0;
/// Travel of C either way, deg.
const TURN_DEG: f64 = 360.0;
/// A and B of a head above the reference point, mm.
const HEAD_MM: f64 = 200.0;
/// Table: top below the reference point, thickness, radius, mm.
const TABLE_TOP_MM: f64 = -110.0;
const TABLE_THICK_MM: f64 = 40.0;
const TABLE_RADIUS_MM: f64 = 200.0;
/// Spindle nose above the reference point, length and radius of the housing, mm.
const NOSE_MM: f64 = 110.0;
const HOUSING_MM: f64 = 170.0;
const HOUSING_RADIUS_MM: f64 = 70.0;
/// Angle plate: face beside the reference point, thickness, width, lower and upper end, mm.
const PLATE_MM: f64 = 420.0;
const PLATE_THICK_MM: f64 = 60.0;
const PLATE_WIDTH_MM: f64 = 300.0;
const PLATE_Z_MM: [f64; 2] = [-200.0, 340.0];

/// Machine and bodies of a topology.
pub fn envelope(code: &StructuralCode) -> (Machine, Bodies) {
    let axes = code.axis_names().enumerate().map(|(place, name)| axis(name, !code.carries_workpiece(place))).collect();
    let machine = Machine::plain(format!("Survey envelope {code}"), code.clone(), Directions::Iso841, axes);
    let up = Vector3::z();
    let spindle = SpindleSide { link: "t".into(), nose: up * NOSE_MM, direction: up, gauge_length_mm: NOSE_MM };
    (Machine { spindle: Some(spindle), ..machine }, bodies(code))
}

fn axis(name: &str, on_tool_side: bool) -> Axis {
    // codes of these machines have letters alone
    let (kind, direction) = letter_axis(name).unwrap_or((AxisKind::Rotary, Vector3::z()));
    let reach = match (kind, name) {
        (AxisKind::Linear, _) => TRAVEL_MM,
        (AxisKind::Rotary, "C") => TURN_DEG.to_radians(),
        (AxisKind::Rotary, _) => TILT_DEG.to_radians(),
    };
    let tilts = matches!(name, "A" | "B");
    let origin = if on_tool_side && tilts { Vector3::new(0.0, 0.0, HEAD_MM) } else { Vector3::zeros() };
    Axis {
        name: name.to_string(),
        kind,
        direction,
        origin,
        range: Some((-reach, reach)),
        reversed: false,
        location_errors: [0.0; 6],
        component_errors: Vec::new(),
    }
}

fn bodies(code: &StructuralCode) -> Bodies {
    let up = Vector3::z();
    let mut all = Bodies {
        bodies: vec![
            Body::upright("table", "w", TABLE_TOP_MM - TABLE_THICK_MM, TABLE_TOP_MM, TABLE_RADIUS_MM),
            Body::upright("spindle housing", "t", NOSE_MM, NOSE_MM + HOUSING_MM, HOUSING_RADIUS_MM),
        ],
        mounts: vec![Mount {
            name: "table top".into(),
            link: "w".into(),
            middle: up * TABLE_TOP_MM,
            normal: up,
            along: Vector3::x(),
            outline: Outline::Disc { inner_radius_mm: 0.0, radius_mm: TABLE_RADIUS_MM },
            slot_pitch_mm: None,
        }],
        touching: Vec::new(),
    };
    let link = beside_the_table(code);
    for (letter, along) in [("A", Vector3::x()), ("B", Vector3::y())] {
        if code.tool_side.iter().any(|name| name == letter) {
            add_plate(&mut all, &format!("angle plate for {letter}"), &link, along);
        }
    }
    all
}

/// The last link of the workpiece side that no rotary axis carries.
fn beside_the_table(code: &StructuralCode) -> String {
    let from_bed = code.workpiece_side.iter().rev();
    from_bed.take_while(|name| matches!(name.as_str(), "X" | "Y" | "Z")).last().cloned().unwrap_or_else(|| "b".into())
}

/// An angle plate whose face looks back along `along`.
fn add_plate(all: &mut Bodies, name: &str, link: &str, along: Vector3<f64>) {
    let [low, high] = PLATE_Z_MM;
    let middle = along * PLATE_MM + Vector3::z() * (0.5 * (low + high));
    let across = Vector3::z().cross(&along).abs();
    all.bodies.push(Body {
        name: name.to_string(),
        link: link.to_string(),
        solids: vec![Solid::Box {
            half_mm: along * (0.5 * PLATE_THICK_MM)
                + across * (0.5 * PLATE_WIDTH_MM)
                + Vector3::z() * (0.5 * (high - low)),
        }],
        at: Pose { rotation: Matrix3::identity(), translation_mm: middle + along * (0.5 * PLATE_THICK_MM) },
    });
    all.mounts.push(Mount {
        name: format!("{name}, face"),
        link: link.to_string(),
        middle,
        normal: -along,
        along: across,
        outline: Outline::Rectangle { size_mm: [PLATE_WIDTH_MM - 20.0, high - low - 20.0] },
        slot_pitch_mm: None,
    });
}
