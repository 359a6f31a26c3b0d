//! LinuxCNC's kinematics modules: which of them a machine fits, and their pins.
//!
//! From the modules' sources (`trtfuncs.c`, `5axiskins.c`, `maxkins.c` of LinuxCNC 2.9). xyzac-trt and xyzbc-trt: C turns about
//! (x-rot-point, y-rot-point), A about y-rot-point + y-offset and z-rot-point + z-offset (B: x in place of y). Positive
//! positions turn the table right-handed; with `conventional-directions` (newer versions than 2.9.0) the other way. maxkins
//! turns B alone the other way by that pin.
//! 5axiskins and maxkins hold one number, the pivot length; positive B swings the spindle's nose towards +x, positive C turns
//! 5axiskins' head right-handed and maxkins' table left-handed.

use nalgebra::Vector3;

use super::counting::counting_against;
use super::held::held;
use crate::chain::Branch;
use crate::chain::Chain;
use crate::machine::{AxisKind, Machine};

/// A module with its pins as they hold a machine's nominal lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Module {
    pub name: &'static str,
    /// Pin and value, mm; 0 or 1 for a switch.
    pub pins: Vec<(&'static str, f64)>,
    /// What it cannot hold, in words.
    pub not_held: &'static str,
}

/// The sense of B that the head modules have.
const HEAD_SENSE: &str = "B so that the spindle's nose swings towards +x (reversed: true)";

/// Rotary axes from the bed outward, by branch.
fn rotary(machine: &Machine, branch: Branch) -> Vec<usize> {
    let chain = Chain::of(machine);
    chain.branch(branch).iter().copied().filter(|&axis| machine.axes[axis].kind == AxisKind::Rotary).collect()
}

/// The module for a fitted machine, with the pins of the fitted lines and with those of the lines as drawn; an error says why none fits.
pub fn modules_of(fitted: &Machine) -> Result<(Module, Module), String> {
    Ok((module_of(&held(fitted))?, module_of(&held(&fitted.as_drawn()))?))
}

/// The module for a machine whose lines are those of `held`, public for tests of single machines; an error says why none fits.
pub fn module_of(held: &Machine) -> Result<Module, String> {
    let (table, head) = (rotary(held, Branch::Workpiece), rotary(held, Branch::Tool));
    let is_named = |axis: usize, name: &str, direction: Vector3<f64>| {
        held.axes[axis].name == name && (held.axes[axis].direction - direction).norm() < 1e-9
    };
    let zero = |name: &str| held.axis_index(name).and_then(|axis| held.machine_zero[axis]).unwrap_or(0.0);
    let shift = Vector3::new(zero("X"), zero("Y"), zero("Z"));
    if let Some(&slide) = counting_against(held).first() {
        return Err(format!(
            "LinuxCNC's modules count a slide along the tool's way over the workpiece; by the machine file a positive command of {} moves the \
             tool the other way: state 'directions: iso841' and record or convert the positions so, or correct 'reversed'",
            held.axes[slide].name
        ));
    }
    let signs = |wanted: &[(usize, f64)]| wanted.iter().all(|&(axis, sign)| held.motion_sign(axis) == sign);
    match (table.as_slice(), head.as_slice()) {
        (&[tilt, turn], []) if is_named(turn, "C", Vector3::z()) => {
            let (c, a) = (held.axes[turn].origin + shift, held.axes[tilt].origin + shift);
            let common = vec![("x-rot-point", c.x), ("y-rot-point", c.y), ("z-rot-point", a.z), ("z-offset", 0.0)];
            let mut common = common;
            if signs(&[(tilt, -1.0), (turn, -1.0)]) {
                common.push(("conventional-directions", 1.0));
            } else if !signs(&[(tilt, 1.0), (turn, 1.0)]) {
                return Err(
                    "the table's two axes count in different senses, which LinuxCNC's trunnion modules do not".into()
                );
            }
            let not_held = "directions of the axes (EA0, EB0, EC0), squareness, errors over position";
            if is_named(tilt, "A", Vector3::x()) {
                let own = [("y-offset", a.y - c.y)];
                return Ok(Module { name: "xyzac-trt-kins", pins: common.into_iter().chain(own).collect(), not_held });
            }
            if is_named(tilt, "B", Vector3::y()) {
                let own = [("x-offset", a.x - c.x)];
                return Ok(Module { name: "xyzbc-trt-kins", pins: common.into_iter().chain(own).collect(), not_held });
            }
            Err("the tilting axis of the table is neither A along x nor B along y".into())
        }
        (&[turn], &[tilt]) if is_named(turn, "C", Vector3::z()) && is_named(tilt, "B", Vector3::y()) => {
            if !signs(&[(turn, -1.0)]) {
                return Err(
                    "maxkins counts C so that the table turns left-handed; the machine file says otherwise".into()
                );
            }
            let mut pins = vec![("pivot-length", 0.0)];
            if signs(&[(tilt, 1.0)]) {
                pins.push(("conventional-directions", 1.0));
            }
            Ok(Module {
                name: "maxkins",
                pins,
                not_held: "moves of B while C is turned (it does not turn the head's swing into the table's frame), the place of C (set the zero of X and Y on its line), vectors across the head, directions, squareness, errors over position",
            })
        }
        ([], &[turn, tilt]) if is_named(turn, "C", Vector3::z()) && is_named(tilt, "B", Vector3::y()) => {
            if !signs(&[(turn, 1.0), (tilt, -1.0)]) {
                return Err(format!(
                    "5axiskins counts {HEAD_SENSE} and C right-handed; the machine file says otherwise"
                ));
            }
            Ok(Module {
                name: "5axiskins",
                pins: vec![("pivot-length", 0.0)],
                not_held: "the vector between C and B across the pivot length, directions, squareness, errors over position",
            })
        }
        _ => Err(format!(
            "no module of LinuxCNC's package has these axes: xyzac-trt-kins (A carries C on the table), xyzbc-trt-kins (B carries C), maxkins (C table, B head), 5axiskins (C carries B on the head); the machine is {}",
            held.code
        )),
    }
}
