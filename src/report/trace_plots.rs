//! Plots of one test: what is drawn over which position. The drawing is in `polar` and `residual_plot`; nothing is fitted.

use super::polar::{PolarPlot, PolarTrace};
use super::residual_plot::residual_svg;
use crate::identify::TestFit;
use crate::machine::AxisKind;
use crate::session::{Motion, Path, Session, Test};
use crate::units::UM_PER_MM;

/// Plots of one test as SVG.
#[derive(Debug, Clone, PartialEq)]
pub struct TestPlots {
    pub test: String,
    /// Measured, model and residual; absent for static poses and straight sweeps.
    pub polar: Option<String>,
    /// Residual over the swept position, or over the reading's number.
    pub residual: String,
}

/// Most points of a trace in a polar plot: finer than a pixel on any page.
const MOST_POINTS: usize = 721;

/// Plots of a test that has a recording.
pub fn test_plots(session: &Session, test: &Test, motion: &Motion, fit: &TestFit) -> Option<TestPlots> {
    let recording = test.recording.as_ref()?;
    let finite: Vec<f64> = recording.length_mm.iter().copied().filter(|length| length.is_finite()).collect();
    // an absolute gauge has no nominal length; its mean stands for it
    let nominal_mm = test.bar_length_mm.unwrap_or(finite.iter().sum::<f64>() / finite.len().max(1) as f64);
    let position = swept(session, test, motion);
    let polar = position.as_ref().and_then(|swept| swept.angle_rad.as_ref()).map(|angle_rad| {
        let every = angle_rad.len().div_ceil(MOST_POINTS).max(1);
        let trace = |label: &str, value: &dyn Fn(usize) -> f64| PolarTrace {
            label: label.into(),
            points: (0..angle_rad.len()).step_by(every).map(|row| (angle_rad[row], value(row))).collect(),
        };
        let taken = |row: usize| fit.kept.get(row).copied().unwrap_or(false);
        let read = |row: usize| {
            if taken(row) { (recording.length_mm[row] - nominal_mm) * UM_PER_MM } else { f64::NAN }
        };
        let residual = |row: usize| if taken(row) { fit.residual_mm[row] * UM_PER_MM } else { f64::NAN };
        let model = |row: usize| read(row) - residual(row);
        let mut plot = PolarPlot::new(
            &test.name,
            vec![trace("measured", &read), trace("model", &model), trace("residual (measured − model)", &residual)],
        );
        plot.subtitle = format!("{} · nominal {nominal_mm:.4} mm", moves(session, motion));
        plot.to_svg()
    });
    let (abscissa, label) = match position {
        Some(swept) => (swept.value, swept.label),
        None => ((0..motion.rows()).map(|row| row as f64 + 1.0).collect(), "reading".to_string()),
    };
    let residual = residual_svg(&test.name, &label, &abscissa, fit);
    Some(TestPlots { test: test.name.clone(), polar, residual })
}

/// What a test moves: `C`, `X Y C`.
fn moves(session: &Session, motion: &Motion) -> String {
    let names: Vec<&str> = motion.moving.iter().map(|&axis| session.machine.axes[axis].name.as_str()).collect();
    format!("moving {}", names.join(" "))
}

/// The position over which a test is drawn.
pub(super) struct Swept {
    pub(super) label: String,
    /// mm or degrees.
    pub(super) value: Vec<f64>,
    /// Angle round the circle where there is one, rad.
    pub(super) angle_rad: Option<Vec<f64>>,
}

/// The rotary axis that turns farthest, the angle of a planar circle, or the linear axis that goes farthest.
pub(super) fn swept(session: &Session, test: &Test, motion: &Motion) -> Option<Swept> {
    motion.time_s.as_ref()?;
    let axes = &session.machine.axes;
    let travel = |axis: usize| {
        let (low, high) =
            motion.axis(axis).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q), high.max(q)));
        high - low
    };
    let farthest = |kind: AxisKind| {
        let moving = motion.moving.iter().copied().filter(|&axis| axes[axis].kind == kind && travel(axis) > 0.0);
        moving.max_by(|&a, &b| travel(a).total_cmp(&travel(b)))
    };
    if let Some(axis) = farthest(AxisKind::Rotary) {
        let angle: Vec<f64> = motion.axis(axis).collect();
        let value = angle.iter().map(|angle| angle.to_degrees()).collect();
        return Some(Swept { label: format!("{}, °", axes[axis].name), value, angle_rad: Some(angle) });
    }
    let linear: Vec<usize> = motion.moving.iter().copied().filter(|&axis| travel(axis) > 0.0).collect();
    if let [first, second] = linear[..] {
        let (first, second) = match &test.path {
            Some(Path::Circle { plane, .. }) => (plane.first, plane.second),
            _ => plane_order(session, first, second),
        };
        let pivot = circle_centre(motion, first, second);
        let angle: Vec<f64> = (0..motion.rows())
            .map(|row| (motion.row(row)[second] - pivot.1).atan2(motion.row(row)[first] - pivot.0))
            .collect();
        let value = unwrapped_deg(&angle);
        let label = format!("angle in {}{}, °", axes[first].name, axes[second].name);
        return Some(Swept { label, value, angle_rad: Some(angle) });
    }
    let axis = farthest(AxisKind::Linear)?;
    Some(Swept { label: format!("{}, mm", axes[axis].name), value: motion.axis(axis).collect(), angle_rad: None })
}

/// XY, YZ, ZX: the order in which a circle's angle counts.
fn plane_order(session: &Session, one: usize, other: usize) -> (usize, usize) {
    let along = |axis: usize| session.machine.axes[axis].coordinate_direction().unwrap_or(0);
    if (along(one) + 1) % 3 == along(other) { (one, other) } else { (other, one) }
}

/// Centre of the commanded positions of two axes, from three rows.
fn circle_centre(motion: &Motion, first: usize, second: usize) -> (f64, f64) {
    let point = |row: usize| (motion.row(row)[first], motion.row(row)[second]);
    let rows = motion.rows();
    // thirds of the path are far apart on full turns and short arcs alike
    let (a, b, c) = (point(0), point(rows / 3), point(2 * rows / 3));
    let twice = 2.0 * (a.0 * (b.1 - c.1) + b.0 * (c.1 - a.1) + c.0 * (a.1 - b.1));
    let square = |p: (f64, f64)| p.0 * p.0 + p.1 * p.1;
    let x = (square(a) * (b.1 - c.1) + square(b) * (c.1 - a.1) + square(c) * (a.1 - b.1)) / twice;
    let y = (square(a) * (c.0 - b.0) + square(b) * (a.0 - c.0) + square(c) * (b.0 - a.0)) / twice;
    if x.is_finite() && y.is_finite() { (x, y) } else { (0.0, 0.0) }
}

fn unwrapped_deg(angle_rad: &[f64]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last: Option<f64> = None;
    angle_rad
        .iter()
        .map(|angle| {
            let degrees = angle.to_degrees();
            if let Some(last) = last {
                turns -= 360.0 * ((degrees - last) / 360.0).round();
            }
            last = Some(degrees);
            degrees + turns
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_run_on_over_the_half_turn() {
        let degrees = unwrapped_deg(&[3.0, 3.1, -3.1, -3.0]);
        assert!(degrees.windows(2).all(|pair| pair[1] > pair[0]), "{degrees:?}");
    }
}
