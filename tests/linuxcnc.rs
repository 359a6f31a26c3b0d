//! Programs read by LinuxCNC's own interpreter: its canonical moves are the planned ones. Skipped, and said so, where `rs274` is not there.
//!
//! `FIVEAXIS_RS274` names the program; else it is looked for on the PATH.

use std::path::{Path, PathBuf};
use std::process::Command;

use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::nc::{Dialect, program};
use fiveaxis::plan::{PlannedTest, Settings, plan};

/// What the interpreter tells the machine to do; positions X Y Z A B C in machine coordinates, mm and deg.
#[derive(Debug, Clone, PartialEq)]
enum Canonical {
    Traverse([f64; 6]),
    Feed([f64; 6], f64),
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
        println!("SKIPPED: LinuxCNC's rs274 is neither named by FIVEAXIS_RS274 nor on the PATH");
    }
    found
}

/// Runs a program; `offsets` is the work offset G54, X Y Z A B C.
fn interpret(rs274: &Path, text: &str, offsets: [f64; 6]) -> Result<Vec<Canonical>, String> {
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
    canonical(&listing)
}

fn canonical(listing: &str) -> Result<Vec<Canonical>, String> {
    let mut moves = Vec::new();
    let (mut offset, mut feed) = ([0.0; 6], 0.0);
    let mut millimetres = false;
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
            "ARC_FEED" => return Err(format!("no arc is planned: {line}")),
            _ => {}
        }
    }
    if millimetres { Ok(moves) } else { Err("the program is not read in millimetres".into()) }
}

/// The moves that the plan means, from its places, arc and feed at the ball.
fn planned_moves(machine: &Machine, planned: &PlannedTest, start: [f64; 6]) -> Vec<Canonical> {
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
    // the run: all axes stand at the test's positions, one turns
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
    moves.push(Canonical::Stop);
    moves.extend(corners.iter().rev().skip(1).map(|corner| Canonical::Traverse(*corner)));
    moves.push(Canonical::End);
    moves
}

/// The first move that differs.
fn difference(found: &[Canonical], wanted: &[Canonical]) -> Option<String> {
    let near = |a: &f64, b: &f64| (a - b).abs() <= ROUNDING;
    let same = |a: &Canonical, b: &Canonical| match (a, b) {
        (Canonical::Traverse(a), Canonical::Traverse(b)) => a.iter().zip(b).all(|(a, b)| near(a, b)),
        // feeds are written to 0.001 deg/min
        (Canonical::Feed(a, f), Canonical::Feed(b, g)) => {
            a.iter().zip(b).all(|(a, b)| near(a, b)) && (f - g).abs() < 0.6e-3
        }
        _ => a == b,
    };
    if let Some(k) = (0..found.len().min(wanted.len())).find(|&k| !same(&found[k], &wanted[k])) {
        return Some(format!("move {k}: {:?} in place of {:?}", found[k], wanted[k]));
    }
    (found.len() != wanted.len()).then(|| format!("{} moves in place of {}", found.len(), wanted.len()))
}

fn load(name: &str) -> (Machine, Vec<PlannedTest>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
    let plan = plan(&machine, &bodies, &standard_kit().expect("kit"), &Settings::default()).expect("plan");
    (machine, plan.tests)
}

#[test]
fn canonical_moves_are_the_planned_ones() {
    let Some(rs274) = interpreter() else { return };
    let mut programs = 0;
    for name in
        ["hermle-c600u.yaml", "fig-1-1-table-head-ca.yaml", "head-head-ab-profiler.yaml", "nutating-table-45.yaml"]
    {
        let (machine, tests) = load(name);
        assert_eq!(Dialect::LinuxCnc.unknown_axis(&machine), None);
        for planned in &tests {
            let text = program(&machine, planned, Dialect::LinuxCnc);
            let found = interpret(&rs274, &text, [0.0; 6]).unwrap_or_else(|why| panic!("{name}: {why}\n{text}"));
            let wanted = planned_moves(&machine, planned, [0.0; 6]);
            assert_eq!(difference(&found, &wanted), None, "{name} {}\n{text}", planned.test.name);
            programs += 1;
        }
    }
    println!("{programs} programs read by {}", rs274.display());
    assert!(programs >= 12);
}

#[test]
fn machine_coordinates_hold_whatever_the_work_offset() {
    let Some(rs274) = interpreter() else { return };
    let (mut machine, tests) = load("hermle-c600u.yaml");
    machine.machine_zero = vec![Some(12.5), Some(-3.25), Some(-410.0), Some(-220.5), Some(-96.125)];
    for planned in &tests {
        let text = program(&machine, planned, Dialect::LinuxCnc);
        for offsets in [[0.0; 6], [7.5, -20.0, 133.25, 5.0, 0.0, -30.0]] {
            let found = interpret(&rs274, &text, offsets).unwrap_or_else(|why| panic!("{why}\n{text}"));
            // the interpreter starts at machine zero, whatever the offset
            let wanted = planned_moves(&machine, planned, [0.0; 6]);
            assert_eq!(difference(&found, &wanted), None, "{}\n{text}", planned.test.name);
        }
    }
}

#[test]
fn the_comparison_sees_a_wrong_angle_feed_and_missing_move() {
    let Some(rs274) = interpreter() else { return };
    let (machine, tests) = load("hermle-c600u.yaml");
    let planned = &tests[0];
    let text = program(&machine, planned, Dialect::LinuxCnc);
    let wanted = planned_moves(&machine, planned, [0.0; 6]);
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
