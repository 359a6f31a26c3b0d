//! The thesis's methods of chapters 4, 5 and 6 for a tilting rotary table: from mean circles to location errors.
//!
//! A sweep tells where its axis pierces the turning plane of the standing ball (`turning`). Two sweeps whose standing
//! balls are at s₁ and s₂ along the axis tell the axis as a line: with c₁, c₂ the two centres (eq. 4.2–4.5)
//!
//! ```text
//! slope = (c₂ − c₁)/(s₂ − s₁)        place at the origin = c₁ − slope·s₁
//! axis along X:  EY0 = place_y, EZ0 = place_z,  EC0 = atan slope_y,  EB0 = −atan slope_z
//! axis along Y:  EZ0 = place_z, EX0 = place_x,  EA0 = atan slope_z,  EC0 = −atan slope_x
//! axis along Z:  EX0 = place_x, EY0 = place_y,  EB0 = atan slope_x,  EA0 = −atan slope_y
//! ```
//!
//! | | chapter 4 | chapter 5 | chapter 6 |
//! |---|---|---|---|
//! | s₁, s₂ | short bar; extended bar (spindle ball moved by D along the axis) | the same | short bar at two positions |
//! | pivot | mounted once for each axis | one mounting for all four tests | mounted for each position |
//! | outer axis's position errors taken out of the inner's | yes | yes | yes |
//! | outer axis's orientation errors taken out of the inner's | not printed; taken out | not printed; taken out | yes |
//!
//! The inner axis is carried by the outer: its sweeps at outer = 0 see both errors as a sum. Chapter 6 alone prints that
//! the outer tilt is taken out; the published numbers of chapters 4 and 5 speak for it there too (`docs/thesis.md`). The
//! value with the outer tilt left in stands beside each that this concerns, in words for chapters 4 and 5. Pairings and signs are those of the machine's HTMs, where chapters 4, 5 and section
//! 6.1.2 of the thesis contradict each other (docs/methods.md). All places are relative to the spindle ball.

use super::axis_line::{AxisLine, Part};
use super::compensated::{CompensatedTrace, compensated};
use super::error::MethodError;
use super::runs::{Bar, Runs};
use super::thesis_value::{ThesisMethod, ThesisValue};
use crate::chain::{Branch, Chain};
use crate::machine::{AxisKind, Component, ErrorName, Machine};
use crate::session::{Motion, Session};

/// Result of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct ThesisEstimate {
    pub method: ThesisMethod,
    /// Outer axis first, positions before orientations.
    pub values: Vec<ThesisValue>,
    /// The tests used: for the outer and the inner axis the circles at s₁ and at s₂.
    pub runs: Vec<Runs>,
    /// Every used test with the found errors taken out.
    pub traces: Vec<CompensatedTrace>,
    /// What a reader must know beside the numbers.
    pub remarks: Vec<String>,
}

/// Chapter 4: the short and the extended bar on each axis, the pivot mounted once for each axis.
pub fn chapter4(session: &Session) -> Result<ThesisEstimate, MethodError> {
    estimate(session, ThesisMethod::Chapter4)
}

/// Chapter 5: the same four tests from one pivot mounting.
pub fn chapter5(session: &Session) -> Result<ThesisEstimate, MethodError> {
    estimate(session, ThesisMethod::Chapter5)
}

/// Chapter 6: the short bar at two positions along each axis.
pub fn chapter6(session: &Session) -> Result<ThesisEstimate, MethodError> {
    estimate(session, ThesisMethod::Chapter6)
}

/// Shortest distance between two positions along an axis that give its direction, mm.
const APART_MM: f64 = 10.0;
/// Largest angle of the outer axis in the inner axis's tests, rad.
const OUTER_AT_ZERO_RAD: f64 = 1e-4;

fn estimate(session: &Session, method: ThesisMethod) -> Result<ThesisEstimate, MethodError> {
    let machine = &session.machine;
    let chain = Chain::of(machine);
    let [outer, inner] = table_axes(machine, &chain)?;
    let all = Runs::of(session, &chain)?;
    let [outer_runs, inner_runs] = choose(session, method, [outer, inner], &all)?;
    for circle in inner_runs.iter().flat_map(|runs| &runs.circles) {
        outer_at_zero(session, &chain, circle.test, outer)?;
    }
    let outer_line = AxisLine::through(machine, outer, outer_runs);
    let seen_line = AxisLine::through(machine, inner, inner_runs);
    let take_out = |part: Part| outer_line.carried(part, &seen_line);
    let placed = seen_line.less(&take_out(Part::Place));
    let inner_line = placed.less(&take_out(Part::Turn));
    let mut values = outer_line.values(machine, outer);
    let mut inner_values = inner_line.values(machine, inner);
    say_left_in(machine, outer, &placed.values(machine, inner), &mut inner_values);
    let mut remarks = Vec::new();
    if method != ThesisMethod::Chapter6 {
        remarks.extend(inner_values.iter().filter_map(in_words));
    }
    values.extend(inner_values);
    let spindle = &session.tests[outer_runs[0].circles[0].test].spindle_ball;
    remarks.push(format!(
        "places are relative to the spindle ball on {}: an error of its place adds to every position error",
        spindle.link
    ));
    let used: Vec<Runs> = [outer_runs, inner_runs].into_iter().flatten().cloned().collect();
    let unused: Vec<String> =
        all.iter().filter(|runs| !used.contains(runs)).map(|runs| described(machine, runs)).collect();
    if !unused.is_empty() {
        remarks.push(format!("not used by {method}: {}", unused.join("; ")));
    }
    let traces = compensated(session, &chain, &values, &used)?;
    Ok(ThesisEstimate { method, values, runs: used, traces, remarks })
}

/// The two rotary axes of a tilting rotary table, outer first.
fn table_axes(machine: &Machine, chain: &Chain) -> Result<[usize; 2], MethodError> {
    let refuse = |reason: String| MethodError::Machine { code: machine.code.to_string(), reason };
    let rotary = |axis: &usize| machine.axes[*axis].kind == AxisKind::Rotary;
    let table: Vec<usize> = chain.branch(Branch::Workpiece).iter().copied().filter(rotary).collect();
    let [outer, inner] = table[..] else {
        return Err(refuse(format!(
            "it has {} rotary axes between bed and workpiece, and they are for the two of a tilting rotary table",
            table.len()
        )));
    };
    for axis in [outer, inner] {
        if machine.axes[axis].coordinate_direction().is_none() {
            return Err(refuse(format!("axis {} is inclined", machine.axes[axis].name)));
        }
    }
    if machine.axes[outer].coordinate_direction() == machine.axes[inner].coordinate_direction() {
        return Err(refuse("its two rotary axes are parallel".into()));
    }
    Ok([outer, inner])
}

/// The two groups of runs of each axis that a method asks for.
fn choose<'a>(
    session: &Session,
    method: ThesisMethod,
    axes: [usize; 2],
    all: &'a [Runs],
) -> Result<[[&'a Runs; 2]; 2], MethodError> {
    let machine = &session.machine;
    let found = || match all {
        [] => "no recorded sweep of a single rotary axis with one ball on it and the other on its line".to_string(),
        _ => all.iter().map(|runs| described(machine, runs)).collect::<Vec<_>>().join("; "),
    };
    let missing = |wanted: String| MethodError::MissingTest { method, wanted, found: found() };
    let of = |axis: usize, bar: Bar| all.iter().filter(move |runs| runs.axis == axis && runs.bar == bar);
    let first = |axis: usize, bar: Bar, pivot: Option<usize>| {
        let what = match bar {
            Bar::Short => "without extension (both balls in the turning plane)",
            Bar::Extended => "with extension (the spindle ball moved along the axis)",
        };
        of(axis, bar).find(|runs| pivot.is_none_or(|pivot| runs.pivot == pivot)).ok_or_else(|| {
            let same = if pivot.is_some() { " from the same pivot mounting" } else { "" };
            missing(format!("a test of {} {what}{same}", machine.axes[axis].name))
        })
    };
    let two_bars = |axis: usize, pivot: Option<usize>| -> Result<[&Runs; 2], MethodError> {
        let short = first(axis, Bar::Short, pivot)?;
        Ok([short, first(axis, Bar::Extended, Some(short.pivot))?])
    };
    match method {
        ThesisMethod::Chapter4 => Ok([two_bars(axes[0], None)?, two_bars(axes[1], None)?]),
        ThesisMethod::Chapter5 => {
            let outer = two_bars(axes[0], None)?;
            Ok([outer, two_bars(axes[1], Some(outer[0].pivot))?])
        }
        ThesisMethod::Chapter6 => {
            let two_places = |axis: usize| -> Result<[&Runs; 2], MethodError> {
                let low = of(axis, Bar::Short).min_by(|a, b| a.at_mm.total_cmp(&b.at_mm));
                let high = of(axis, Bar::Short).max_by(|a, b| a.at_mm.total_cmp(&b.at_mm));
                match (low, high) {
                    (Some(low), Some(high)) if high.at_mm - low.at_mm >= APART_MM => Ok([low, high]),
                    _ => Err(missing(format!(
                        "tests of {} without extension at two positions along it, at least {APART_MM} mm apart",
                        machine.axes[axis].name
                    ))),
                }
            };
            Ok([two_places(axes[0])?, two_places(axes[1])?])
        }
    }
}

/// A group of runs in words, for messages.
fn described(machine: &Machine, runs: &Runs) -> String {
    let bar = match runs.bar {
        Bar::Short => "without extension",
        Bar::Extended => "with extension",
    };
    let count = runs.circles.len();
    let plural = if count == 1 { "run" } else { "runs" };
    format!("{} {bar} at {:.1} mm ({count} {plural})", machine.axes[runs.axis].name, runs.at_mm)
}

fn outer_at_zero(session: &Session, chain: &Chain, test: usize, outer: usize) -> Result<(), MethodError> {
    let test = &session.tests[test];
    let stands_at = Motion::of(session, chain, test)?.row(0)[outer];
    if stands_at.abs() > OUTER_AT_ZERO_RAD {
        return Err(MethodError::Test {
            test: test.name.clone(),
            reason: format!(
                "has {} at {:.3}°; the thesis's formulas hold at 0°",
                session.machine.axes[outer].name,
                stands_at.to_degrees()
            ),
        });
    }
    Ok(())
}

/// Puts beside the inner axis's orientation errors what they are with the outer axis's left in.
fn say_left_in(machine: &Machine, outer: usize, placed: &[ThesisValue], values: &mut [ThesisValue]) {
    let tilts: Vec<Component> = machine.axes[outer].slots().into_iter().filter(|slot| slot.is_angle()).collect();
    for (value, placed) in values.iter_mut().zip(placed) {
        let component = value.name.component;
        if tilts.contains(&component) {
            let taken_out = ErrorName::location(component, &machine.axes[outer].name);
            value.left_in = Some((taken_out, placed.value));
        }
    }
}

fn in_words(value: &ThesisValue) -> Option<String> {
    let (taken_out, left_in) = value.left_in.as_ref()?;
    let measure = value.name.component.measure();
    Some(format!(
        "{taken_out} is taken out of {0}, which chapters 4 and 5 do not print and their results speak for; left in, {0} = {1:.2} {2}",
        value.name,
        measure.to_output(*left_in),
        measure.output_unit()
    ))
}
