//! How fast a run may be so that a control keeps its feed over the whole arc: ramps end in the run-in, blocks are long enough.

use crate::machine::Machine;
use crate::plan::places::candidate::Candidate;
use crate::plan::places::drive::{Drive, STEP_DEG, Swing};
use crate::plan::places::run_in::RUN_IN;
use crate::session::Follow;

/// Acceleration of a linear axis, mm/s²: 0.1 g, which every machining centre has; usual are 0.1 to 1 g.
const SLIDE_MM_PER_S2: f64 = 1000.0;
/// Acceleration of a rotary axis, deg/s²: 5 rev/s in 6 s; tables with worm gear have 200 to 600, torque motors ten times that.
const ROTARY_DEG_PER_S2: f64 = 300.0;
/// Share of the acceleration that a look-ahead spends in a block that it joins to its neighbours: while one slows down the
/// next speeds up (LinuxCNC halves it).
const JOINED: f64 = 0.5;
/// Share of the acceleration that is left along an arc: a control keeps the rest for the one towards the middle, and halves
/// both where it may join blocks (seen on LinuxCNC: a quarter of the axes' acceleration).
const ALONG_ARC: f64 = 0.25;
/// Part of the run-in that a ramp may fill: the rest is for jerk limits.
const RAMP: f64 = 0.75;
/// Most that a straight block may change the bar's length, mm: below the 0.5 um of a gauge, with room for the digits that
/// programs state and for corners that a look-ahead rounds.
pub const CHORD_MM: f64 = 2.5e-4;
/// Shortest time of a straight block, s: a control counts it in whole cycles of 1 ms, which then is 3 % of it.
const LEAST_BLOCK_S: f64 = 0.033;

/// Feed of a candidate, mm/min: the one asked for, or the whole number below the fastest that controls keep.
pub(crate) fn feed_mm_per_min(machine: &Machine, candidate: &Candidate, asked: f64) -> f64 {
    let fastest = fastest_rad_per_s(machine, candidate) * candidate.way_radius_mm() * 60.0;
    if asked <= fastest { asked } else { fastest.floor().max(1.0) }
}

/// Fastest turn of the path that keeps its speed over the arc.
fn fastest_rad_per_s(machine: &Machine, candidate: &Candidate) -> f64 {
    let (rho, bar) = (candidate.solved.rho_mm, candidate.bar_mm);
    let rotary = ROTARY_DEG_PER_S2.to_radians();
    // v = √(2·a·s)
    let ramp = |acceleration: f64, run_in: f64| (2.0 * acceleration * RAMP * run_in).sqrt();
    // a run-in ends when the fastest axis has gone so many deg or mm
    let beyond = |slides_mm: f64| RUN_IN.to_radians() / slides_mm.to_radians().max(1.0);
    match &candidate.drive {
        Drive::Turn => ramp(rotary, RUN_IN.to_radians()),
        Drive::Circle(..) => ramp(ALONG_ARC * SLIDE_MM_PER_S2 / bar, RUN_IN / bar),
        Drive::Follow(follow, swing) => {
            // slides go on the first radius; a chord of theirs lies inside it, by this much along the bar
            let (slides_mm, along_mm) = match follow {
                Follow::Radial => (rho + bar, rho + bar),
                Follow::Tangential => (rho.hypot(bar), bar),
                Follow::Axial | Follow::None => (rho, 0.0),
            };
            let acceleration = rotary.min(SLIDE_MM_PER_S2 / slides_mm);
            match plane_circle(machine, swing) {
                true => ramp(ALONG_ARC * acceleration, beyond(slides_mm)),
                // a block must be so long that it can be entered and left at full speed: v²/a
                false => {
                    let fastest = ramp(acceleration, beyond(slides_mm));
                    // the run-in is cut into whole blocks, which are the shortest
                    let (longest, run_in) = (block_deg(along_mm).to_radians(), beyond(slides_mm));
                    let block = run_in / (run_in / longest).ceil();
                    fastest.min((JOINED * acceleration * block).sqrt()).min(block / LEAST_BLOCK_S)
                }
            }
        }
    }
}

/// Longest block, deg, whose chord lies no more than [`CHORD_MM`] inside a circle of that radius.
fn block_deg(radius_mm: f64) -> f64 {
    (8.0 * CHORD_MM / radius_mm.max(1e-9)).sqrt().to_degrees().min(STEP_DEG)
}

/// True when slides follow on what a control draws only in straight blocks, which it joins with short changes of feed: on
/// LinuxCNC by one cycle's acceleration, 1 mm/s, for some 10 ms at each joint.
pub(crate) fn is_in_blocks(machine: &Machine, candidate: &Candidate) -> bool {
    matches!(&candidate.drive, Drive::Follow(_, swing) if !plane_circle(machine, swing))
}

/// Slides within this of a circle draw it, relative to their reach.
const ROUND: f64 = 1e-9;

/// True when two of X, Y and Z draw a circle and no other slide moves: arcs of a control carry the rotary axis along.
fn plane_circle(machine: &Machine, swing: &Swing) -> bool {
    let most = (0..swing.cos.len()).map(|k| swing.reach(k)).fold(0.0, f64::max);
    let moving: Vec<usize> = (0..swing.cos.len()).filter(|&k| swing.reach(k) > ROUND * most).collect();
    let [one, other] = moving[..] else { return false };
    let square = swing.cos[one] * swing.cos[other] + swing.sin[one] * swing.sin[other];
    (swing.reach(one) - swing.reach(other)).abs() < ROUND * most
        && square.abs() < ROUND * most * most
        && [one, other].iter().all(|&k| ["X", "Y", "Z"].contains(&machine.axes[k].name.as_str()))
}
