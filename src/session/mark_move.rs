//! Where a mark leads: out along the bar by linear axes alone. How long marks are is the plan's.

use nalgebra::DMatrix;

use super::test::Test;
use crate::chain::{Chain, Geometry};
use crate::machine::{AxisKind, Machine};

/// Slides that leave the bar's direction by more cannot move along it, mm.
const ASIDE_MM: f64 = 1e-6;

/// Where the axes stand when the bar is longer by so much and keeps its direction, from a row of the run, mm and rad; `None`
/// where the linear axes cannot move along it.
pub fn marked(machine: &Machine, test: &Test, row: &[f64], move_mm: f64) -> Option<Vec<f64>> {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let links = test.links(&chain).ok()?;
    let bar = |q: &[f64]| test.bar(&geometry, links, q);
    let slides: Vec<usize> = machine.axes_of(AxisKind::Linear).collect();
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
