//! Solids that stand for a machine of a data sheet: table, cradle, slides, bed, housing, head, fork. None is a drawing.

use nalgebra::Vector3;

use super::figures::{GAUGE_MM, TableSize, is_rotary};
use super::parts::{GAP_MM, PLATE_MM, TABLE_MM, add, brick, carrier};
use super::sizes::{Frame, Sizes};
use super::swivel::{SwivelTable, swivel_head};
use crate::bodies::{Bodies, Body, Mount, Outline};

/// Thickness of a cradle's arms and of a slide, mm.
const ARM_MM: f64 = 70.0;
const SLIDE_MM: f64 = 80.0;
/// Angle plate: thickness, width, height above the table top, mm.
const ANGLE_PLATE_MM: [f64; 3] = [60.0, 300.0, 450.0];

/// Bodies and the table's surface.
pub fn bodies(sizes: &Sizes, frame: &Frame) -> Bodies {
    let mut all = Bodies::default();
    let below = workpiece_side(&mut all, sizes, frame);
    let link = all.mounts.first().map_or("b".to_string(), |mount| mount.link.clone());
    tool_side(&mut all, sizes, frame);
    if sizes.has_angle_plate {
        angle_plate(&mut all, sizes, frame, &link, below);
    }
    // what one link carries is never compared
    let link_of = |name: &String| all.bodies.iter().find(|body| body.name == *name).map(|body| body.link.clone());
    let joined = std::mem::take(&mut all.touching);
    let touching = joined.into_iter().filter(|(one, other)| link_of(one) != link_of(other)).collect();
    all.touching = touching;
    all
}

/// Letter of the axis that tilts, and its direction where it is level.
fn tilting<'s>(turning: &[&'s str]) -> Option<(&'s str, Vector3<f64>)> {
    let letter = turning.iter().copied().find(|name| matches!(*name, "A" | "B"))?;
    Some((letter, if letter == "A" { Vector3::x() } else { Vector3::y() }))
}

/// Table, cradle and slides down to the bed; returns the height of what lies under the table, mm.
fn workpiece_side(all: &mut Bodies, sizes: &Sizes, frame: &Frame) -> f64 {
    let outward: Vec<String> = sizes.code.workpiece_side.iter().rev().cloned().collect();
    let table_link = outward.last().cloned().unwrap_or_else(|| "b".into());
    let top = frame.table_top;
    let under = top - TABLE_MM;
    let half = sizes.table.half();
    match sizes.table {
        TableSize::Disc { diameter } => {
            all.bodies.push(Body::upright("work table", &table_link, under, top, 0.5 * diameter))
        }
        TableSize::Rectangle { width, depth } => {
            all.bodies.push(brick(
                "work table",
                &table_link,
                [0.0, 0.0, 0.5 * (under + top)],
                [width, depth, TABLE_MM],
            ));
        }
    }
    all.mounts.push(Mount {
        name: "table top".into(),
        link: table_link.clone(),
        middle: Vector3::z() * top,
        normal: Vector3::z(),
        along: Vector3::x(),
        outline: match sizes.table {
            TableSize::Disc { diameter } => Outline::Disc { inner_radius_mm: 0.0, radius_mm: 0.5 * diameter },
            TableSize::Rectangle { width, depth } => Outline::Rectangle { size_mm: [width, depth] },
        },
        slot_pitch_mm: None,
    });
    let turning = sizes.turning_on_table();
    let swivel = swivel_table(sizes, frame);
    let (mut height, mut link, mut last) = match (tilting(&turning), &swivel) {
        (_, Some(swivel)) => {
            let below = &swivel.base_link;
            let link = if is_rotary(below) { carrier(&outward, below) } else { below.clone() };
            (swivel.floor, link, swivel.add(all))
        }
        (Some((letter, along)), None) if turning.len() == 2 && table_link != letter => {
            let (carrier, radius) = (carrier(&outward, letter), sizes.table.swept());
            let cradle = Cradle { letter, along, carrier, radius, under, axis: frame.table_tilt };
            cradle.add(all)
        }
        // the table turns or tilts on what carries it, or stands on it
        _ => {
            let reach = tilting(&turning).map_or(GAP_MM, |_| half[0].hypot(half[1]));
            let own =
                if turning.is_empty() { table_link.clone() } else { carrier(&outward, turning[turning.len() - 1]) };
            (under - reach, own, vec!["work table".to_string()])
        }
    };
    // slides under it, each on the next, down to the bed
    let mut wide = slide_under(sizes, &turning);
    let reach = swivel.map_or(0.0, |swivel| swivel.reach());
    wide = wide.map(|wide| wide.max(2.0 * reach + 60.0));
    loop {
        let name = if link == "b" { "bed".to_string() } else { format!("{link} slide") };
        let thick = if link == "b" { 3.0 * SLIDE_MM } else { SLIDE_MM };
        let size = [wide[0], wide[1], thick];
        if all.bodies.iter().any(|body| body.name == name) {
            break;
        }
        all.bodies.push(brick(&name, &link, [0.0, 0.0, height - 0.5 * thick], size));
        all.touching.extend(last.iter().map(|above| (above.clone(), name.clone())));
        if link == "b" {
            break;
        }
        last = vec![name];
        height -= thick;
        // the next one is as long as this one's way
        let way = if link == "X" { 0 } else { 1 };
        wide[way] += sizes.travels[way];
        link = carrier(&outward, &link);
    }
    under
}

/// What stands under the table where one of its axes is inclined.
fn swivel_table(sizes: &Sizes, frame: &Frame) -> Option<SwivelTable> {
    let turning = sizes.turning_on_table();
    let inclined = turning.iter().find_map(|name| sizes.inclined_axis(name))?;
    Some(SwivelTable::of(sizes, frame, inclined))
}

/// Sizes along x and y of the slide under the table, mm: as wide as what stands on it.
fn slide_under(sizes: &Sizes, turning: &[&str]) -> [f64; 2] {
    let half = if turning.is_empty() { sizes.table.half() } else { [sizes.table.swept(); 2] };
    let bearings = 2.0 * ARM_MM + 240.0;
    match tilting(turning) {
        // the bearings of a cradle stand along its axis
        Some(("B", _)) => [2.0 * half[0] + 60.0, 2.0 * half[1] + bearings],
        _ => [2.0 * half[0] + bearings, 2.0 * half[1] + 60.0],
    }
}

/// A plate under the table, two arms beside it and the bearings that carry them.
struct Cradle<'s> {
    letter: &'s str,
    along: Vector3<f64>,
    carrier: String,
    /// Circle that the table sweeps as it turns on the cradle, mm: the arms stand outside.
    radius: f64,
    /// Underside of the table and height of the axis, mm.
    under: f64,
    axis: f64,
}

impl Cradle<'_> {
    /// Adds it; returns the height of what carries it, its link, and the bodies that stand on that.
    fn add(&self, all: &mut Bodies) -> (f64, String, Vec<String>) {
        let across = Vector3::z().cross(&self.along);
        let radius = self.radius;
        let low = self.under - PLATE_MM;
        let wide = 1.5 * radius;
        let place = |aside: f64, height: f64| self.along * aside + Vector3::z() * height;
        let size = |along: f64, across_mm: f64, up: f64| {
            (self.along * along + across.abs() * across_mm + Vector3::z() * up).abs()
        };
        let arm = radius + GAP_MM + 0.5 * ARM_MM;
        let top = self.axis.max(self.under) + 60.0;
        add(
            all,
            "cradle plate",
            self.letter,
            place(0.0, low + 0.5 * PLATE_MM),
            size(2.0 * (arm + 0.5 * ARM_MM), wide, PLATE_MM),
        );
        let bearing = arm + 0.5 * ARM_MM + GAP_MM + 50.0;
        // farthest below the axis that cradle and table swing
        let table = radius.hypot(self.axis - self.under).max(radius.hypot(self.under + TABLE_MM - self.axis));
        let swing = (0.5 * wide).hypot(self.axis - low).max(table);
        let floor = self.axis - swing - 2.0 * GAP_MM;
        let mut standing = Vec::new();
        for (side, sign) in [("left", -1.0), ("right", 1.0)] {
            let (arm_name, block) = (format!("cradle arm {side}"), format!("bearing block {side}"));
            add(all, &arm_name, self.letter, place(sign * arm, 0.5 * (low + top)), size(ARM_MM, 0.5 * wide, top - low));
            let block_top = self.axis + 80.0;
            add(
                all,
                &block,
                &self.carrier,
                place(sign * bearing, 0.5 * (floor + block_top)),
                size(100.0, 200.0, block_top - floor),
            );
            all.touching.push((arm_name, block.clone()));
            standing.push(block);
        }
        all.touching.push(("work table".into(), "cradle plate".into()));
        (floor, self.carrier.clone(), standing)
    }
}

/// Spindle housing and what carries it.
fn tool_side(all: &mut Bodies, sizes: &Sizes, frame: &Frame) {
    let outward = &sizes.code.tool_side;
    let last = outward.last().cloned().unwrap_or_else(|| "b".into());
    let (radius, nose) = (0.5 * sizes.housing, GAUGE_MM);
    let turning = sizes.turning_on_head();
    match (tilting(&turning), sizes.inclined_axis(&last)) {
        (_, Some(inclined)) => swivel_head(all, sizes, frame, inclined),
        // the spindle tilts between the arms of a fork
        (Some((letter, along)), None) if last == letter => {
            let axis = frame.head_tilt;
            all.bodies.push(Body::upright("spindle housing", &last, nose, axis + radius, radius));
            let crown = axis + (2.0 * radius).max(radius + 80.0);
            let aside = radius + GAP_MM + 25.0;
            let across = Vector3::z().cross(&along).abs();
            let fork = carrier(outward, letter);
            for (side, sign) in [("left", -1.0), ("right", 1.0)] {
                let name = format!("fork arm {side}");
                let middle = along * (sign * aside) + Vector3::z() * (0.5 * (axis - radius + crown));
                add(
                    all,
                    &name,
                    &fork,
                    middle,
                    (along * 50.0 + across * (1.6 * radius) + Vector3::z() * (crown - axis + radius)).abs(),
                );
                all.touching.push(("spindle housing".into(), name));
            }
            let wide = 2.0 * (aside + 25.0);
            add(all, "fork crown", &fork, Vector3::z() * (crown + 50.0), Vector3::new(wide, wide, 100.0));
            let ram = if fork == "C" { carrier(outward, "C") } else { fork.clone() };
            add(all, "ram", &ram, Vector3::z() * (crown + 100.0 + 250.0), Vector3::new(1.2 * wide, 1.2 * wide, 500.0));
            if ram != fork {
                all.touching.push(("fork crown".into(), "ram".into()));
            }
        }
        _ => {
            let high = nose + 2.4 * radius;
            all.bodies.push(Body::upright("spindle housing", &last, nose, high, radius));
            let wide = 3.0 * radius;
            if turning.is_empty() {
                add(all, "head", &last, Vector3::z() * (high + 200.0), Vector3::new(wide, wide, 400.0));
            }
        }
    }
}

/// A plate behind the table that looks along the tilting axis of the head, for the cup that its test needs.
fn angle_plate(all: &mut Bodies, sizes: &Sizes, frame: &Frame, table_link: &str, under: f64) {
    let Some((letter, level)) = tilting(&sizes.turning_on_head()) else { return };
    // the level way of an inclined axis, from its lower end on
    let along =
        sizes.inclined_axis(letter).map_or(level, |inclined| inclined.plane.level() * inclined.angle_deg.signum());
    let outward: Vec<String> = sizes.code.workpiece_side.iter().rev().cloned().collect();
    let turning = sizes.turning_on_table();
    // beside a table that turns, on what carries it
    let link = turning.last().map_or(table_link.to_string(), |name| carrier(&outward, name));
    let half = sizes.table.half();
    let [thick, wide, high] = ANGLE_PLATE_MM;
    let reach = if turning.is_empty() {
        along.x.abs() * half[0] + along.y.abs() * half[1] - thick - 10.0
    } else {
        let base = swivel_table(sizes, frame).map_or(0.0, |swivel| swivel.reach());
        half[0].hypot(half[1]).max(base) + 40.0
    };
    let foot = if turning.is_empty() { frame.table_top } else { under - GAP_MM };
    let middle = along * (reach + 0.5 * thick) + Vector3::z() * (0.5 * (foot + frame.table_top + high));
    let across = Vector3::z().cross(&along).abs();
    let tall = frame.table_top + high - foot;
    add(all, "angle plate", &link, middle, along.abs() * thick + across * wide + Vector3::z() * tall);
    let under_it = if turning.is_empty() {
        "work table".to_string()
    } else if link == "b" {
        "bed".into()
    } else {
        format!("{link} slide")
    };
    all.touching.push(("angle plate".into(), under_it));
    let face_low = frame.table_top + 20.0;
    let face_high = frame.table_top + high - 10.0;
    all.mounts.push(Mount {
        name: "angle plate face".into(),
        link,
        middle: along * reach + Vector3::z() * (0.5 * (face_low + face_high)),
        normal: -along,
        along: across,
        outline: Outline::Rectangle { size_mm: [wide - 20.0, face_high - face_low] },
        slot_pitch_mm: None,
    });
}
