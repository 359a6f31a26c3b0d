//! Plots of a pass, both directions together: what is drawn over which angle. The drawing is in `polar` and `residual_plot`.

use super::polar::{Arrow, PolarPlot, PolarTrace, Stroke};
use super::residual_plot::residual_svg;
use crate::chain::Chain;
use crate::identify::{Fit, TestFit};
use crate::machine::AxisKind;
use crate::methods::{BarTurn, Centred, MethodError, bar_turn, passes};
use crate::session::{Motion, Path, Session, Test};
use crate::units::UM_PER_MM;

/// Plots of a pass: one test, or both directions of one.
#[derive(Debug, Clone, PartialEq)]
pub struct PassPlots {
    /// Tests of the pass in the order of the session.
    pub tests: Vec<String>,
    /// Both directions round the circle; absent for static poses and straight sweeps.
    pub round: Option<RoundPlots>,
    /// By test: residual over the swept position, or over the reading's number.
    pub residuals: Vec<String>,
}

/// Deviations round the circle as SVG.
#[derive(Debug, Clone, PartialEq)]
pub struct RoundPlots {
    pub as_read: String,
    /// Without the offset of the centre; absent where the bar does not turn or too short an arc holds no centre.
    pub centred: Option<String>,
}

/// Most points of a trace in a polar plot: finer than a pixel on any page.
const MOST_POINTS: usize = 721;

/// A recorded test on its way to a picture.
struct Drawn<'s> {
    test: &'s Test,
    motion: Motion,
    swept: Option<Swept>,
    turn: Option<BarTurn>,
    fit: &'s TestFit,
}

/// A bar lies in the plane of its circle where its length is the radius, within what a calibrated length differs from a nominal one, mm.
const LEVEL_MM: f64 = 0.2;

impl Drawn<'_> {
    /// Angle of the picture by row: the bar's direction where it turns, else the position of the axis that turns.
    fn angle_rad(&self) -> Option<&[f64]> {
        let turn = self.turn.as_ref().map(|turn| turn.angle_rad.as_slice());
        turn.or(self.swept.as_ref().and_then(|swept| swept.angle_rad.as_deref()))
    }

    /// Signed turn over the test, rad.
    fn turned_rad(&self) -> Option<f64> {
        let angle = self.angle_rad()?;
        Some(angle.last()? - angle.first()?)
    }

    /// Deviations from the nominal length by row, µm: as read, and of the model; NaN where there is none.
    fn deviations_um(&self) -> (f64, Vec<f64>, Vec<f64>, Vec<f64>) {
        let lengths = self.test.recording.as_ref().map_or(&[][..], |recording| &recording.length_mm);
        let finite: Vec<f64> = lengths.iter().copied().filter(|length| length.is_finite()).collect();
        // a circle has the radius that was commanded, as its figures count; an absolute gauge has no nominal length: its mean stands for it
        let bar_mm = self.test.bar_length_mm;
        let is_level = |radius: &f64| bar_mm.is_none_or(|bar| (bar - radius).abs() < LEVEL_MM);
        let commanded_mm = self.swept.as_ref().and_then(|swept| swept.radius_mm).filter(is_level);
        let usual_mm = || finite.iter().sum::<f64>() / finite.len().max(1) as f64;
        let nominal_mm = commanded_mm.or(bar_mm).unwrap_or_else(usual_mm);
        let (mut read, mut left_out, mut model) = (Vec::new(), Vec::new(), Vec::new());
        for (row, length) in lengths.iter().enumerate() {
            let is_taken = self.fit.kept.get(row).copied().unwrap_or(false);
            let deviation = (length - nominal_mm) * UM_PER_MM;
            read.push(if is_taken { deviation } else { f64::NAN });
            left_out.push(if is_taken { f64::NAN } else { deviation });
            model.push(if is_taken { deviation - self.fit.residual_mm[row] * UM_PER_MM } else { f64::NAN });
        }
        (nominal_mm, read, left_out, model)
    }
}

/// Plots of all recorded tests, pass by pass.
pub fn pass_plots(session: &Session, fit: &Fit) -> Result<Vec<PassPlots>, MethodError> {
    let chain = Chain::of(&session.machine);
    let mut drawn = Vec::with_capacity(session.tests.len());
    for (test, fit) in session.tests.iter().zip(&fit.tests) {
        let motion = Motion::of(session, &chain, test)?;
        let swept = swept(session, test, &motion);
        let turns = motion.time_s.is_some() && test.recording.is_some();
        let turn = if turns { bar_turn(session, &chain, test, &motion)? } else { None };
        drawn.push(Drawn { test, motion, swept, turn, fit });
    }
    let turns: Vec<Option<f64>> = drawn.iter().map(Drawn::turned_rad).collect();
    let passes = passes(session, &turns).into_iter();
    let plots = passes.map(|pass| {
        let tests: Vec<&Drawn> =
            pass.into_iter().map(|k| &drawn[k]).filter(|one| one.test.recording.is_some()).collect();
        PassPlots {
            tests: tests.iter().map(|one| one.test.name.clone()).collect(),
            round: round_plots(session, &tests),
            residuals: tests.iter().map(|one| residual_plot(one)).collect(),
        }
    });
    Ok(plots.filter(|plots| !plots.tests.is_empty()).collect())
}

fn residual_plot(drawn: &Drawn) -> String {
    match &drawn.swept {
        Some(swept) => residual_svg(&drawn.test.name, &swept.label, &swept.value, drawn.fit),
        None => {
            let numbers: Vec<f64> = (0..drawn.motion.rows()).map(|row| row as f64 + 1.0).collect();
            residual_svg(&drawn.test.name, "reading", &numbers, drawn.fit)
        }
    }
}

/// Both directions in one picture, as read and with one common centre taken off.
fn round_plots(session: &Session, tests: &[&Drawn]) -> Option<RoundPlots> {
    let first = tests.first()?;
    first.angle_rad()?;
    let rows = tests.iter().map(|one| one.deviations_um()).collect::<Vec<_>>();
    let points = tests.iter().zip(&rows).flat_map(|(one, (_, read, ..))| {
        let angles = one.angle_rad().unwrap_or_default();
        angles.iter().copied().zip(read.iter().copied())
    });
    let centred = first.turn.as_ref().and_then(|_| Centred::of(points.collect::<Vec<_>>().into_iter()));
    let as_read = Centred { centre: [0.0, 0.0], mean: 0.0 };
    let draw = |off: &Centred, says: &str| -> String {
        let mut traces = Vec::new();
        let mut arrows = Vec::new();
        for (index, (one, (_, read, left_out, model))) in tests.iter().zip(&rows).enumerate() {
            let angles = one.angle_rad().unwrap_or_default();
            let is_ccw = one.turned_rad().unwrap_or(0.0) >= 0.0;
            let way = if is_ccw { "ccw" } else { "cw" };
            let trace = |label: String, stroke: Stroke, values: &[f64]| PolarTrace {
                label,
                points: thinned(angles, values).map(|(angle, value)| (angle, off.apply(angle, value))).collect(),
                stroke,
            };
            traces.push(trace(format!("{way}: {}", one.test.name), Stroke::Own(index), read));
            traces.push(trace(format!("{way}: model"), Stroke::Own(6), model));
            if left_out.iter().any(|value| value.is_finite()) {
                traces.push(trace(format!("{way}, left out"), Stroke::Grey, left_out));
            }
            arrows.extend(angles.first().map(|&from| Arrow { stroke: index, from, is_ccw }));
        }
        let names: Vec<&str> = tests.iter().map(|one| one.test.name.as_str()).collect();
        let mut plot = PolarPlot::new(names.join(" and "), traces);
        plot.subtitle = format!("{} · nominal {:.4} mm · {says}", moves(session, &first.motion), rows[0].0);
        plot.arrows = arrows;
        label_spokes(first, &mut plot);
        plot.to_svg()
    };
    Some(RoundPlots {
        as_read: draw(&as_read, "as read"),
        centred: centred.map(|off| {
            let [right, up] = off.centre;
            draw(&off, &format!("centre removed ({right:+.1}, {up:+.1} µm)"))
        }),
    })
}

/// Rows of a trace, no more than can be seen.
fn thinned<'t>(angles: &'t [f64], values: &'t [f64]) -> impl Iterator<Item = (f64, f64)> + 't {
    let every = angles.len().div_ceil(MOST_POINTS).max(1);
    angles.iter().copied().zip(values.iter().copied()).step_by(every)
}

/// `+X` to the right and `+Y` up where the bar turns in a plane; else the axis whose position the angle is.
fn label_spokes(drawn: &Drawn, plot: &mut PolarPlot) {
    let quarters: [String; 4] = match (&drawn.turn, &drawn.swept) {
        (Some(turn), _) => {
            let [right, up] = turn.plane.map(|k| ["X", "Y", "Z"][k]);
            quarters_of_plane(right, up)
        }
        (None, Some(swept)) => swept.quarters(),
        (None, None) => return,
    };
    plot.label_quarters(quarters);
}

/// `+X` to the right, `+Y` up, and their opposites.
fn quarters_of_plane(right: &str, up: &str) -> [String; 4] {
    [format!("+{right}"), format!("+{up}"), format!("−{right}"), format!("−{up}")]
}

/// What a test moves: `C`, `X Y C`.
fn moves(session: &Session, motion: &Motion) -> String {
    let names: Vec<&str> = motion.moving.iter().map(|&axis| session.machine.axes[axis].name.as_str()).collect();
    format!("moving {}", names.join(" "))
}

/// The position over which a test is drawn.
pub(crate) struct Swept {
    pub(crate) label: String,
    /// mm or degrees.
    pub(crate) value: Vec<f64>,
    /// Angle round the circle where there is one, rad.
    pub(crate) angle_rad: Option<Vec<f64>>,
    /// Axes whose positions a planar circle is drawn over, to the right and up.
    plane: Option<[String; 2]>,
    /// Mean radius of the commanded circle, mm.
    radius_mm: Option<f64>,
}

impl Swept {
    /// What stands at 0, 90, 180 and 270°: axes of a planar circle with their signs, else positions of the axis.
    pub(crate) fn quarters(&self) -> [String; 4] {
        match &self.plane {
            Some([right, up]) => quarters_of_plane(right, up),
            None => {
                let axis = self.label.split(',').next().unwrap_or_default();
                [0, 90, 180, 270].map(|degrees| format!("{axis} {degrees}°"))
            }
        }
    }
}

/// The rotary axis that turns farthest, the angle of a planar circle, or the linear axis that goes farthest.
pub(crate) fn swept(session: &Session, test: &Test, motion: &Motion) -> Option<Swept> {
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
        return Some(Swept {
            label: format!("{}, °", axes[axis].name),
            value,
            angle_rad: Some(angle),
            plane: None,
            radius_mm: None,
        });
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
        let radii = (0..motion.rows())
            .map(|row| (motion.row(row)[second] - pivot.1).hypot(motion.row(row)[first] - pivot.0))
            .sum::<f64>();
        let radius_mm = Some(radii / motion.rows().max(1) as f64);
        let value = unwrapped_deg(&angle);
        let label = format!("angle in {}{}, °", axes[first].name, axes[second].name);
        let plane = Some([first, second].map(|axis| axes[axis].name.clone()));
        return Some(Swept { label, value, angle_rad: Some(angle), plane, radius_mm });
    }
    let axis = farthest(AxisKind::Linear)?;
    Some(Swept {
        label: format!("{}, mm", axes[axis].name),
        value: motion.axis(axis).collect(),
        angle_rad: None,
        plane: None,
        radius_mm: None,
    })
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

/// Angles that run on over a whole turn; their middle lies between 0 and 360°, so that both directions have the same ones.
fn unwrapped_deg(angle_rad: &[f64]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last: Option<f64> = None;
    let mut degrees: Vec<f64> = angle_rad
        .iter()
        .map(|angle| {
            let degrees = angle.to_degrees();
            if let Some(last) = last {
                turns -= 360.0 * ((degrees - last) / 360.0).round();
            }
            last = Some(degrees);
            degrees + turns
        })
        .collect();
    if let (Some(first), Some(last)) = (degrees.first(), degrees.last()) {
        let whole = 360.0 * (0.5 * (first + last) / 360.0).floor();
        degrees.iter_mut().for_each(|angle| *angle -= whole);
    }
    degrees
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_run_on_over_the_half_turn() {
        let degrees = unwrapped_deg(&[3.0, 3.1, -3.1, -3.0]);
        assert!(degrees.windows(2).all(|pair| pair[1] > pair[0]), "{degrees:?}");
        // there and back over the same arc
        let back = unwrapped_deg(&[-3.0, -3.1, 3.1, 3.0]);
        let turned: Vec<f64> = back.into_iter().rev().collect();
        assert!(degrees.iter().zip(&turned).all(|(one, other)| (one - other).abs() < 1e-9), "{degrees:?} {turned:?}");
    }
}
