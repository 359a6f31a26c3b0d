//! Plots of a pass, both directions together: what is drawn over which angle. The drawing is in `polar` and `residual_plot`.

use super::course::shown_rows;
use super::polar::{Arrow, PolarPlot, PolarTrace, Stroke};
use super::residual_plot::residual_svg;
use crate::identify::Fit;
use crate::machine::{AxisKind, Machine};
use crate::methods::{Centred, SweptOver, TestTrace, TraceDeviations, common_centre};
use crate::session::{Motion, Session};

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

/// Plots of the recorded tests of a session, pass by pass.
pub fn pass_plots(session: &Session, fit: &Fit, passes: &[Vec<TestTrace>]) -> Vec<PassPlots> {
    let plots = |pass: &Vec<TestTrace>| PassPlots {
        tests: pass.iter().map(|one| session.tests[one.test].name.clone()).collect(),
        round: round_plots(session, fit, pass),
        residuals: pass.iter().map(|one| residual_plot(session, fit, one)).collect(),
    };
    passes.iter().map(plots).collect()
}

fn residual_plot(session: &Session, fit: &Fit, trace: &TestTrace) -> String {
    let (name, fit) = (&session.tests[trace.test].name, &fit.tests[trace.test]);
    match &trace.course.swept {
        Some(swept) => residual_svg(name, &swept_label(&session.machine, swept.over), &swept.value, fit),
        None => {
            let numbers: Vec<f64> = (0..trace.course.motion.rows()).map(|row| row as f64 + 1.0).collect();
            residual_svg(name, "reading", &numbers, fit)
        }
    }
}

/// Both directions in one picture, as read and with one common centre taken off.
fn round_plots(session: &Session, fit: &Fit, pass: &[TestTrace]) -> Option<RoundPlots> {
    let first = pass.first()?;
    first.angle_rad()?;
    let of = |one: &TestTrace| {
        let fit = &fit.tests[one.test];
        one.deviations(&session.tests[one.test], &fit.kept, &fit.residual_mm)
    };
    let rows: Vec<TraceDeviations> = pass.iter().map(of).collect();
    let centred = common_centre(pass, &rows);
    let as_read = Centred { centre: [0.0, 0.0], mean: 0.0 };
    Some(RoundPlots {
        as_read: round_plot(session, (pass, &rows), &as_read, "as read"),
        centred: centred.map(|off| {
            let [right, up] = off.centre;
            round_plot(session, (pass, &rows), &off, &format!("centre removed ({right:+.1}, {up:+.1} µm)"))
        }),
    })
}

/// Both directions of a pass with a centre taken off; `says` stands under the title.
fn round_plot(
    session: &Session,
    (pass, rows): (&[TestTrace], &[TraceDeviations]),
    off: &Centred,
    says: &str,
) -> String {
    let name = |one: &TestTrace| session.tests[one.test].name.as_str();
    let mut traces = Vec::new();
    let mut arrows = Vec::new();
    for (index, (one, deviations)) in pass.iter().zip(rows).enumerate() {
        let angles = one.angle_rad().unwrap_or_default();
        let is_ccw = one.turned_rad().unwrap_or(0.0) >= 0.0;
        let way = if is_ccw { "ccw" } else { "cw" };
        let trace = |label: String, stroke: Stroke, values: &[f64]| PolarTrace {
            label,
            points: polar_points(angles, |row| off.apply(angles[row], values[row])),
            stroke,
        };
        traces.push(trace(format!("{way}: {}", name(one)), Stroke::Own(index), &deviations.read_um));
        traces.push(trace(format!("{way}: model"), Stroke::Own(6), &deviations.model_um));
        if deviations.left_out_um.iter().any(|value| value.is_finite()) {
            traces.push(trace(format!("{way}, left out"), Stroke::Grey, &deviations.left_out_um));
        }
        arrows.extend(angles.first().map(|&from| Arrow { stroke: index, from, is_ccw }));
    }
    let names: Vec<&str> = pass.iter().map(name).collect();
    let mut plot = PolarPlot::new(names.join(" and "), traces);
    let nominal_mm = rows[0].nominal_mm;
    plot.subtitle = format!("{} · nominal {nominal_mm:.4} mm · {says}", moves(session, &pass[0].course.motion));
    plot.arrows = arrows;
    label_spokes(&session.machine, &pass[0], &mut plot);
    plot.to_svg()
}

/// Points of a polar plot, the peaks of a long trace among them; where a row has no value it is NaN, and the line breaks.
pub(crate) fn polar_points(angles: &[f64], value: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    let finite = |row: usize| Some(value(row)).filter(|value| value.is_finite());
    let shown = shown_rows(angles.len(), finite);
    shown.into_iter().map(|(row, value)| (angles[row], value.unwrap_or(f64::NAN))).collect()
}

/// `+X` to the right and `+Y` up where the bar turns in a plane; else the axis whose position the angle is.
pub(crate) fn label_spokes(machine: &Machine, trace: &TestTrace, plot: &mut PolarPlot) {
    let quarters: [String; 4] = match (&trace.turn, &trace.course.swept) {
        (Some(turn), _) => {
            let [right, up] = turn.plane.map(|k| ["X", "Y", "Z"][k]);
            quarters_of_plane(right, up)
        }
        (None, Some(swept)) => swept_quarters(machine, swept.over),
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

/// What the positions are of that a test is drawn over, with their unit.
pub(crate) fn swept_label(machine: &Machine, over: SweptOver) -> String {
    let name = |axis: usize| &machine.axes[axis].name;
    match over {
        SweptOver::Axis(axis) => match machine.axes[axis].kind {
            AxisKind::Rotary => format!("{}, °", name(axis)),
            AxisKind::Linear => format!("{}, mm", name(axis)),
        },
        SweptOver::Circle([right, up]) => format!("angle in {}{}, °", name(right), name(up)),
    }
}

/// What stands at 0, 90, 180 and 270°: axes of a planar circle with their signs, else positions of the axis.
fn swept_quarters(machine: &Machine, over: SweptOver) -> [String; 4] {
    let name = |axis: usize| &machine.axes[axis].name;
    match over {
        SweptOver::Circle([right, up]) => quarters_of_plane(name(right), name(up)),
        SweptOver::Axis(axis) => [0, 90, 180, 270].map(|degrees| format!("{} {degrees}°", name(axis))),
    }
}
