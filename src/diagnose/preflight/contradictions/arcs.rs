//! Arcs that are not those of the test: of another sweep than the session states, or shorter than in the test's own repeats.

use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER};
use crate::machine::AxisKind;
use crate::session::{Clock, Path, Recording, Session, Test};
use crate::units::OtherUnit;

/// How far the ends of a recorded arc may lie from the stated ones: a share of the arc, and mm or degrees.
const END_SHARE: f64 = 0.02;
const END_LEAST: f64 = 2.0;

/// Share of its repeats' arc below which a recording is cut short.
const CUT_SHORT: f64 = 0.8;

/// A recording whose arc is not that of its test.
pub(super) fn other_arc(session: &Session) -> Option<DataFault> {
    let against = session.tests.iter().find_map(|test| against_sweep(session, test));
    against.or_else(|| beside_sweep(session)).or_else(|| cut_short(session))
}

/// By how much two runs of one arc may differ in time, as a share: controls keep their feed better than that, and an override slows both.
const OTHER_TIME: f64 = 0.02;

/// How near the ends of one arc are stated in both directions, mm or degrees.
const SAME_END: f64 = 0.01;

/// A recording without positions that lasts otherwise than another run of its arc: its rows are taken as even on the arc, and are not.
pub(super) fn uncut(session: &Session) -> Option<DataFault> {
    let lasts = |test: &Test| -> Option<(f64, &'static str)> {
        let recording = test.recording.as_ref().filter(|recording| recording.clock == Clock::Absent)?;
        match recording.written_time_s() {
            Some(time_s) => Some((time_s.last()? - time_s.first()?, "s")),
            // without times rows count: one program is recorded at one rate
            None => Some((recording.len().checked_sub(1)? as f64, "rows")),
        }
    };
    let arc = |test: &Test| match test.path {
        Some(Path::Sweep { axis, from, to, follow, .. }) => Some((axis, from.min(to), from.max(to), follow)),
        _ => None,
    };
    let is_one_arc = |one: &Test, other: &Test| match (arc(one), arc(other)) {
        (Some((axis, from, to, follow)), Some((other, first, last, another))) => {
            (axis, follow) == (other, another) && (from - first).abs().max((to - last).abs()) < SAME_END
        }
        _ => false,
    };
    let is_other_run = |one: &Test, other: &Test| one.is_repeat_of(other) && is_one_arc(one, other);
    let runs: Vec<(&Test, (f64, &str))> =
        session.tests.iter().filter_map(|test| arc(test).and(Some((test, lasts(test)?)))).collect();
    let off = runs.iter().enumerate().flat_map(|(k, &(one, (first, unit)))| {
        let others = runs[k + 1..].iter().filter(move |(other, last)| last.1 == unit && is_other_run(one, other));
        others.map(move |&(other, (second, _))| ((first / second).ln().abs(), (one, first), (other, second), unit))
    });
    let (off, (one, first), (other, second), unit) = off.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let says = format!(
        "{} lasts {first:.1} {unit} and {} {second:.1} {unit} for one arc at one feed: one of them holds rows from before or after the arc, or \
         lacks some; nothing says where the axis stood, so cut both to the arc, or give the captures to fiveaxis import",
        one.name, other.name
    );
    (off > OTHER_TIME)
        .then(|| DataFault::seen(FaultKind::Arc, RECORDER, vec![one.name.clone(), other.name.clone()], says))
}

/// Whether a recording has both ends where the sweep of its test states them, as recordings have that were made by its program.
pub(crate) fn agrees_with_sweep(session: &Session, test: &Test) -> bool {
    off_sweep(session, test).is_some_and(|(_, off)| off.iter().all(|off| off.abs() < END_TOLERANCE))
}

/// How far both ends of a recorded arc lie from the stated ones, mm or degrees, with the axis.
fn off_sweep(session: &Session, test: &Test) -> Option<(usize, [f64; 2])> {
    let Some(Path::Sweep { axis, from, to, .. }) = test.path else { return None };
    let (first, last) = ends(session, test.recording.as_ref()?, axis)?;
    Some((axis, [first - from, last - to]))
}

/// Degrees or mm by which both ends of an arc may lie beside the stated ones: rows are some tenths apart.
const END_TOLERANCE: f64 = 0.7;

/// How far the arc's own length may then be off, as a share of how far it lies beside.
const AS_LONG: f64 = 0.2;

/// An arc as long as stated that lies beside where the sweep states it, while others of the session lie where theirs do.
fn beside_sweep(session: &Session) -> Option<DataFault> {
    let others = session.tests.iter().filter(|test| agrees_with_sweep(session, test)).count();
    session.tests.iter().filter(|_| 2 * others >= session.tests.len()).find_map(|test| {
        let (axis, [first, last]) = off_sweep(session, test)?;
        let beside = 0.5 * (first + last);
        let axis = Some(&session.machine.axes[axis]).filter(|axis| axis.kind == AxisKind::Rotary)?;
        if beside.abs() < END_TOLERANCE || (last - first).abs() > AS_LONG * beside.abs() {
            return None;
        }
        let says = format!(
            "column {} of {} lies {beside:+.2}° beside the sweep that the session states, where other recordings lie on theirs: the \
             recording began late, or counts from another zero; take {beside:.2} off the column, or state the sweep that was run",
            axis.name, test.name
        );
        let mut fault = DataFault::seen(FaultKind::ColumnShifted, RECORDER, vec![test.name.clone()], says);
        fault.components = vec![axis.name.clone()];
        Some(fault)
    })
}

/// Recordings of an axis whose ends are those of their sweeps in another unit.
pub(super) fn in_other_unit(session: &Session) -> Option<DataFault> {
    let axis_in_unit = |test: &Test| -> Option<usize> {
        let Some(Path::Sweep { axis, from, to, .. }) = test.path else { return None };
        let (unit, _) = unit_instead(session.machine.axes[axis].kind);
        let (first, last) = ends(session, test.recording.as_ref()?, axis)?;
        let allowed = allowed_at_ends(from, to);
        let near = |size: f64| (size * first - from).abs() <= allowed && (size * last - to).abs() <= allowed;
        (near(unit.size) && !near(1.0)).then_some(axis)
    };
    let axis = session.tests.iter().find_map(axis_in_unit)?;
    let of_axis = session.tests.iter().filter(|test| axis_in_unit(test) == Some(axis));
    let tests: Vec<String> = of_axis.map(|test| test.name.clone()).collect();
    let name = &session.machine.axes[axis].name;
    let (unit, due) = unit_instead(session.machine.axes[axis].kind);
    let says = format!(
        "{name} is in {} in {}: converted, it ends where the session's sweeps do; convert the column to {due}",
        unit.name,
        tests.join(", ")
    );
    let fault = DataFault::seen(FaultKind::Unit, RECORDER, tests, says);
    Some(DataFault { components: vec![name.clone()], ..fault })
}

/// Unit in which a column of an axis may be by mistake, and the one in which it is due.
pub(crate) fn unit_instead(kind: AxisKind) -> (OtherUnit, &'static str) {
    match kind {
        AxisKind::Linear => (OtherUnit::INCHES, "mm"),
        AxisKind::Rotary => (OtherUnit::RADIANS, "degrees"),
    }
}

/// How far the ends of a recorded arc may lie from those stated, mm or degrees.
fn allowed_at_ends(from: f64, to: f64) -> f64 {
    (END_SHARE * (to - from).abs()).max(END_LEAST)
}

/// Ends of the recorded travel of an axis, mm or degrees, for recordings in time.
fn ends(session: &Session, recording: &Recording, axis: usize) -> Option<(f64, f64)> {
    let column = &recording.positions[recording.swept(axis)?];
    let kind = session.machine.axes[axis].kind;
    let (first, last) = (column.first()?, column.last()?);
    Some((kind.to_file_unit(*first), kind.to_file_unit(*last)))
}

fn against_sweep(session: &Session, test: &Test) -> Option<DataFault> {
    let recording = test.recording.as_ref()?;
    let Some(Path::Sweep { axis, from, to, .. }) = test.path else { return None };
    let (first, last) = ends(session, recording, axis)?;
    let allowed = allowed_at_ends(from, to);
    let near = |a: f64, b: f64| (a - b).abs() <= allowed;
    if near(first, from) && near(last, to) {
        return None;
    }
    let name = &session.machine.axes[axis].name;
    let (kind, what) = match near(first, to) && near(last, from) {
        true => (FaultKind::Direction, "it was run the other way, or is the file of the other direction"),
        false => (FaultKind::Arc, "it was cut short, has its run-in left in, or is the file of another test"),
    };
    let says = format!(
        "the recording of {} runs from {name} = {first:.2} to {last:.2}, its sweep from {from} to {to}: {what}; name the right file, or state the sweep that was run",
        test.name
    );
    let mut fault = DataFault::seen(kind, RECORDER, vec![test.name.clone()], says);
    fault.components = vec![name.clone()];
    Some(fault)
}

/// A sweep of one rotary axis that is shorter than its repeats.
fn cut_short(session: &Session) -> Option<DataFault> {
    let arc = |index: usize| -> Option<(usize, f64)> {
        let test = &session.tests[index];
        let recording = test.recording.as_ref().filter(|_| test.path.is_none())?;
        let is_rotary = |axis: &usize| session.machine.axes[*axis].kind == AxisKind::Rotary;
        let mut turning = recording.axes.iter().copied().filter(is_rotary);
        let axis = turning.next().filter(|_| turning.next().is_none())?;
        let (first, last) = ends(session, recording, axis)?;
        Some((axis, (last - first).abs()))
    };
    let arcs: Vec<Option<(usize, f64)>> = (0..session.tests.len()).map(arc).collect();
    (0..arcs.len()).find_map(|index| {
        let (axis, own) = arcs[index]?;
        let repeats = (0..arcs.len()).filter(|&other| other != index && session.tests[index].is_repeat_of(&session.tests[other]));
        let others: Vec<f64> =
            repeats.filter_map(|other| arcs[other].filter(|arc| arc.0 == axis)).map(|arc| arc.1).collect();
        let due = others.iter().copied().reduce(f64::max)?;
        // sweeps over several arcs from one setup are no repeats of one
        let alike = others.iter().all(|other| due - other <= END_SHARE * due);
        let test = &session.tests[index].name;
        let name = &session.machine.axes[axis].name;
        let says = format!(
            "the recording of {test} covers {own:.1}° of {name} where its repeats cover {due:.1}°: the file is cut short; fetch it again, or state its own sweep"
        );
        let mut fault = DataFault::seen(FaultKind::Arc, RECORDER, vec![test.clone()], says);
        fault.components = vec![name.clone()];
        (alike && own < CUT_SHORT * due).then_some(fault)
    })
}
