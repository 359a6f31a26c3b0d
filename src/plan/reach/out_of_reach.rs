//! What no position of the axes can mend: a mount without room or beyond all reach, a kit whose longest bar is too short. Limits of axes are verdicts, not refusals.

use crate::bodies::{Bodies, Kit, Mount};
use crate::chain::{Chain, Geometry};
use crate::machine::{AxisKind, Machine};
use crate::plan::places::ball_places::distinct_mounts;
use crate::plan::places::candidate::{Candidates, Misses};

/// Why there is nothing to plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OutOfReach {
    #[error(
        "mount '{mount}' has no room for the stand of the kit '{kit}', {base_mm} mm across; enlarge its disc or rectangle (mm) or remove it"
    )]
    NoRoom { mount: String, kit: String, base_mm: f64 },
    #[error(
        "mount '{mount}' is {by_mm:.0} mm or more beyond the reach of every bar with the axes anywhere in their ranges; check its 'at', in mm"
    )]
    Far { mount: String, by_mm: f64 },
    #[error(
        "no bar of the kit '{kit}' reaches: the longest, {longest_mm} mm, is {by_mm:.1} mm too short; add an extension"
    )]
    Bar { kit: String, longest_mm: f64, by_mm: f64 },
}

/// Refuses what leaves nothing to plan whatever the axes do.
pub(crate) fn refuse(machine: &Machine, bodies: &Bodies, kit: &Kit, all: &Candidates) -> Result<(), OutOfReach> {
    for (index, mount) in distinct_mounts(bodies) {
        if all.sites.iter().all(|site| site.mount != index) {
            let base_mm = 2.0 * kit.pivot_stand.base_radius_mm;
            return Err(OutOfReach::NoRoom { mount: mount.name.clone(), kit: kit.name.clone(), base_mm });
        }
        if let Some(by_mm) = beyond_mm(machine, kit, mount) {
            return Err(OutOfReach::Far { mount: mount.name.clone(), by_mm });
        }
    }
    let by_limits = all.misses.values().any(|misses| !misses.limits.is_empty());
    let short = all.misses.values().filter_map(Misses::all_too_short_mm).reduce(f64::min);
    match (all.list.is_empty() && !by_limits, short, kit.lengths_mm().last()) {
        (true, Some(by_mm), Some(&longest_mm)) => Err(OutOfReach::Bar { kit: kit.name.clone(), longest_mm, by_mm }),
        _ => Ok(()),
    }
}

/// Steps of a turn at which rotary axes are tried.
const STEPS: usize = 72;

/// How far a mount stays beyond the longest bar at least, mm; `None` when it may be in reach or the machine is not one of
/// linear axes with a travel and at most two rotary ones.
///
/// |mount − spindle ball| at every position of the rotary axes, less all that linear axes, surface, stand and stem can add,
/// less what the rotary axes move between two steps.
fn beyond_mm(machine: &Machine, kit: &Kit, mount: &Mount) -> Option<f64> {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let spindle = machine.spindle.as_ref()?;
    let (on, tool) = (chain.link(&mount.link)?, chain.link(&spindle.link)?);
    let mut travel_mm = 0.0;
    let mut rotary = Vec::new();
    for (index, axis) in machine.axes.iter().enumerate() {
        match (axis.kind, axis.range) {
            (AxisKind::Linear, Some((low, high))) => travel_mm += low.abs().max(high.abs()),
            (AxisKind::Linear, None) => return None,
            (AxisKind::Rotary, _) => rotary.push(index),
        }
    }
    if rotary.len() > 2 {
        return None;
    }
    let arms = kit.fixture.iter().flat_map(|fixture| &fixture.arms_mm).copied().fold(0.0, f64::max);
    let bar_mm = kit.lengths_mm().last().copied().unwrap_or(0.0) + kit.bar.half_stroke_mm;
    let adds_mm = travel_mm + mount.extent_mm() + kit.pivot_stand.height_mm[1] + kit.spindle_reach_mm + arms + bar_mm;
    // the middle of the step is half a step away
    let half_step = std::f64::consts::PI / STEPS as f64;
    let swing = |axis: usize| {
        let lever = |p: nalgebra::Vector3<f64>| (p - machine.axes[axis].origin).norm() + travel_mm;
        half_step * lever(mount.middle).max(lever(spindle.ball()))
    };
    let slack_mm: f64 = rotary.iter().map(|&axis| swing(axis)).sum();
    let mut q = vec![0.0; machine.axes.len()];
    let mut least = f64::MAX;
    for turn in 0..STEPS.pow(rotary.len() as u32) {
        for (place, &axis) in rotary.iter().enumerate() {
            q[axis] = 2.0 * half_step * ((turn / STEPS.pow(place as u32)) % STEPS) as f64;
        }
        let ball = geometry.point(tool, &spindle.ball(), &q, None);
        least = least.min((geometry.point(on, &mount.middle, &q, None) - ball).norm());
    }
    let by_mm = least - adds_mm - slack_mm;
    (by_mm > 0.0).then_some(by_mm)
}
