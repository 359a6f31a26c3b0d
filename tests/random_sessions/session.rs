//! Random sessions on a machine: sweeps, circles, runs of several axes, static poses, few samples or many, read well or badly.

use std::fmt::Write as _;
use std::path::Path;

use fiveaxis::chain::Composition;
use fiveaxis::load::load_session;
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::session::Session;
use fiveaxis::simulate::{Trace, simulate};

use super::draws::Draws;

/// A test as it is put together: the file's keys, and its recording.
struct Test {
    name: String,
    keys: String,
    path: Option<String>,
    /// Rows of a recording that no path gives: clock, names of columns, values.
    rows: Option<(bool, Vec<usize>, Vec<Vec<f64>>)>,
}

/// Tests drawn for one that the machine can run.
const TRIES: usize = 12;

/// Writes `planned.yaml`, `session.yaml` and its recordings beside `machine.yaml`; false when the machine can run no test.
pub fn write(folder: &Path, machine: &Machine, draws: &mut Draws) -> bool {
    let head = head(draws);
    let most = *draws.one(&[1, 2, 4, 4, 8, 30]);
    let tests: Vec<Test> = (0..draws.count(1, most))
        .filter_map(|index| {
            (0..TRIES)
                .map(|_| test(draws, machine, index))
                .find(|test| traced(folder, machine, &head, &[test]).is_some())
        })
        .collect();
    let planned = tests.iter().filter_map(|test| Some(format!("{}    {}\n", test.keys, test.path.as_ref()?)));
    let planned: String = planned.collect();
    if !planned.is_empty() {
        std::fs::write(folder.join("planned.yaml"), format!("{head}{planned}")).unwrap();
    }
    let all: Vec<&Test> = tests.iter().collect();
    let Some((session, traces)) = traced(folder, machine, &head, &all) else { return false };
    let mut text = head;
    let noise_mm = *draws.one(&[0.0, 1e-7, 3e-4, 3e-4, 0.02]);
    for (test, trace) in tests.iter().zip(&traces) {
        text.push_str(&test.keys);
        text.push_str(&recorded(folder, &session, test, trace, noise_mm, draws));
    }
    std::fs::write(folder.join("session.yaml"), &text).unwrap();
    true
}

/// Lengths of tests that the machine can run and a gauge could read.
fn traced(folder: &Path, machine: &Machine, head: &str, tests: &[&Test]) -> Option<(Session, Vec<Trace>)> {
    let mut text = head.to_string();
    for test in tests {
        text.push_str(&test.keys);
        if let Some((timed, axes, rows)) = &test.rows {
            // lengths that say nothing, to have them worked out
            let csv = csv(machine, *timed, axes, rows, &vec![100.0; rows.len()]);
            std::fs::write(folder.join(format!("{}.csv", test.name)), csv).unwrap();
        }
        let _ = writeln!(text, "    {}", test.path.clone().unwrap_or(format!("recording: {}.csv", test.name)));
    }
    let file = folder.join("session.yaml");
    std::fs::write(&file, &text).unwrap();
    let session = load_session(&file).ok()?;
    let traces = simulate(&session, Composition::Exact).ok()?;
    let reads = traces.iter().all(|trace| {
        let stands = trace.motion.time_s.iter().any(|time| time.windows(2).any(|pair| pair[1] <= pair[0]));
        !stands && trace.length_mm.iter().all(|length| *length > 6.0)
    });
    let in_range = traces.iter().all(|trace| {
        let ranges = machine.axes.iter().map(|axis| axis.range);
        ranges.enumerate().all(|(axis, range)| {
            range.is_none_or(|(from, to)| trace.motion.axis(axis).all(|q| (from..=to).contains(&q)))
        })
    });
    (reads && in_range).then_some((session, traces))
}

fn head(draws: &mut Draws) -> String {
    let spread = match draws.count(0, 3) {
        0 => format!("spread: {{pivot: {} um}}\n", draws.magnitude(1e-3, 5e4).abs()),
        1 => format!("spread: {{spindle_ball: {} um, bar_length: 0.001 um}}\n", draws.magnitude(1e-3, 1e3).abs()),
        _ => String::new(),
    };
    format!("machine: machine.yaml\n{spread}tests:\n")
}

fn of_kind(machine: &Machine, kind: AxisKind) -> Vec<usize> {
    (0..machine.axes.len()).filter(|&axis| machine.axes[axis].kind == kind).collect()
}

fn test(draws: &mut Draws, machine: &Machine, index: usize) -> Test {
    let (rotary, linear) = (of_kind(machine, AxisKind::Rotary), of_kind(machine, AxisKind::Linear));
    let name = format!("t{index}");
    let at_zero = draws.percent(60);
    let mut standing: Vec<f64> = machine
        .axes
        .iter()
        .map(|_| if at_zero { 0.0 } else { (draws.between(-40.0, 40.0) * 10.0).round() / 10.0 })
        .collect();
    let reach = *draws.one(&[0.5, 60.0, 120.0, 120.0, 400.0, 3000.0]);
    let (mut pivot, mut spindle) = (draws.vector(reach), draws.vector(reach));
    // short sweeps with few rows among them
    let arc = *draws.one(&[0.02, 3.0, 20.0, 90.0, 180.0, 360.0]);
    let step = arc / *draws.one(&[1.0, 2.0, 5.0, 12.0, 40.0, 40.0]);
    let (from, to) = if draws.percent(50) { (0.0, arc) } else { (arc, 0.0) };
    let mut path = None;
    let mut rows = None;
    let letters: Vec<&str> =
        linear.iter().map(|&axis| machine.axes[axis].name.as_str()).filter(|name| name.len() == 1).collect();
    match draws.count(0, 9) {
        0..=4 if !rotary.is_empty() => {
            let axis = *draws.one(&rotary);
            let line = &machine.axes[axis];
            let follow = *draws.one(&["none", "none", "none", "radial", "tangential", "axial"]);
            if follow == "none" && draws.percent(80) {
                // one ball on the line of the axis: the length stays
                standing.fill(0.0);
                let along = *draws.one(&[0.0, 50.0, 120.0, -200.0]);
                spindle = (line.origin + line.direction * along).into();
                if draws.percent(50) {
                    std::mem::swap(&mut pivot, &mut spindle);
                }
            }
            path =
                Some(format!("sweep: {{axis: {}, from: {from}, to: {to}, step: {step}, follow: {follow}}}", line.name));
        }
        5 | 6 if letters.len() >= 2 => {
            let plane = draws.shuffled(&letters)[..2].concat();
            let radius = *draws.one(&[0.01, 1.0, 100.0, 150.0, 1500.0]);
            path = Some(format!("circle: {{plane: {plane}, radius: {radius}, from: {from}, to: {to}, step: {step}}}"));
        }
        7 if !linear.is_empty() => {
            let axis = &machine.axes[*draws.one(&linear)].name;
            path = Some(format!("sweep: {{axis: {axis}, from: {from}, to: {to}, step: {step}}}"));
        }
        choice => rows = Some(free_rows(draws, machine, choice == 8, &standing)),
    }
    let keys = keys(draws, machine, &name, index, (&pivot, &spindle), &standing);
    Test { name, keys, path, rows }
}

/// Rows of static poses, or of a run in time, of some axes.
fn free_rows(draws: &mut Draws, machine: &Machine, timed: bool, standing: &[f64]) -> (bool, Vec<usize>, Vec<Vec<f64>>) {
    let all: Vec<usize> = (0..machine.axes.len()).collect();
    let moving = draws.count(1, all.len());
    let axes: Vec<usize> = draws.shuffled(&all).into_iter().take(moving).collect();
    let count = *draws.one(&[1, 2, 6, 20, 60]);
    // an axis with a column may stand all the same
    let reach: Vec<f64> = axes.iter().map(|_| *draws.one(&[0.0, 0.001, 5.0, 90.0])).collect();
    let rows = (0..count).map(|row| {
        let share = if timed { (row as f64 / count as f64 * 6.0).sin() } else { draws.between(-1.0, 1.0) };
        axes.iter().zip(&reach).map(|(&axis, reach)| ((standing[axis] + reach * share) * 1e6).round() / 1e6).collect()
    });
    let rows = rows.collect();
    (timed, axes, rows)
}

fn keys(
    draws: &mut Draws,
    machine: &Machine,
    name: &str,
    index: usize,
    (pivot, spindle): (&[f64; 3], &[f64; 3]),
    standing: &[f64],
) -> String {
    let mut keys = format!("  - name: {name}\n");
    let mut key = |text: String| {
        let _ = writeln!(keys, "    {text}");
    };
    if draws.percent(85) {
        key(format!("started_at: {}", index as f64 * *draws.one(&[0.0, 1.0, 100.0, 1e5])));
    }
    if draws.percent(50) {
        key(format!("feed: {}", draws.one(&[0.1, 60.0, 500.0, 1e5])));
    }
    if draws.percent(10) {
        key(format!("overshoot: {}", draws.one(&[0.0, 2.0, 90.0])));
    }
    let extra = match draws.count(0, 9) {
        0 => ", setup: second".to_string(),
        1 => format!(", spread: {} um", draws.magnitude(1e-3, 1e4).abs()),
        _ => String::new(),
    };
    key(format!("pivot: {{link: w, at: {pivot:?}{extra}}}"));
    let indexed = if draws.percent(5) { ", indexed_about: z" } else { "" };
    key(format!("spindle_ball: {{link: t, at: {spindle:?}{indexed}}}"));
    let places = machine.axes.iter().zip(standing).map(|(axis, place)| format!("{}: {place}", axis.name));
    key(format!("positions: {{{}}}", places.collect::<Vec<_>>().join(", ")));
    keys
}

/// Column heads and rows as they stand in a recording.
fn csv(machine: &Machine, timed: bool, axes: &[usize], rows: &[Vec<f64>], length_mm: &[f64]) -> String {
    let column = |&axis: &usize| format!("{}_{}", machine.axes[axis].name, machine.axes[axis].kind.position_unit());
    let heads: Vec<String> = axes.iter().map(column).collect();
    let mut text = format!("{},{},length_mm\n", if timed { "time_s" } else { "pose" }, heads.join(","));
    for (row, (places, length)) in rows.iter().zip(length_mm).enumerate() {
        let places: Vec<String> = places.iter().map(f64::to_string).collect();
        let _ = writeln!(text, "{},{},{length}", if timed { row as f64 * 0.2 } else { row as f64 }, places.join(","));
    }
    text
}

/// Writes the recording of a test; returns the keys that name it.
fn recorded(folder: &Path, session: &Session, test: &Test, trace: &Trace, noise_mm: f64, draws: &mut Draws) -> String {
    let machine = &session.machine;
    let has_path = test.path.is_some();
    let mut length_mm: Vec<f64> = trace.length_mm.iter().map(|length| length + noise_mm * draws.normal()).collect();
    let spread = length_mm.iter().fold((f64::MAX, f64::MIN), |(a, b), length| (a.min(*length), b.max(*length)));
    let bar = spread.1 - spread.0 < 4.0 && draws.percent(80);
    if draws.percent(15) {
        // a gross outlier, a gauge that stands, readings of whole micrometres
        let row = draws.count(0, length_mm.len() - 1);
        match draws.count(0, 2) {
            0 => length_mm[row] += 0.3,
            1 => length_mm.fill(trace.length_mm[0]),
            _ => length_mm.iter_mut().for_each(|length| *length = (*length * 1e3).round() / 1e3),
        }
    }
    let mut keys = String::new();
    if bar {
        let _ = writeln!(keys, "    bar_length: {:.4}", (spread.0 + spread.1) / 2.0);
    }
    let missing = *draws.one(&[0, 0, 0, 20, 95]);
    let channel = draws.percent(25);
    let lengths_only = has_path && draws.percent(20);
    let mut columns = vec![if trace.motion.time_s.is_some() { "time_s" } else { "pose" }.to_string()];
    columns.extend(
        trace
            .motion
            .moving
            .iter()
            .map(|&axis| format!("{}_{}", machine.axes[axis].name, machine.axes[axis].kind.position_unit())),
    );
    if lengths_only {
        columns.clear();
    }
    columns.push("length_mm".into());
    if channel {
        columns.push("temperature_degC".into());
    }
    let separator = *draws.one(&[",", ",", ";", "\t"]);
    let mut text = columns.join(separator) + "\n";
    for (row, length) in length_mm.iter().enumerate() {
        let mut fields = Vec::new();
        if !lengths_only {
            fields.push(trace.motion.time_s.as_ref().map_or(row as f64, |time| time[row]).to_string());
            let places = trace.motion.moving.iter();
            fields.extend(
                places.map(|&axis| machine.axes[axis].kind.to_file_unit(trace.motion.row(row)[axis]).to_string()),
            );
        }
        // one reading at least
        let is_missing = row > 0 && !lengths_only && draws.percent(missing);
        fields.push(if is_missing { String::new() } else { length.to_string() });
        if channel {
            fields.push((20.0 + 0.01 * row as f64).to_string());
        }
        text.push_str(&(fields.join(separator) + "\n"));
    }
    std::fs::write(folder.join(format!("{}.csv", test.name)), text).unwrap();
    let _ = writeln!(keys, "    recording: {}.csv", test.name);
    if lengths_only || has_path && draws.percent(50) {
        let _ = writeln!(keys, "    {}", test.path.as_deref().unwrap_or_default());
    }
    keys
}
