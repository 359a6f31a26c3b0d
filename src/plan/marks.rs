//! The moves along the bar by which programs mark their runs in the readings: within the stroke, inside the ranges, clear. It writes no program.

use nalgebra::DMatrix;

use super::candidates::Avoid;
use super::choose::Desk;
use super::planned::PlannedTest;
use super::run_in::OFF_LIMIT;
use crate::chain::{Chain, Geometry};
use crate::collision::{Instrument, certify};
use crate::machine::{AxisKind, Machine};
use crate::session::{Marks, Test};

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
/// Slides that leave the bar's direction by more cannot move along it, mm.
const ASIDE_MM: f64 = 1e-6;

/// Where the axes stand when the bar is longer by so much and keeps its direction, from a row of the run, mm and rad; `None`
/// where the linear axes cannot move along it.
pub fn marked(machine: &Machine, test: &Test, row: &[f64], move_mm: f64) -> Option<Vec<f64>> {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let (pivot, spindle) = test.links(&chain).ok()?;
    let bar = |q: &[f64]| {
        geometry.point(spindle, &test.spindle_ball.at, q, None) - geometry.point(pivot, &test.pivot.at, q, None)
    };
    let slides: Vec<usize> = (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == AxisKind::Linear).collect();
    let here = bar(row);
    // linear axes move the bar's end evenly: steps of 1 mm tell how
    let by_mm = DMatrix::from_fn(3, slides.len(), |i, k| {
        let mut moved = row.to_vec();
        moved[slides[k]] += 1.0;
        (bar(&moved) - here)[i]
    });
    let wanted = here.normalize() * move_mm;
    let steps = by_mm.clone().svd(true, true).solve(&wanted, 1e-9).ok()?;
    let left: f64 = (&by_mm * &steps - wanted).norm();
    let mut end = row.to_vec();
    slides.iter().zip(steps.iter()).for_each(|(&k, step)| end[k] += step);
    (left < ASIDE_MM).then_some(end)
}

impl Desk<'_> {
    /// Marks of a planned test: longer if that is free at both ends of the run, else shorter, else none.
    pub(super) fn marks(&mut self, planned: &PlannedTest) -> Option<Marks> {
        let instrument = Instrument::of(self.whole_world, self.bodies, self.kit, &planned.test).ok()?;
        let scene = instrument.scene(self.whole_world);
        let (first, last) = (planned.run.first()?, planned.run.last()?);
        let size_mm = MOVE_MM.min(STROKE_SHARE * self.kit.bar.half_stroke_mm);
        [size_mm, -size_mm]
            .into_iter()
            .find(|&move_mm| {
                [first, last].into_iter().all(|row| {
                    let Some(end) = marked(self.machine, &planned.test, row, move_mm) else { return false };
                    let rows = [row.clone(), end];
                    inside(self.machine, &self.settings.avoid, &rows)
                        && certify(&scene, &rows, self.settings.margin_mm, &mut self.scratch).is_ok()
                })
            })
            .map(|move_mm| Marks {
                move_mm,
                feed_mm_per_min: FEED_MM_PER_MIN,
                hold_s: HOLD_S,
                rest_s: REST_S,
                // whole tenths, as programs state them
                gap_s: (10.0 * (GAP_S + GAP_STEP_S * (planned.number as f64 - 1.0))).round() / 10.0,
            })
    }
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
