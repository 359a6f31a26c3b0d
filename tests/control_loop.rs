//! Programs run by LinuxCNC's own planner: sweeps keep their feed and the bar the length of the session. Skipped, and said so, without it.
//!
//! `FIVEAXIS_CONTROL_LOOP` names machine files of `machines/`, separated by commas, whose plans are run as a whole, with circles
//! unless `FIVEAXIS_CONTROL_CIRCLES=no`, at `FIVEAXIS_CONTROL_FEED` mm/min; else one short program is run.

mod skipped;

use std::path::{Path, PathBuf};
use std::process::Command;

use fiveaxis::chain::{Chain, Geometry};
use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::nc::{Dialect, program};
use fiveaxis::plan::{PlannedTest, Settings, bare_session, plan};
use fiveaxis::session::{Motion, Path as TestPath, Test};
use nalgebra::Vector3;

/// Speed relative to the feed over the whole arc.
const PACE: [f64; 2] = [0.95, 1.05];
/// Bar of the recorded positions from that of the session's own, mm.
const BAR_MM: f64 = 0.5e-3;
/// Milliseconds over which a speed is taken: the servo clock's jitter is below a tenth of one.
const WINDOW: usize = 10;

fn control() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let run = std::env::var_os("FIVEAXIS_SHARED").map_or_else(beside, PathBuf::from).join("control-loop/run");
    let installed = std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|folder| folder.join("linuxcnc").is_file()));
    if run.is_file() && installed {
        return Some(run);
    }
    skipped::skipped("linuxcnc is not on the PATH, or control-loop not in the reference data");
    None
}

/// Positions of all axes every millisecond, s, mm and rad.
struct Trace {
    rows: Vec<(f64, Vec<f64>)>,
}

fn traced(run: &Path, machine: &Machine, text: &str) -> Trace {
    let folder = tempfile::tempdir().expect("folder");
    let (file, trace) = (folder.path().join("program.ngc"), folder.path().join("trace.csv"));
    std::fs::write(&file, text).expect("written");
    let mut rotary: Vec<&str> =
        machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary).map(|axis| axis.name.as_str()).collect();
    rotary.sort_unstable();
    let output = Command::new(run)
        .args([&file, &trace])
        .env("ROTARY", rotary.concat())
        .env("MOST_SECONDS", "900")
        .stdin(std::process::Stdio::null())
        .output()
        .expect("the control starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&trace).expect("trace");
    let mut lines = text.lines();
    let names: Vec<usize> = lines
        .next()
        .expect("head")
        .split(',')
        .filter_map(|name| machine.axis_index(name.split('_').next().expect("axis")))
        .collect();
    let rows = lines
        .map(|line| {
            let values: Vec<f64> = line.split(',').map(|value| value.parse().expect("number")).collect();
            let mut q = vec![0.0; machine.axes.len()];
            names.iter().zip(&values[1..]).for_each(|(&k, value)| q[k] = machine.axes[k].kind.from_file_unit(*value));
            (values[0], q)
        })
        .collect();
    Trace { rows }
}

/// Ways between two positions, mm: of one ball as seen from the other, and of the linear axes together.
fn ways(machine: &Machine, bar: &impl Fn(&[f64]) -> Vector3<f64>, from: &[f64], to: &[f64]) -> [f64; 2] {
    let linear = (0..to.len()).filter(|&k| machine.axes[k].kind == AxisKind::Linear);
    [(bar(to) - bar(from)).norm(), linear.map(|k| (to[k] - from[k]).powi(2)).sum::<f64>().sqrt()]
}

/// What one direction of a test came to: least and greatest speed relative to the feed, bar off by mm, part of the arc seen.
fn judged(machine: &Machine, test: &Test, trace: &Trace) -> ([f64; 2], f64, f64) {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let (pivot, spindle) = test.links(&chain).expect("links");
    let bar = |q: &[f64]| {
        geometry.point(spindle, &test.spindle_ball.at, q, None) - geometry.point(pivot, &test.pivot.at, q, None)
    };
    let (TestPath::Sweep { from, to, .. } | TestPath::Circle { from, to, .. }) = test.path.as_ref().expect("path");
    let own = Motion::of(&bare_session(machine), &chain, test).expect("motion");
    // where the path is at a row: the swept axis, or the angle about the middle of a circle
    let place = |q: &[f64]| match test.path.as_ref().expect("path") {
        TestPath::Sweep { axis, .. } => machine.axes[*axis].kind.to_file_unit(q[*axis]),
        TestPath::Circle { plane, from, to, .. } => {
            // of the bar in R, whichever link a linear axis carries
            let along = |axis: usize| bar(q).dot(&machine.axes[axis].direction);
            let angle = along(plane.second).atan2(along(plane.first)).to_degrees();
            let half = 0.5 * (from + to);
            half + (angle - half + 180.0).rem_euclid(360.0) - 180.0
        }
    };
    // the session's own bar there: constant where axes follow, a sweep's by the swept axis
    let session_bar = |q: &[f64]| match &test.path {
        Some(TestPath::Sweep { axis, follow: fiveaxis::session::Follow::None, .. }) => {
            let mut own = own.row(0).to_vec();
            own[*axis] = q[*axis];
            bar(&own).norm()
        }
        _ => test.bar_length_mm.expect("bar").round(),
    };
    let way = (to - from).signum();
    let stands =
        |q: &[f64]| test.positions.iter().zip(q).all(|(stands, q)| stands.is_none_or(|at| (at - q).abs() < 1e-4));
    let on_arc = |q: &[f64]| {
        let at = place(q);
        stands(q) && at > from.min(*to) && at < from.max(*to) && (bar(q).norm() - session_bar(q)).abs() < 0.9
    };
    // the longest stretch on the arc that goes the test's way
    let rows: Vec<(&(f64, Vec<f64>), f64)> = trace.rows.iter().map(|row| (row, place(&row.1))).collect();
    // run-in and run-out of a full circle lie on it as well: there the angle begins anew
    let goes_on = |a: &(&(f64, Vec<f64>), f64), b: &(&(f64, Vec<f64>), f64)| {
        on_arc(&a.0.1) && on_arc(&b.0.1) && (a.1 - b.1).abs() < 180.0
    };
    let stretches = rows.chunk_by(goes_on);
    let gone = |stretch: &[(&(f64, Vec<f64>), f64)]| match stretch {
        [first, .., last] => (last.1 - first.1) * way,
        _ => 0.0,
    };
    let arc = stretches.max_by(|a, b| gone(a).total_cmp(&gone(b))).expect("a stretch");
    let off = arc.iter().map(|(row, _)| (bar(&row.1).norm() - session_bar(&row.1)).abs()).fold(0.0, f64::max);
    let feed = test.feed_mm_per_min.expect("planned") / 60.0;
    // where the bar keeps its direction the feed is that of the linear axes
    let [seen, slides] = ways(machine, &bar, own.row(0), own.row(1));
    let is_bar_turning = seen > 1e-3 * slides;
    let mut pace = [f64::MAX, f64::MIN];
    for pair in arc.windows(WINDOW + 1) {
        let (from, to) = (pair[0].0, pair[WINDOW].0);
        let [seen, slides] = ways(machine, &bar, &from.1, &to.1);
        let way = if is_bar_turning { seen } else { slides };
        let speed = way / (to.0 - from.0) / feed;
        pace = [pace[0].min(speed), pace[1].max(speed)];
    }
    (pace, off, gone(arc) / (to - from).abs())
}

/// What is wrong with a planned test on the control, direction by direction.
fn faults(run: &Path, machine: &Machine, planned: &PlannedTest) -> Vec<String> {
    let trace = traced(run, machine, &program(machine, planned, &[], Dialect::LinuxCnc));
    let mut faults = Vec::new();
    for test in planned.both_ways() {
        let (pace, off, seen) = judged(machine, &test, &trace);
        let said = format!(
            "{} {}: {} mm/min kept to {:.3} … {:.3}, bar within {:.3} um of the session's, {:.1} % of the arc seen",
            machine.name,
            test.name,
            test.feed_mm_per_min.expect("planned"),
            pace[0],
            pace[1],
            off * 1e3,
            seen * 100.0
        );
        println!("{said}");
        // a control that stood by itself shows nothing of the arc
        if !(seen > 0.98 && pace[0] > PACE[0] && pace[1] < PACE[1] && off < BAR_MM) {
            faults.push(said);
        }
    }
    faults
}

fn planned(name: &str, feed: f64, circles: bool) -> (Machine, Vec<PlannedTest>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
    let mut settings = Settings { feed_mm_per_min: feed, ..Settings::default() };
    settings.coupled.circles = circles;
    let plan = plan(&machine, &bodies, &standard_kit().expect("kit"), &settings).expect("plan");
    (machine, plan.tests)
}

#[test]
fn a_real_planner_keeps_feed_and_bar() {
    let Some(run) = control() else { return };
    if let Ok(names) = std::env::var("FIVEAXIS_CONTROL_LOOP") {
        let feed = std::env::var("FIVEAXIS_CONTROL_FEED").map_or(500.0, |feed| feed.parse().expect("mm/min"));
        let circles = std::env::var("FIVEAXIS_CONTROL_CIRCLES").map_or(true, |wanted| wanted != "no");
        let mut faults = Vec::new();
        for name in names.split(',') {
            let (machine, tests) = planned(name, feed, circles);
            faults.extend(tests.iter().flat_map(|planned| self::faults(&run, &machine, planned)));
        }
        assert!(faults.is_empty(), "{faults:#?}");
        return;
    }
    // one program of arcs that carry the table along, and the control winds them beyond a full turn: it takes real time
    let (machine, tests) = planned("nutating-table-45.yaml", 1500.0, false);
    let following = tests.iter().filter(|planned| planned.is_coupled());
    let shortest = following.min_by(|a, b| a.minutes.total_cmp(&b.minutes)).expect("a following run");
    let faults = faults(&run, &machine, shortest);
    assert!(faults.is_empty(), "{faults:#?}");
}
