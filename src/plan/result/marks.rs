//! The moves along the bar by which programs mark their runs in the readings: within the stroke, inside the ranges, clear. It writes no program.

use super::plan_result::PlannedTest;
use crate::collision::{Instrument, certify};
use crate::machine::Machine;
use crate::plan::context::evaluation::Evaluation;
use crate::plan::places::candidate::Avoid;
use crate::plan::places::run_in::OFF_LIMIT;
use crate::session::{Marks, marked};

/// Longest move, mm, and the most of half a stroke that it takes: a ball placed by hand has moved the bar within it already.
const MOVE_MM: f64 = 0.4;
const STROKE_SHARE: f64 = 0.4;
/// Speed, mm/min: 0.4 mm are four readings at 10 Hz, and a thousandth of a second is a micrometre, which gauges read.
const FEED_MM_PER_MIN: f64 = 60.0;
/// Time at its end, s: six readings at 10 Hz.
const HOLD_S: f64 = 0.6;
/// Rest between a mark and the run, s: five readings at 10 Hz, and drives come to rest.
const REST_S: f64 = 0.5;
/// Gap of the first test, and how much longer each further one's is, s: a hundred times what a mark is found to.
const GAP_S: f64 = 1.0;
const GAP_STEP_S: f64 = 0.2;

/// Marks of a planned test: longer if that is free at both ends of the run, else shorter, else none.
pub(crate) fn marks(evaluation: &mut Evaluation, planned: &PlannedTest) -> Option<Marks> {
    let context = evaluation.context;
    let instrument =
        Instrument::of(context.whole_world, context.machine, context.bodies, context.kit, &planned.test).ok()?;
    let scene = instrument.scene(context.whole_world);
    let (first, last) = (planned.run.first()?, planned.run.last()?);
    let size_mm = MOVE_MM.min(STROKE_SHARE * context.kit.bar.half_stroke_mm);
    [size_mm, -size_mm]
        .into_iter()
        .find(|&move_mm| {
            [first, last].into_iter().all(|row| {
                let Some(end) = marked(context.machine, &planned.test, row, move_mm) else { return false };
                let rows = [row.clone(), end];
                inside(context.machine, &context.settings.avoid, &rows)
                    && certify(&scene, &rows, context.settings.margin_mm, &mut evaluation.scratch).is_ok()
            })
        })
        .map(|move_mm| Marks {
            move_mm,
            feed_mm_per_min: FEED_MM_PER_MIN,
            hold_s: HOLD_S,
            rest_s: REST_S,
            // whole tenths, as programs state them
            gap_s: (10.0 * (GAP_S + GAP_STEP_S * (planned.number as f64 - 1.0))).round() / 10.0,
            seen_mm: None,
        })
}

/// True when a move keeps off the limits of the axes that it moves and out of regions that are kept out of use.
fn inside(machine: &Machine, avoid: &Avoid, [from, to]: &[Vec<f64>; 2]) -> bool {
    let is_avoided =
        |axis: usize, q: f64| avoid.iter().any(|(other, low, high)| *other == axis && q > *low && q < *high);
    machine.axes.iter().enumerate().filter(|(k, _)| from[*k] != to[*k]).all(|(k, axis)| {
        let off = axis.kind.from_file_unit(OFF_LIMIT);
        axis.range.is_none_or(|(low, high)| (low + off..=high - off).contains(&to[k])) && !is_avoided(k, to[k])
    })
}
