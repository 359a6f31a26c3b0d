//! Programs read by LinuxCNC's own interpreter: its canonical moves are the planned ones. Skipped, and said so, where `rs274` is not there.
//!
//! `FIVEAXIS_RS274` names the program; else it is looked for on the PATH.

mod planned;
mod skipped;

use std::path::{Path, PathBuf};
use std::process::Command;

use fiveaxis::chain::{Chain, Geometry};
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::nc::{Dialect, program};
use fiveaxis::plan::{PlannedTest, rows_with_run_in};
use fiveaxis::session::{Motion, Path as TestPath, Session, Spread, way_mm};
use planned::planned;

/// What the interpreter tells the machine to do; positions X Y Z A B C in machine coordinates, mm and deg.
#[derive(Debug, Clone, PartialEq)]
enum Canonical {
    Traverse([f64; 6]),
    Feed([f64; 6], f64),
    /// End, centre in the plane's two axes (index of X Y Z), those axes, 1 for counter-clockwise, feed.
    Arc([f64; 6], [f64; 2], [usize; 2], f64, f64),
    Dwell(f64),
    Stop,
    End,
}

/// The interpreter prints four decimals, programs have five.
const ROUNDING: f64 = 0.6e-4;

fn interpreter() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("FIVEAXIS_RS274") {
        return Some(PathBuf::from(named));
    }
    let path = std::env::var_os("PATH")?;
    let found = std::env::split_paths(&path).map(|folder| folder.join("rs274")).find(|file| file.is_file());
    if found.is_none() {
        skipped::skipped("LinuxCNC's rs274 is neither named by FIVEAXIS_RS274 nor on the PATH");
    }
    found
}

/// Runs a program; `offsets` is the work offset G54, X Y Z A B C.
fn interpret(rs274: &Path, text: &str, offsets: [f64; 6]) -> Result<Vec<Canonical>, String> {
    canonical(&listing(rs274, text, offsets)?)
}

/// The interpreter's own list of what it does.
fn listing(rs274: &Path, text: &str, offsets: [f64; 6]) -> Result<String, String> {
    let folder = tempfile::tempdir().expect("folder");
    let file = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).expect("written");
        file
    };
    let parameters: String =
        offsets.iter().enumerate().map(|(k, offset)| format!("{}\t{offset:.6}\n", 5221 + k)).collect();
    let output = Command::new(rs274)
        .current_dir(folder.path())
        // it keeps its tool table in a file of the home folder
        .env("HOME", folder.path())
        .args(["-g", "-t"])
        .arg(file("tool.tbl", ""))
        .arg("-v")
        .arg(file("rs274.var", &parameters))
        .arg(file("program.ngc", text))
        .stdin(std::process::Stdio::null())
        .output()
        .map_err(|why| format!("{} does not run: {why}", rs274.display()))?;
    let listing = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        return Err(format!("{}\n{}", listing, String::from_utf8_lossy(&output.stderr)));
    }
    Ok(listing.into_owned())
}

fn canonical(listing: &str) -> Result<Vec<Canonical>, String> {
    let mut moves = Vec::new();
    let (mut offset, mut feed) = ([0.0; 6], 0.0);
    let mut millimetres = false;
    let mut plane = [0, 1];
    for line in listing.lines() {
        let Some((_, call)) = line.split_once("N..... ") else { continue };
        let Some((name, rest)) = call.split_once('(') else { continue };
        let words: Vec<&str> = rest.trim_end_matches(')').split(',').map(str::trim).collect();
        let number =
            |k: usize| words.get(k).and_then(|word| word.parse::<f64>().ok()).ok_or(format!("not read: {line}"));
        let six = |first: usize| -> Result<[f64; 6], String> {
            let mut values = [0.0; 6];
            for (k, value) in values.iter_mut().enumerate() {
                *value = number(first + k)?;
            }
            Ok(values)
        };
        let in_machine = |place: [f64; 6], offset: [f64; 6]| std::array::from_fn(|k| place[k] + offset[k]);
        match name {
            "USE_LENGTH_UNITS" => millimetres = words[0] == "CANON_UNITS_MM",
            "SET_G5X_OFFSET" => offset = six(1)?,
            "SET_G92_OFFSET" if six(0)? != [0.0; 6] => return Err(line.into()),
            "SET_FEED_RATE" => feed = number(0)?,
            "STRAIGHT_TRAVERSE" => moves.push(Canonical::Traverse(in_machine(six(0)?, offset))),
            "STRAIGHT_FEED" => moves.push(Canonical::Feed(in_machine(six(0)?, offset), feed)),
            "DWELL" => moves.push(Canonical::Dwell(number(0)?)),
            "PROGRAM_STOP" => moves.push(Canonical::Stop),
            "PROGRAM_END" => moves.push(Canonical::End),
            "USE_TOOL_LENGTH_OFFSET"
                if rest.trim_end_matches(')').split([' ', ',']).any(|w| w.parse() != Ok(0.0) && !w.is_empty()) =>
            {
                return Err(format!("a tool length stays: {line}"));
            }
            "SELECT_PLANE" => {
                plane = match words[0] {
                    "CANON_PLANE_XY" => [0, 1],
                    "CANON_PLANE_YZ" => [1, 2],
                    "CANON_PLANE_XZ" => [2, 0],
                    other => return Err(format!("plane {other}")),
                }
            }
            "ARC_FEED" => {
                let mut end = [0.0; 6];
                end[plane[0]] = number(0)?;
                end[plane[1]] = number(1)?;
                end[3 - plane[0] - plane[1]] = number(5)?;
                (3..6).try_for_each(|k| number(3 + k).map(|value| end[k] = value))?;
                let centre = [number(2)? + offset[plane[0]], number(3)? + offset[plane[1]]];
                moves.push(Canonical::Arc(in_machine(end, offset), centre, plane, number(4)?, feed));
            }
            _ => {}
        }
    }
    if millimetres { Ok(moves) } else { Err("the program is not read in millimetres".into()) }
}

/// The moves that the plan means, from its places, arc and feed at the ball; `blocks` in one direction where several axes
/// move, run-in and run-out apart.
fn planned_moves(machine: &Machine, planned: &PlannedTest, start: [f64; 6], blocks: usize) -> Vec<Canonical> {
    let letter = |k: usize| "XYZABC".find(machine.axes[k].name.as_str()).expect("one of the six axes");
    let shown = |k: usize, q: f64| match machine.axes[k].kind {
        AxisKind::Linear => q + machine.machine_zero[k].unwrap_or(0.0),
        AxisKind::Rotary => q.to_degrees() + machine.machine_zero[k].unwrap_or(0.0),
    };
    let mut here = start;
    let mut moves = vec![Canonical::Stop];
    for &k in &planned.approach.park_order {
        here[letter(k)] = shown(k, planned.approach.park[k]);
        moves.push(Canonical::Traverse(here));
    }
    let corners: Vec<[f64; 6]> = planned
        .approach
        .corners()
        .iter()
        .map(|corner| {
            let mut place = here;
            corner.iter().enumerate().for_each(|(k, &q)| place[letter(k)] = shown(k, q));
            place
        })
        .collect();
    moves.extend(corners[1..].iter().map(|corner| Canonical::Traverse(*corner)));
    moves.push(Canonical::Stop);
    if planned.is_coupled() {
        let row = |q: &[f64]| {
            let mut place = here;
            q.iter().enumerate().for_each(|(k, &q)| place[letter(k)] = shown(k, q));
            place
        };
        moves.extend(coupled_moves(machine, planned, &row, blocks));
    } else {
        moves.extend(swept_moves(machine, planned, here, &letter, &shown));
    }
    moves.push(Canonical::Stop);
    moves.extend(corners.iter().rev().skip(1).map(|corner| Canonical::Traverse(*corner)));
    moves.push(Canonical::End);
    moves
}

/// Moves of a run in which one axis turns.
fn swept_moves(
    machine: &Machine,
    planned: &PlannedTest,
    mut here: [f64; 6],
    letter: &dyn Fn(usize) -> usize,
    shown: &dyn Fn(usize, f64) -> f64,
) -> Vec<Canonical> {
    let mut moves = Vec::new();
    // all axes stand at the test's positions, one turns
    for (k, q) in planned.test.positions.iter().enumerate() {
        if let Some(q) = q {
            here[letter(k)] = shown(k, *q);
        }
    }
    let range = machine.axes[planned.axis].range;
    let run_in = planned.test.overshoot.expect("planned");
    let feed_deg = planned.test.feed_mm_per_min.expect("planned") / planned.rho_mm * 180.0 / std::f64::consts::PI;
    let (from, to) = (planned.sweep.from_deg, planned.sweep.to_deg);
    let mut turn = |deg: f64, feed: f64| {
        let q = range.map_or(deg.to_radians(), |(low, high)| deg.to_radians().clamp(low, high));
        here[letter(planned.axis)] = shown(planned.axis, q);
        Canonical::Feed(here, feed)
    };
    for (first, second) in [(from, to), (to, from)] {
        let outward = run_in * (second - first).signum();
        moves.push(turn(first - outward, 2.0 * feed_deg));
        moves.push(Canonical::Dwell(3.0));
        moves.push(turn(first, feed_deg));
        moves.push(turn(second, feed_deg));
        moves.push(turn(second + outward, feed_deg));
        moves.push(Canonical::Dwell(3.0));
    }
    moves
}

/// Moves of a run in which several axes move, from the session's own motion: straight blocks, or arcs.
fn coupled_moves(
    machine: &Machine,
    planned: &PlannedTest,
    place: &dyn Fn(&[f64]) -> [f64; 6],
    blocks: usize,
) -> Vec<Canonical> {
    let mut moves = Vec::new();
    let chain = Chain::of(machine);
    let session = Session {
        name: String::new(),
        machine_file: String::new(),
        machine: machine.clone(),
        spread: Spread::default(),
        tests: Vec::new(),
    };
    for test in planned.both_ways() {
        let motion = Motion::of(&session, &chain, &test).expect("motion");
        let run = rows_with_run_in(machine, &test, &motion);
        let feed = test.feed_mm_per_min.expect("planned");
        let mut fine = test.clone();
        let circle = match fine.path.as_mut().expect("planned") {
            TestPath::Sweep { from, to, step, .. } => {
                *step = (*to - *from).abs() / blocks as f64;
                None
            }
            TestPath::Circle { plane, from, to, step, .. } => {
                *step = (*to - *from).abs() / blocks as f64;
                Some((plane.clone(), (*to - *from).signum()))
            }
        };
        let fine = Motion::of(&session, &chain, &fine).expect("motion");
        assert_eq!(fine.rows(), blocks + 1);
        let time = fine.time_s.as_ref().expect("planned motions have times");
        // LinuxCNC counts the way of X, Y and Z alone
        let way = |a: &[f64; 6], b: &[f64; 6]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
        moves.push(Canonical::Dwell(3.0));
        let mut last = place(fine.row(0));
        // the run-in at the feed as the session's motion counts it
        let geometry = Geometry::nominal(&chain);
        let (pivot, spindle) = test.links(&chain).expect("links");
        let straight = |from: &[f64], to: &[f64]| {
            let balls = way_mm(&geometry, &test, (pivot, spindle), from, to);
            let of_ball = if circle.is_some() { 1.0 } else { way(&place(from), &place(to)) / balls };
            Canonical::Feed(place(to), feed * of_ball)
        };
        moves.push(straight(&run[0], &run[1]));
        for k in 1..=blocks {
            let next = place(fine.row(k));
            match &circle {
                None => {
                    moves.push(Canonical::Feed(next, way(&last, &next) / (time[k] - time[k - 1]) * 60.0));
                }
                Some((plane, turn)) => {
                    // the middle of the whole circle
                    let letters =
                        [plane.first, plane.second].map(|axis| "XYZ".find(&machine.axes[axis].name).expect("XYZ"));
                    let zero = machine.machine_zero.iter().map(|zero| zero.unwrap_or(0.0)).collect::<Vec<f64>>();
                    let start = motion.row(0);
                    let TestPath::Circle { radius_mm, from, .. } = test.path.as_ref().expect("planned") else {
                        panic!()
                    };
                    let (sin, cos) = from.to_radians().sin_cos();
                    let centre = [
                        start[plane.first] - radius_mm * cos + zero[plane.first],
                        start[plane.second] - radius_mm * sin + zero[plane.second],
                    ];
                    moves.push(Canonical::Arc(next, centre, letters, *turn, feed));
                }
            }
            last = next;
        }
        moves.push(straight(&run[run.len() - 2], &run[run.len() - 1]));
        moves.push(Canonical::Dwell(3.0));
    }
    moves
}

/// Blocks in one direction of a run of several axes, run-in and run-out apart.
fn blocks(found: &[Canonical]) -> usize {
    let runs = found.iter().filter(|m| matches!(m, Canonical::Feed(..) | Canonical::Arc(..))).count();
    (runs / 2).saturating_sub(2)
}

/// A feed is the planned one rounded down to 0.001; the interpreter prints four decimals.
fn rounded_down(found: f64, planned: f64) -> bool {
    found <= planned + 1e-6 && found > planned - 1e-3 - 1e-6
}

/// The first move that differs.
fn difference(found: &[Canonical], wanted: &[Canonical]) -> Option<String> {
    let near = |a: &f64, b: &f64| (a - b).abs() <= ROUNDING;
    let same = |a: &Canonical, b: &Canonical| match (a, b) {
        (Canonical::Traverse(a), Canonical::Traverse(b)) => a.iter().zip(b).all(|(a, b)| near(a, b)),
        // feeds are written to 0.001 deg/min, rounded down
        (Canonical::Feed(a, f), Canonical::Feed(b, g)) => {
            // and those of blocks by their time to 0.001 a minute, ways to 1e-5 mm of some 0.2 mm
            let runs = wanted.iter().filter(|m| matches!(m, Canonical::Feed(..) | Canonical::Arc(..))).count();
            let coupled = runs != 8 || wanted.iter().any(|m| matches!(m, Canonical::Arc(..)));
            let is_feed = if coupled { (f - g).abs() < 5e-4 * g } else { rounded_down(*f, *g) };
            a.iter().zip(b).all(|(a, b)| near(a, b)) && is_feed
        }
        (Canonical::Arc(a, c, p, r, f), Canonical::Arc(b, d, q, t, g)) => {
            a.iter().zip(b).all(|(a, b)| near(a, b))
                && c.iter().zip(d).all(|(c, d)| near(c, d))
                && (p, r) == (q, t)
                && rounded_down(*f, *g)
        }
        _ => a == b,
    };
    if let Some(k) = (0..found.len().min(wanted.len())).find(|&k| !same(&found[k], &wanted[k])) {
        return Some(format!("move {k}: {:?} in place of {:?}", found[k], wanted[k]));
    }
    (found.len() != wanted.len()).then(|| format!("{} moves in place of {}", found.len(), wanted.len()))
}

#[test]
fn canonical_moves_are_the_planned_ones() {
    let Some(rs274) = interpreter() else { return };
    let (mut programs, mut following, mut arcs) = (0, 0, 0);
    for name in
        ["hermle-c600u.yaml", "fig-1-1-table-head-ca.yaml", "head-head-ab-profiler.yaml", "nutating-table-45.yaml"]
    {
        let (machine, tests) = planned(name);
        assert_eq!(Dialect::LinuxCnc.unknown_axis(&machine), None);
        for planned in &tests {
            let text = program(&machine, planned, Dialect::LinuxCnc);
            let found = interpret(&rs274, &text, [0.0; 6]).unwrap_or_else(|why| panic!("{name}: {why}\n{text}"));
            let wanted = planned_moves(&machine, planned, [0.0; 6], blocks(&found));
            assert_eq!(difference(&found, &wanted), None, "{name} {}\n{text}", planned.test.name);
            programs += 1;
            match planned.test.path {
                Some(TestPath::Circle { .. }) => arcs += 1,
                _ => following += usize::from(planned.is_coupled()),
            }
        }
    }
    println!("{programs} programs read by {}", rs274.display());
    println!("{following} with linear axes following, {arcs} circles");
    assert!(programs >= 12 && following >= 3 && arcs == 3);
}

#[test]
fn machine_coordinates_hold_whatever_the_work_offset() {
    let Some(rs274) = interpreter() else { return };
    let (mut machine, tests) = planned("hermle-c600u.yaml");
    machine.machine_zero = vec![Some(12.5), Some(-3.25), Some(-410.0), Some(-220.5), Some(-96.125)];
    for planned in &tests {
        let text = program(&machine, planned, Dialect::LinuxCnc);
        for offsets in [[0.0; 6], [7.5, -20.0, 133.25, 5.0, 0.0, -30.0]] {
            let found = interpret(&rs274, &text, offsets).unwrap_or_else(|why| panic!("{why}\n{text}"));
            // the interpreter starts at machine zero, whatever the offset
            let wanted = planned_moves(&machine, planned, [0.0; 6], blocks(&found));
            assert_eq!(difference(&found, &wanted), None, "{}\n{text}", planned.test.name);
        }
    }
}

#[test]
fn the_path_mode_and_all_others_come_back_but_spindle_and_coolant_stay_off() {
    let Some(rs274) = interpreter() else { return };
    let (machine, tests) = planned("hermle-c600u.yaml");
    let modes = |listing: &str, what: &str| -> Vec<String> {
        listing
            .lines()
            .filter_map(|line| line.split_once("N..... "))
            .filter(|(_, call)| call.contains(what))
            .map(|(_, call)| call.to_string())
            .collect()
    };
    for planned in &tests {
        let text = program(&machine, planned, Dialect::LinuxCnc);
        let listing = listing(&rs274, &format!("G61 G18 G20 G91 G95 M3 S100 M8\n{text}"), [0.0; 6]).expect("read");
        // the end of the program itself sets plane, distance and feed mode to the control's own
        let end = listing.rfind("STRAIGHT_TRAVERSE").expect("the way back");
        let (run, after) = (&listing[..end], &listing[end..]);
        assert!(
            modes(run, "SET_MOTION_CONTROL_MODE").last().is_some_and(|mode| mode.contains("CANON_CONTINUOUS, 0.001"))
        );
        assert_eq!(modes(after, "SET_MOTION_CONTROL_MODE"), ["SET_MOTION_CONTROL_MODE(CANON_EXACT_PATH)"]);
        assert_eq!(modes(after, "USE_LENGTH_UNITS"), ["USE_LENGTH_UNITS(CANON_UNITS_INCHES)"]);
        assert_eq!(modes(after, "SELECT_PLANE")[0], "SELECT_PLANE(CANON_PLANE_XZ)");
        assert!(
            after.contains("distance mode changed to incremental") && after.contains("units per revolution"),
            "{after}"
        );
        let started = listing.find("STOP_SPINDLE").expect("M5");
        assert!(!listing[started..].contains("START_SPINDLE") && !listing[started..].contains("FLOOD_ON"), "{listing}");
    }
}

#[test]
fn the_comparison_sees_a_wrong_angle_feed_and_missing_move() {
    let Some(rs274) = interpreter() else { return };
    let (machine, tests) = planned("hermle-c600u.yaml");
    let planned = tests.iter().find(|test| !test.is_coupled()).expect("a sweep of one axis");
    let text = program(&machine, planned, Dialect::LinuxCnc);
    let wanted = planned_moves(&machine, planned, [0.0; 6], 0);
    let lines: Vec<&str> = text.lines().collect();
    let turn = lines.iter().position(|line| line.starts_with("G1 ")).expect("a feed move");
    let with = |line: String| {
        let mut changed: Vec<&str> = lines.clone();
        changed[turn] = &line;
        changed.join("\n") + "\n"
    };
    let (place, feed) = lines[turn].split_once(" F").expect("feed");
    let feed: f64 = feed.parse().expect("number");
    for changed in [
        with(format!("{} F{feed}", place.replace(".00000", ".00100"))),
        with(format!("{place} F{}", feed + 0.01)),
        with(String::new()),
    ] {
        let found = interpret(&rs274, &changed, [0.0; 6]).expect("readable");
        assert!(difference(&found, &wanted).is_some());
    }
    assert!(interpret(&rs274, &with("G1 Q5".into()), [0.0; 6]).is_err());
}

#[test]
fn blocks_of_a_following_run_keep_the_bar_and_the_speed_of_the_ball() {
    let Some(rs274) = interpreter() else { return };
    let (machine, tests) = planned("hermle-c600u.yaml");
    let chain = Chain::of(&machine);
    let geometry = Geometry::nominal(&chain);
    let coupled =
        tests.iter().filter(|test| matches!(test.test.path, Some(TestPath::Sweep { .. })) && test.is_coupled());
    let mut checked = 0;
    for planned in coupled {
        let text = program(&machine, planned, Dialect::LinuxCnc);
        let found = interpret(&rs274, &text, [0.0; 6]).expect("read");
        let (pivot, spindle) = planned.test.links(&chain).expect("links");
        let balls = |place: &[f64; 6], other: &[f64; 6], part: f64| {
            let q: Vec<f64> = machine
                .axes
                .iter()
                .map(|axis| {
                    let k = "XYZABC".find(axis.name.as_str()).expect("letter");
                    axis.kind.from_file_unit(place[k] + (other[k] - place[k]) * part)
                })
                .collect();
            let p = geometry.point(pivot, &planned.test.pivot.at, &q, None);
            (p, geometry.point(spindle, &planned.test.spindle_ball.at, &q, None))
        };
        let feeds: Vec<&[f64; 6]> = found
            .iter()
            .filter_map(|step| if let Canonical::Feed(place, _) = step { Some(place) } else { None })
            .collect();
        let bar = planned.test.bar_length_mm.expect("bar");
        // run-in, arc, run-out, twice: between neighbours on an arc the bar stays as long as it is
        let arc = &feeds[..feeds.len() / 2 - 1];
        let worst = arc
            .windows(2)
            .flat_map(|pair| [0.25, 0.5, 1.0].map(|part| balls(pair[0], pair[1], part)))
            .map(|(p, s)| ((p - s).norm() - bar).abs())
            .fold(0.0, f64::max);
        println!("{}: {} blocks, bar within {:.2} um", planned.test.name, arc.len() - 1, worst * 1e3);
        // a chord of 0.1 um and the interpreter's four decimals on three axes
        assert!(worst < 0.1e-3 + 3.0 * ROUNDING, "{}: {worst}", planned.test.name);
        checked += 1;
    }
    assert!(checked > 0);
}
