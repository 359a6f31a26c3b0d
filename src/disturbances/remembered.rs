//! Effects that depend on the way an axis has come, as laws that a program can run along its commands. No effect's own formula.

use super::disturbance::own_offset;
use crate::effects::{MemoryLaw, memory};
use crate::machine::{Effect, Machine, Outlet};

/// One of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Remembered {
    /// Name of the effect.
    pub kind: String,
    pub law: MemoryLaw,
    /// Axis whose travel drives it, by index, and the sense in which its commands move the mechanism, 1 or −1.
    pub driving: usize,
    pub sign: f64,
    /// Axis that it moves, by index.
    pub axis: usize,
    /// Its component errors per unit of the law's value: EX EY EZ mm, EA EB EC rad.
    pub sizes: [f64; 6],
    /// Motion along or about the axis itself where that axis drives, per unit of the law's value, mm or rad.
    pub own: f64,
}

/// Takes the effects out of a machine that depend on the way of an axis and nothing else; the others stay. `steps` are the ways
/// of the axes from reading to reading, mm or rad, none where the effects are known otherwise: a free gap that turned round
/// at once turned round between two readings, and counts as that long, so that an axis which only trembles does not change its flank.
pub fn take_remembered(machine: &mut Machine, steps: &[f64]) -> Vec<Remembered> {
    let effects = std::mem::take(&mut machine.effects);
    let mut list = Vec::new();
    for effect in effects {
        match as_remembered(machine, &effect, steps) {
            Some(one) => list.push(one),
            None => machine.effects.push(effect),
        }
    }
    list
}

fn as_remembered(machine: &Machine, effect: &Effect, steps: &[f64]) -> Option<Remembered> {
    let axis = effect.place.axis().filter(|_| effect.tests.is_none())?;
    let (law, driving) = memory(machine, effect)?;
    let offset = own_offset(machine.axes[axis].kind);
    let direction = machine.axes[axis].direction;
    let mut sizes = [0.0; 6];
    for size in &effect.sizes {
        match size.outlet {
            Outlet::Motion { axis: of, component } if of == axis => sizes[component.index()] += size.value,
            Outlet::Along { axis: of } if of == axis => {
                (0..3).for_each(|k| sizes[offset + k] += size.value * direction[k]);
            }
            _ => return None,
        }
    }
    let along: f64 = (0..3).map(|k| sizes[offset + k] * direction[k]).sum();
    let own = if driving == axis { along } else { 0.0 };
    let sign = machine.motion_sign(driving);
    let law = without_jump(seen(law, steps.get(driving).copied().unwrap_or(0.0)), own);
    Some(Remembered { kind: effect.kind.clone(), law, driving, sign, axis, sizes, own })
}

/// A part never moves against its drive: what an axis loses along itself takes at least as much travel as is lost.
fn without_jump(law: MemoryLaw, own: f64) -> MemoryLaw {
    match law {
        MemoryLaw::LostMotion { windup_share, take_up, gap } if own > 0.0 => MemoryLaw::LostMotion {
            windup_share,
            take_up: take_up.max(2.0 * own * windup_share),
            gap: gap.max(2.0 * own * (1.0 - windup_share)),
        },
        // the part stands while it falls behind; a spike that is told to come at once is small beside its travel, or it is no motion
        // of a part
        MemoryLaw::Spike { travel, in_full, onset } if own > 0.0 && (onset > 0.0 || own > travel) => {
            MemoryLaw::Spike { travel, in_full, onset: own }
        }
        law => law,
    }
}

/// A law as readings so far apart, mm or rad, can have shown it.
fn seen(law: MemoryLaw, step: f64) -> MemoryLaw {
    match law {
        MemoryLaw::LostMotion { windup_share, take_up, gap } => {
            MemoryLaw::LostMotion { windup_share, take_up, gap: if gap > 0.0 { gap } else { step } }
        }
        law => law,
    }
}
