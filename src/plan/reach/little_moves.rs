//! The little moves from park by which an operator sees the sense of every axis before anything is measured. It writes no program.

use crate::collision::{Scene, Scratch, certify};
use crate::machine::{AxisKind, Machine};
use crate::plan::places::run_in::OFF_LIMIT;

/// A move of one axis in its positive direction, at park or just below it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LittleMove {
    /// Axis, by index.
    pub axis: usize,
    /// mm or rad; `to` is above `from`, and one of them is the park position.
    pub from: f64,
    pub to: f64,
}

/// Ways that an eye sees at once, the first that is free is taken: mm and deg.
const WAYS: [f64; 3] = [10.0, 5.0, 2.0];

/// Little moves of these axes from park that keep inside the ranges and clear by the margin to either side, for the sense is
/// not known yet; axes that have no room are left out.
pub(crate) fn little_moves(
    machine: &Machine,
    scene: &Scene,
    park: &[f64],
    axes: &[usize],
    margin_mm: f64,
    scratch: &mut Scratch,
) -> Vec<LittleMove> {
    let mut moves = Vec::new();
    for &axis in axes {
        let entry = &machine.axes[axis];
        let (low, high) = entry.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let off = entry.kind.from_file_unit(OFF_LIMIT);
        let found = WAYS.iter().find_map(|&way| {
            // half as far for what turns: at 100 mm 5 deg are 9 mm
            let way = entry.kind.from_file_unit(if entry.kind == AxisKind::Rotary { 0.5 * way } else { way });
            let here = park[axis];
            let from = if here + way <= high - off { here } else { here - way };
            if from < low + off {
                return None;
            }
            let at = |q: f64| {
                let mut row = park.to_vec();
                row[axis] = q;
                row
            };
            let rows = [at((here - way).max(low)), at((here + way).min(high))];
            certify(scene, &rows, margin_mm, scratch).is_ok().then_some(LittleMove { axis, from, to: from + way })
        });
        moves.extend(found);
    }
    moves
}
