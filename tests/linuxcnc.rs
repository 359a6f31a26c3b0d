//! Programs read by LinuxCNC's own interpreter: its canonical moves are the planned ones. Skipped, and said so, where `rs274` is not there.
//!
//! `FIVEAXIS_RS274` names the program; else it is looked for on the PATH.

use crate::planned;
use crate::skipped;
use std::path::{Path, PathBuf};
use std::process::Command;

use fiveaxis::chain::{Chain, Geometry};
use fiveaxis::machine::Machine;
use fiveaxis::nc::{Coordinates, Curves, Dialect, Step, program, steps};
use fiveaxis::plan::PlannedTest;
use fiveaxis::session::Path as TestPath;
use planned::planned;

/// What the interpreter tells the machine to do; positions X Y Z A B C in machine coordinates, mm and deg.
#[derive(Debug, Clone, PartialEq)]
enum Canonical {
    Traverse([f64; 6]),
    Feed([f64; 6], f64),
    /// A feed whose time is planned: its speed is that of the way of X, Y and Z in that time.
    Timed([f64; 6], f64),
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

/// The moves that the steps of a plan mean. That the steps are the plan is compared in the tests of all programs.
fn planned_moves(machine: &Machine, planned: &PlannedTest, start: [f64; 6]) -> Vec<Canonical> {
    let letter = |name: &str| "XYZABC".find(name).expect("one of the six axes");
    let mut here = start;
    let mut moves = Vec::new();
    for step in steps(machine, planned, &Coordinates::of(machine), Curves::Winding) {
        let from = here;
        // LinuxCNC counts the way of X, Y and Z alone
        let way = |a: &[f64; 6], b: &[f64; 6]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
        moves.push(match step {
            Step::Say(_) => continue,
            Step::Stop(_) => Canonical::Stop,
            Step::Dwell(seconds) => Canonical::Dwell(seconds),
            Step::Rapid { axis, to } => {
                here[letter(&axis)] = to;
                Canonical::Traverse(here)
            }
            Step::Feed { axis, to, per_minute } => {
                here[letter(&axis)] = to;
                Canonical::Feed(here, per_minute)
            }
            Step::Move { to, minutes } => {
                to.iter().for_each(|(axis, to)| here[letter(axis)] = *to);
                Canonical::Timed(here, way(&from, &here) / minutes)
            }
            Step::Arc { axes, centre, end, counter_clockwise, turns, turn, feed_mm_per_min } => {
                let plane = axes.each_ref().map(|axis| letter(axis));
                let centre = [from[plane[0]] + centre[0], from[plane[1]] + centre[1]];
                plane.iter().zip(end).for_each(|(k, end)| here[*k] += end);
                turn.iter().for_each(|(axis, by)| here[letter(axis)] += by);
                let turned = f64::from(1 + turns) * if counter_clockwise { 1.0 } else { -1.0 };
                Canonical::Arc(here, centre, plane, turned, feed_mm_per_min)
            }
        });
    }
    moves.push(Canonical::End);
    moves
}

/// A feed is the planned one rounded down to 0.001; the interpreter prints four decimals.
fn rounded_down(found: f64, planned: f64) -> bool {
    found <= planned + 1e-6 && found > planned - 1e-3 - 1e-6
}

/// The first move that differs.
fn difference(found: &[Canonical], wanted: &[Canonical]) -> Option<String> {
    // relative arcs add their roundings
    let near = |a: &f64, b: &f64| (a - b).abs() <= 2.0 * ROUNDING;
    let same = |a: &Canonical, b: &Canonical| match (a, b) {
        (Canonical::Traverse(a), Canonical::Traverse(b)) => a.iter().zip(b).all(|(a, b)| near(a, b)),
        // feeds are written to 0.001 deg/min, rounded down
        (Canonical::Feed(a, f), Canonical::Feed(b, g)) => {
            a.iter().zip(b).all(|(a, b)| near(a, b)) && rounded_down(*f, *g)
        }
        // and those of blocks by their time to 0.001 a minute, ways to 1e-5 mm of some 0.2 mm
        (Canonical::Feed(a, f), Canonical::Timed(b, g)) => {
            a.iter().zip(b).all(|(a, b)| near(a, b)) && (f - g).abs() < 5e-4 * g
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
    let (mut programs, mut following, mut circles) = (0, 0, 0);
    for name in
        ["hermle-c600u.yaml", "fig-1-1-table-head-ca.yaml", "head-head-ab-profiler.yaml", "nutating-table-45.yaml"]
    {
        let (machine, tests) = planned(name);
        assert_eq!(Dialect::LinuxCnc.unknown_axis(&machine), None);
        for planned in &tests {
            let text = program(&machine, planned, &[], Dialect::LinuxCnc);
            let found = interpret(&rs274, &text, [0.0; 6]).unwrap_or_else(|why| panic!("{name}: {why}\n{text}"));
            let wanted = planned_moves(&machine, planned, [0.0; 6]);
            assert_eq!(difference(&found, &wanted), None, "{name} {}\n{text}", planned.test.name);
            programs += 1;
            match planned.test.path {
                Some(TestPath::Circle { .. }) => circles += 1,
                _ => following += usize::from(planned.is_coupled()),
            }
        }
    }
    println!("{programs} programs read by {}", rs274.display());
    println!("{following} with linear axes following, {circles} circles");
    assert!(programs >= 12 && following >= 3 && circles == 3);
}

#[test]
fn machine_coordinates_hold_whatever_the_work_offset() {
    let Some(rs274) = interpreter() else { return };
    let (mut machine, tests) = planned("hermle-c600u.yaml");
    machine.machine_zero = vec![Some(12.5), Some(-3.25), Some(-410.0), Some(-220.5), Some(-96.125)];
    for planned in &tests {
        let text = program(&machine, planned, &[], Dialect::LinuxCnc);
        for offsets in [[0.0; 6], [7.5, -20.0, 133.25, 5.0, 0.0, -30.0]] {
            let found = interpret(&rs274, &text, offsets).unwrap_or_else(|why| panic!("{why}\n{text}"));
            // the interpreter starts at machine zero, whatever the offset
            let wanted = planned_moves(&machine, planned, [0.0; 6]);
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
        let text = program(&machine, planned, &[], Dialect::LinuxCnc);
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
    let text = program(&machine, planned, &[], Dialect::LinuxCnc);
    let wanted = planned_moves(&machine, planned, [0.0; 6]);
    let lines: Vec<&str> = text.lines().collect();
    // rest, mark with its hold, rest, run
    let rests = lines.iter().enumerate().filter(|(_, line)| line.starts_with("G4 "));
    let (run, _) = rests.clone().nth(if planned.test.marks.is_some() { 2 } else { 0 }).expect("a rest");
    let turn = (run + 1..lines.len()).find(|&k| lines[k].contains(" F")).expect("a feed");
    let with = |line: String| {
        let mut changed: Vec<&str> = lines.clone();
        changed[turn] = &line;
        changed.join("\n") + "\n"
    };
    let (place, feed) = lines[turn].split_once(" F").expect("feed");
    let feed: f64 = feed.parse().expect("number");
    let number = place.rfind(|c: char| c.is_ascii_alphabetic()).expect("axis") + 1;
    let angle: f64 = place[number..].parse().expect("angle");
    for changed in [
        with(format!("{}{} F{feed}", &place[..number], angle + 0.001)),
        with(format!("{place} F{}", feed + 0.01)),
        with(String::new()),
    ] {
        let found = interpret(&rs274, &changed, [0.0; 6]).expect("readable");
        assert!(difference(&found, &wanted).is_some());
    }
    assert!(interpret(&rs274, &with("G1 Q5".into()), [0.0; 6]).is_err());
}

#[test]
fn blocks_of_a_following_run_keep_the_bar() {
    let Some(rs274) = interpreter() else { return };
    // a circle across all coordinate planes, which no arc draws
    let (machine, tests) = planned("nutating-head-45.yaml");
    let chain = Chain::of(&machine);
    let geometry = Geometry::nominal(&chain);
    let coupled =
        tests.iter().filter(|test| matches!(test.test.path, Some(TestPath::Sweep { .. })) && test.is_coupled());
    let mut checked = 0;
    for planned in coupled {
        let text = program(&machine, planned, &[], Dialect::LinuxCnc);
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
        let bar = planned.test.bar_length_mm.expect("bar");
        let captures: Vec<&[Canonical]> = found.split(|step| matches!(step, Canonical::Dwell(_))).collect();
        let arc: Vec<&[f64; 6]> = captures[1]
            .iter()
            .map(|step| if let Canonical::Feed(place, _) = step { place } else { panic!("{step:?}") })
            .collect();
        // run-in and run-out are on the same curve
        let worst = arc
            .windows(2)
            .flat_map(|pair| [0.25, 0.5, 1.0].map(|part| balls(pair[0], pair[1], part)))
            .map(|(p, s)| ((p - s).norm() - bar).abs())
            .fold(0.0, f64::max);
        println!("{}: {} blocks, bar within {:.2} um", planned.test.name, arc.len() - 1, worst * 1e3);
        // a chord of 0.25 um and the interpreter's four decimals on three axes
        assert!(worst < 0.25e-3 + 3.0 * ROUNDING, "{}: {worst}", planned.test.name);
        checked += 1;
    }
    assert!(checked > 0);
}
