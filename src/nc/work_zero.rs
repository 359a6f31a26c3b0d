//! Where the zero of the machine file is on the machine: what stands where with all axes at zero. It says what the file tells, no more.

use nalgebra::Vector3;

use crate::bodies::{Bodies, Mount};
use crate::chain::{Branch, Chain};
use crate::machine::{AxisKind, Machine, SpindleSide};

/// Directions that differ by less are one; its square root is the angle, rad.
const SAME_DIRECTION: f64 = 1e-9;
/// Distances below this are none, mm: half of the last of three decimals.
const NONE_MM: f64 = 5e-4;

/// Where zero is, a sentence each: `Z 0: spindle nose 185.000 mm above table top`. Nothing where the file states no spindle.
pub fn zero_words(machine: &Machine, bodies: &Bodies) -> Vec<String> {
    let Some(spindle) = &machine.spindle else { return Vec::new() };
    let turning = turning_on_the_table_side(machine);
    let mut along = Vec::new();
    let mut across = Vec::new();
    for mount in &bodies.mounts {
        if is_parallel(&mount.normal, &spindle.direction) {
            along.push(format!("spindle nose {}", over_surface(machine, mount, spindle)));
        } else if is_square(&mount.normal, &spindle.direction) {
            across.push(format!("line of the spindle {}", over_surface(machine, mount, spindle)));
        }
    }
    for &axis in &turning {
        let name = &machine.axes[axis].name;
        let off = spindle.nose - machine.axes[axis].origin;
        if is_parallel(&machine.axes[axis].direction, &spindle.direction) {
            across.push(over(&off, &spindle.direction, &format!("the line of {name}")));
        } else if is_square(&machine.axes[axis].direction, &spindle.direction) {
            let side = side(machine, off.dot(&spindle.direction), &spindle.direction);
            along.push(format!("spindle nose {side} the line of {name}"));
        }
    }
    // without a table that turns about the spindle's direction the middle of the surface says where it stands
    if !turning.iter().any(|&axis| is_parallel(&machine.axes[axis].direction, &spindle.direction)) {
        let facing = bodies.mounts.iter().filter(|mount| is_parallel(&mount.normal, &spindle.direction));
        across.extend(facing.map(|mount| {
            over(&(spindle.nose - mount.middle), &spindle.direction, &format!("the middle of {}", mount.name))
        }));
    }
    let slides = |is_such: fn(&Vector3<f64>, &Vector3<f64>) -> bool| {
        let such = |axis: &&crate::machine::Axis| {
            axis.kind == AxisKind::Linear && is_such(&axis.direction, &spindle.direction)
        };
        let mut names: Vec<String> = machine.axes.iter().filter(such).map(|axis| format!("{} 0", axis.name)).collect();
        names.sort();
        names.join(" ")
    };
    let mut words = Vec::new();
    for (names, facts) in [(slides(is_parallel), along), (slides(is_square), across)] {
        let names = if names.is_empty() { "all axes at 0" } else { &names };
        words.extend(facts.into_iter().map(|fact| format!("{names}: {fact}")));
    }
    words
}

/// Rotary axes that carry the workpiece.
fn turning_on_the_table_side(machine: &Machine) -> Vec<usize> {
    let chain = Chain::of(machine);
    let branch = chain.branch(Branch::Workpiece).iter().rev();
    branch.copied().filter(|&axis| machine.axes[axis].kind == AxisKind::Rotary).collect()
}

fn is_parallel(one: &Vector3<f64>, other: &Vector3<f64>) -> bool {
    one.cross(other).norm_squared() < SAME_DIRECTION
}

fn is_square(one: &Vector3<f64>, other: &Vector3<f64>) -> bool {
    one.dot(other).powi(2) < SAME_DIRECTION
}

/// `185.000 mm above table top`.
fn over_surface(machine: &Machine, mount: &Mount, spindle: &SpindleSide) -> String {
    let mm = (spindle.nose - mount.middle).dot(&mount.normal);
    format!("{} {}", side(machine, mm, &mount.normal), mount.name)
}

/// `185.000 mm above`: how far along a direction, and to which side.
fn side(machine: &Machine, mm: f64, direction: &Vector3<f64>) -> String {
    let is_up = is_parallel(direction, &machine.gravity) && direction.dot(&machine.gravity) < 0.0;
    let words = match (is_up, mm < 0.0) {
        (true, false) => "above",
        (true, true) => "below",
        (false, false) => "in front of",
        (false, true) => "behind",
    };
    format!("{:.3} mm {words}", mm.abs())
}

/// `spindle over the line of C`, or how far aside of it in R.
fn over(off: &Vector3<f64>, along: &Vector3<f64>, what: &str) -> String {
    let aside = off - along * off.dot(along);
    let parts = ["x", "y", "z"].iter().zip(aside.iter()).filter(|(_, mm)| mm.abs() > NONE_MM);
    let parts: Vec<String> = parts.map(|(letter, mm)| format!("{letter} {mm:+.3}")).collect();
    match parts.is_empty() {
        true => format!("spindle over {what}"),
        false => format!("spindle aside of {what} by {} mm", parts.join(" ")),
    }
}
