//! What every machine and setup has wrong without being the concealed cause: location errors, ball places, bars.

use super::draw::Draw;
use super::kinematics::{AXES, Location, Machine};
use super::plan::Plan;

pub const ARCSEC: f64 = std::f64::consts::PI / 180.0 / 3600.0;

/// The six components of a location error in order, as named in slots.
pub const COMPONENTS: [&str; 6] = ["EX", "EY", "EZ", "EA", "EB", "EC"];

/// Free slots of each rotary axis: four for one along a coordinate direction, six for an inclined one.
pub fn slots(machine: &Machine) -> Vec<(usize, usize)> {
    let mut free = vec![];
    for (j, joint) in machine.joints.iter().enumerate().filter(|(_, joint)| joint.rotary) {
        let along = (0..3).find(|&i| joint.direction[i].abs() > 1.0 - 1e-9);
        free.extend((0..6).filter(|&c| along.is_none_or(|i| c % 3 != i)).map(|c| (j, c)));
    }
    free
}

/// Name of a slot, `EC0A`.
pub fn slot_name(machine: &Machine, slot: (usize, usize)) -> String {
    format!("{}0{}", COMPONENTS[slot.1], machine.joints[slot.0].name)
}

/// Location errors of tens of µm and of arcsec, now and then large; a nutating head's six are drawn alike.
pub fn draw_location(machine: &Machine, rng: &mut Draw) -> Location {
    let mut location = [[0.0; 6]; AXES];
    for (j, c) in slots(machine) {
        let size = if c < 3 { 0.016 } else { 9.0 * ARCSEC };
        location[j][c] = size * rng.student(4).clamp(-6.0, 6.0);
    }
    location
}

/// Places every ball a little beside where the session says.
pub fn misplace(plan: &mut Plan, rng: &mut Draw) {
    for seat in plan.pivots.iter_mut().chain(plan.balls.iter_mut()) {
        seat.offset_mm = [0; 3].map(|_| seat.spread_mm * rng.normal());
    }
}
