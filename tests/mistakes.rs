//! Mistakes of a shop in machine file, session and recordings: each is named with its cure or refused, and none ends in a determined number, CLEAN or a finding.
//!
//! One true session is recorded through the default gauge, with location errors, drawn setups and noise; then one mistake
//! is made in its files. Most cases run in this process, some through the program as well.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use fiveaxis::chain::Composition;
use fiveaxis::diagnose::{DataFault, Verdict, diagnose, examine};
use fiveaxis::identify::Options;
use fiveaxis::load::load_session;
use fiveaxis::report::recording::path_csv;
use fiveaxis::session::LengthColumn;
use fiveaxis::simulate::{Instrument, SetupErrors, simulate, simulate_with};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde_json::Value;

/// Files of a session by name.
type Files = BTreeMap<String, String>;

const MACHINE: &str = "\
name: mill
code: \"[wCAbYXZt]\"
directions: carried
axes:
\x20 X: {range: [-300, 300]}
\x20 Y: {range: [-225, 225]}
\x20 Z: {range: [-120, 330]}
\x20 A: {origin: [0, 0, 0], range: [-30, 110]}
\x20 C: {origin: [0, 0, 0], range: [-360, 360]}
";

/// Errors of the true machine.
const ERRORS: [(&str, &str); 2] = [
    (
        "A: {origin: [0, 0, 0]",
        "A: {errors: {EY0A: 36 um, EZ0A: -21 um, EB0A: 7 arcsec, EC0A: -12 arcsec}, origin: [0, 0, 0]",
    ),
    (
        "C: {origin: [0, 0, 0]",
        "C: {errors: {EX0C: -28 um, EY0C: 52 um, EA0C: -22 arcsec, EB0C: 9 arcsec}, origin: [0, 0, 0]",
    ),
];

/// Name, axis with its arc in degrees, pivot, standing axes, bar.
type Design = (&'static str, (char, f64, f64), &'static str, &'static str, f64);

const DESIGNS: [Design; 6] = [
    ("c-short", ('C', 0.0, 360.0), "[0, 100, 0]", "X: 0, Y: 0, Z: 0, A: 0", 100.0),
    ("a-short", ('A', -20.0, 70.0), "[0, 100, 0]", "X: 0, Y: 0, Z: 0, C: 0", 100.0),
    ("c-high", ('C', 0.0, 360.0), "[0, 100, 0]", "X: 0, Y: 0, Z: 111.8034, A: 0", 150.0),
    ("a-far", ('A', -20.0, 70.0), "[0, 100, 0]", "X: -111.8034, Y: 0, Z: 0, C: 0", 150.0),
    ("c-side", ('C', 0.0, 360.0), "[80, 60, 0]", "X: 0, Y: 0, Z: 0, A: 0", 100.0),
    ("a-high", ('A', -20.0, 70.0), "[0, 60, 80]", "X: 0, Y: 0, Z: 0, C: 0", 100.0),
];

/// Rows of a recording.
const ROWS: usize = 121;

/// Seconds from one test to the next.
const EVERY_S: usize = 120;

/// The session; planned, it says its arcs and has no recordings.
fn session_text(is_planned: bool) -> String {
    let mut text = String::from("name: morning\nmachine: machine.yaml\ntests:\n");
    let mut started_at = 0;
    for (name, (axis, from, to), pivot, standing, bar) in DESIGNS {
        for (way, from, to) in [("ccw", from, to), ("cw", to, from)] {
            let step = (to - from).abs() / (ROWS - 1) as f64;
            let arc = match is_planned {
                true => format!("    sweep: {{axis: {axis}, from: {from}, to: {to}, step: {step}}}\n"),
                false => format!("    recording: {name}-{way}.csv\n"),
            };
            let _ = write!(
                text,
                "  - name: {name}-{way}\n{arc}    started_at: {started_at}\n    bar_length: {bar}\n    \
                 pivot: {{link: C, at: {pivot}}}\n    spindle_ball: {{link: Z, at: [0, 0, 0]}}\n    \
                 positions: {{{standing}}}\n    feed: 500\n"
            );
            started_at += EVERY_S;
        }
    }
    text
}

/// The files of the true session, recorded by a machine whose errors are `factor` times those above.
fn recorded(seed: u64, factor: f64) -> Files {
    recorded_by(MACHINE, |text| text, seed, factor)
}

/// The same of another machine, and of some of the tests.
fn recorded_by(machine: &str, tests: fn(String) -> String, seed: u64, factor: f64) -> Files {
    let folder = tempfile::tempdir().unwrap();
    let truth = ERRORS.iter().fold(machine.to_string(), |text, (from, to)| changed(&text, from, to));
    std::fs::write(folder.path().join("machine.yaml"), truth).unwrap();
    std::fs::write(folder.path().join("session.yaml"), tests(session_text(true))).unwrap();
    let mut session = load_session(&folder.path().join("session.yaml")).unwrap();
    session.machine.axes.iter_mut().flat_map(|axis| &mut axis.location_errors).for_each(|error| *error *= factor);
    let traces = simulate_with(&session, Composition::Exact, &SetupErrors::drawn(&session, seed)).unwrap();
    let traces = Instrument::default().read(&session, traces, seed).unwrap();
    let mut files =
        Files::from([("machine.yaml".into(), machine.into()), ("session.yaml".into(), tests(session_text(false)))]);
    for (test, trace) in session.tests.iter().zip(&traces) {
        let csv = path_csv(&session.machine, test, &trace.motion, &trace.length_mm, LengthColumn::LengthMm);
        files.insert(format!("{}.csv", test.name), csv);
    }
    files
}

fn sound() -> &'static Files {
    static SOUND: OnceLock<Files> = OnceLock::new();
    SOUND.get_or_init(|| recorded(20, 1.0))
}

/// A text with one part replaced everywhere; the part must be there.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "'{from}' is not in the text");
    text.replace(from, to)
}

fn edit(files: &mut Files, name: &str, from: &str, to: &str) {
    let text = changed(&files[name], from, to);
    files.insert(name.into(), text);
}

/// Replaces in the tests of the session whose names begin so.
fn edit_tests(files: &mut Files, begin: &str, from: &str, to: &str) {
    let parts: Vec<String> = files["session.yaml"]
        .split("  - name: ")
        .map(|part| if part.starts_with(begin) { changed(part, from, to) } else { part.to_string() })
        .collect();
    files.insert("session.yaml".into(), parts.join("  - name: "));
}

/// Changes the rows of the recordings whose names begin so: time, position, length.
fn edit_rows(files: &mut Files, begin: &str, mut change: impl FnMut(&mut Vec<[f64; 3]>)) {
    for (name, text) in files.iter_mut().filter(|(name, _)| name.ends_with(".csv") && name.starts_with(begin)) {
        let (header, body) = text.split_once('\n').unwrap();
        let row = |line: &str| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            [cells[0], cells[1], cells[2]]
        };
        let mut rows: Vec<[f64; 3]> = body.lines().map(row).collect();
        change(&mut rows);
        assert!(!rows.is_empty(), "{name}");
        let lines: String = rows.iter().map(|[t, q, l]| format!("{t:.4},{q:.9},{l:.7}\n")).collect();
        *text = format!("{header}\n{lines}");
    }
}

fn edit_lengths(files: &mut Files, begin: &str, change: impl Fn(usize, f64) -> f64) {
    edit_rows(files, begin, |rows| {
        rows.iter_mut().enumerate().for_each(|(index, row)| row[2] = change(index, row[2]));
    });
}

/// The gauge shows its first reading of some rows all over them.
fn hold(files: &mut Files, begin: &str, held: Range<usize>) {
    edit_rows(files, begin, |rows| {
        let length = rows[held.start][2];
        rows[held.clone()].iter_mut().for_each(|row| row[2] = length);
    });
}

/// The axis stands for 20 rows in the middle of a recording, with so much noise, mm, while its positions go on.
fn stand(files: &mut Files, begin: &str, noise_mm: f64) {
    const STOOD: usize = 20;
    edit_rows(files, begin, |rows| {
        let (first, last, middle) = (rows[0], rows[ROWS - 1], rows[ROWS / 3]);
        let stood = draws(6, STOOD).into_iter().map(|noise| [0.0, 0.0, middle[2] + noise_mm * noise]);
        let mut all: Vec<[f64; 3]> = rows[..=ROWS / 3].to_vec();
        all.extend(stood);
        all.extend(&rows[ROWS / 3 + 1..]);
        let count = (all.len() - 1) as f64;
        for (row, values) in all.iter_mut().enumerate() {
            values[0] = (last[0] - first[0]) / (ROWS - 1) as f64 * row as f64;
            values[1] = first[1] + (last[1] - first[1]) * row as f64 / count;
        }
        *rows = all;
    });
}

/// Angles written from the wrong end.
fn reverse_angles(files: &mut Files, begin: &str) {
    edit_rows(files, begin, |rows| {
        let angles: Vec<f64> = rows.iter().rev().map(|row| row[1]).collect();
        rows.iter_mut().zip(angles).for_each(|(row, angle)| row[1] = angle);
    });
}

/// Lengths that stand so many rows later than the positions at which they were read; the last ones are lost.
fn rows_late(rows: &mut Vec<[f64; 3]>, late: usize) {
    let lengths: Vec<f64> = rows.iter().map(|row| row[2]).collect();
    rows.drain(..late);
    rows.iter_mut().zip(lengths).for_each(|(row, length)| row[2] = length);
}

fn exchange(files: &mut Files, one: &str, other: &str) {
    let (a, b) = (files[one].clone(), files[other].clone());
    files.insert(one.into(), b);
    files.insert(other.into(), a);
}

fn copy(files: &mut Files, from: &str, to: &[&str]) {
    for name in to {
        let text = files[from].clone();
        files.insert((*name).into(), text);
    }
}

/// Takes functions of the share of the way off some recordings, as they fit them best together with a constant, to 0.1 µm.
fn take_off(files: &mut Files, begin: &str, functions: &[fn(f64) -> f64]) {
    edit_rows(files, begin, |rows| {
        let last = (rows.len() - 1) as f64;
        let of = |row: usize, k: usize| if k == 0 { 1.0 } else { functions[k - 1](row as f64 / last) };
        let columns = DMatrix::from_fn(rows.len(), 1 + functions.len(), of);
        let lengths = DVector::from_fn(rows.len(), |row, _| rows[row][2]);
        let sizes = (columns.tr_mul(&columns)).cholesky().unwrap().solve(&columns.tr_mul(&lengths));
        for (row, values) in rows.iter_mut().enumerate() {
            let taken: f64 = (1..sizes.len()).map(|k| sizes[k] * of(row, k)).sum();
            values[2] = (1e4 * (values[2] - taken)).round() / 1e4;
        }
    });
}

/// The sweeps of the session beside its recordings, those of C from `from` on, with no positions in the files.
fn without_positions(files: &mut Files, from_c: f64) {
    for (name, (axis, from, to), ..) in DESIGNS {
        let by = if axis == 'C' { from_c - from } else { 0.0 };
        for (way, from, to) in [("ccw", from + by, to + by), ("cw", to + by, from + by)] {
            let sweep =
                format!("sweep: {{axis: {axis}, from: {from}, to: {to}, step: 1}}\n    recording: {name}-{way}.csv");
            edit(files, "session.yaml", &format!("recording: {name}-{way}.csv"), &sweep);
        }
    }
    for text in files.iter_mut().filter(|(name, _)| name.ends_with(".csv")).map(|(_, text)| text) {
        *text = text.lines().map(|line| format!("{}\n", line.rsplit(',').next().unwrap())).collect();
    }
}

/// Reproducible draws of a normal distribution, one for each row.
fn draws(seed: u64, count: usize) -> Vec<f64> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| StandardNormal.sample(&mut random)).collect()
}

/// What must become of a mistake.
enum Due {
    /// Named as one of these effects, in words that hold this; others named beside it count.
    Named(&'static [&'static str], &'static str),
    /// The readings cannot be judged, for a reason that holds this.
    Unjudged(&'static str),
    /// Refused as the files are read, in a message that holds this.
    Refused(&'static str),
    /// Nothing is determined, as a ball or bar stands too far from its place: `identify` warns of it, `diagnose` cannot judge.
    Doubted(&'static str),
}

use Due::{Doubted, Named, Refused, Unjudged};

struct Case {
    name: &'static str,
    make: fn(&mut Files),
    due: Due,
}

const PIVOT: &str = "pivot: {link: C, at: [0, 100, 0]}";

/// Spreads of 20, 3 and 0.5 µm, as one who takes them for mm writes them.
const SPREADS_TOO_SMALL: &str = "spread: {pivot: 0.02 um, spindle_ball: 0.003 um, bar_length: 0.0005 um}\ntests:";

/// The recordings of the true session where the pivots stand otherwise in some tests, under the session as it is.
fn recorded_elsewhere(files: &mut Files, tests: fn(String) -> String) {
    let moved = recorded_by(MACHINE, tests, 20, 1.0);
    files.extend(moved.into_iter().filter(|(name, _)| name.ends_with(".csv")));
}

/// Pivots moved in every test for which a shift in x and y is given, mm.
fn pivots_moved(text: String, shift: fn(&str) -> Option<[f64; 2]>) -> String {
    let moved = |part: &str| {
        let Some([x, y]) = part.split('\n').next().and_then(shift) else { return part.to_string() };
        let (head, at) = part.split_once("pivot: {link: C, at: [").unwrap();
        let (at, tail) = at.split_once(']').unwrap();
        let at: Vec<f64> = at.split(", ").map(|cell| cell.parse().unwrap()).collect();
        format!("{head}pivot: {{link: C, at: [{}, {}, {}]{tail}", at[0] + x, at[1] + y, at[2])
    };
    text.split("  - name: ").map(moved).collect::<Vec<String>>().join("  - name: ")
}

const CASES: &[Case] = &[
    Case {
        name: "pivots mounted anew before all runs back",
        make: |f| {
            recorded_elsewhere(f, |text| pivots_moved(text, |name| name.ends_with("-cw").then_some([0.04, 0.03])))
        },
        due: Named(&["mounted-anew"], "between the runs one way and back"),
    },
    Case {
        name: "standing slides in inches",
        make: |f| {
            edit(f, "session.yaml", "Z: 111.8034", "Z: 4.401709");
            edit(f, "session.yaml", "X: -111.8034", "X: -4.401709");
        },
        due: Named(&["unit"], "written in inches"),
    },
    // places of balls
    Case {
        name: "pivot 40 mm off",
        make: |f| edit(f, "session.yaml", PIVOT, "pivot: {link: C, at: [0, 140, 0]}"),
        due: Named(&["ball-place"], "pivot on C at (0, 140, 0) stands at about (0, 100.0, 0)"),
    },
    Case {
        name: "x and y of the pivot exchanged",
        make: |f| edit(f, "session.yaml", PIVOT, "pivot: {link: C, at: [100, 0, 0]}"),
        due: Named(&["ball-place"], "x and y are exchanged"),
    },
    Case {
        name: "sign of the pivot's y turned",
        make: |f| edit_tests(f, "a-high", "[0, 60, 80]", "[0, -60, 80]"),
        due: Named(&["ball-place"], "pivot on C at (0, -60, 80)"),
    },
    Case {
        name: "pivot 2 mm off",
        make: |f| edit(f, "session.yaml", PIVOT, "pivot: {link: C, at: [0, 102, 0]}"),
        due: Named(&["ball-place"], "stands at about (0, 100.0, 0)"),
    },
    Case {
        name: "pivot half a millimetre off",
        make: |f| edit(f, "session.yaml", PIVOT, "pivot: {link: C, at: [0, 99.5, 0]}"),
        due: Named(&["ball-place"], "pivot on C at (0, 99.5, 0)"),
    },
    Case {
        name: "height of the pivot forgotten",
        make: |f| edit_tests(f, "a-high", "[0, 60, 80]", "[0, 60, 0]"),
        due: Named(&["ball-place"], "pivot on C at (0, 60, 0)"),
    },
    Case {
        name: "pivot in inches",
        make: |f| edit(f, "session.yaml", PIVOT, "pivot: {link: C, at: [0, 3.937, 0]}"),
        due: Named(&["ball-place"], "pivot on C at (0, 3.937, 0)"),
    },
    Case {
        name: "pivot in metres",
        make: |f| edit(f, "session.yaml", PIVOT, "pivot: {link: C, at: [0, 0.1, 0]}"),
        due: Named(&["ball-place"], "pivot on C at (0, 0.1, 0)"),
    },
    Case {
        name: "pivot on the wrong link",
        make: |f| edit(f, "session.yaml", "pivot: {link: C", "pivot: {link: A"),
        due: Named(&["ball-link"], "carried by C"),
    },
    Case {
        name: "pivot on the bed",
        make: |f| edit(f, "session.yaml", "pivot: {link: C", "pivot: {link: b"),
        due: Named(&["ball-link"], "carried by"),
    },
    Case {
        name: "spindle ball at the gauge length",
        make: |f| {
            edit(
                f,
                "session.yaml",
                "spindle_ball: {link: Z, at: [0, 0, 0]}",
                "spindle_ball: {link: Z, at: [0, 0, -85]}",
            )
        },
        due: Named(&["ball-place"], "spindle ball on Z at (0, 0, -85)"),
    },
    Case {
        name: "spindle ball beside the spindle",
        make: |f| {
            edit(f, "session.yaml", "spindle_ball: {link: Z, at: [0, 0, 0]}", "spindle_ball: {link: Z, at: [0, 30, 0]}")
        },
        due: Named(&["ball-place"], "spindle ball on Z at (0, 30, 0)"),
    },
    Case {
        name: "spindle ball on the bed",
        make: |f| edit(f, "session.yaml", "spindle_ball: {link: Z", "spindle_ball: {link: b"),
        due: Named(&["ball-link", "ball-place", "standing-axis"], ""),
    },
    // axes that stood elsewhere, bars, the machine
    Case {
        name: "Z of the cone forgotten",
        make: |f| edit_tests(f, "c-high", "Z: 111.8034", "Z: 0"),
        due: Named(&["standing-axis"], "Z stood at about"),
    },
    Case {
        name: "Z of the cone 5 mm low",
        make: |f| edit_tests(f, "c-high", "Z: 111.8034", "Z: 106.8034"),
        due: Named(&["standing-axis"], "Z stood at about 111.8"),
    },
    Case {
        name: "X of the far test 3 mm off",
        make: |f| edit_tests(f, "a-far", "X: -111.8034", "X: -114.8034"),
        due: Named(&["standing-axis"], "X stood at about"),
    },
    Case {
        name: "C stood at 0 and not at 30 degrees in the short test of A",
        make: |f| edit_tests(f, "a-short", "C: 0", "C: 30"),
        due: Named(&["standing-axis"], "C stood at about"),
    },
    Case {
        name: "C stood at 0 and not at 90 degrees in the high test",
        make: |f| edit_tests(f, "a-high", "C: 0", "C: 90"),
        due: Named(&["standing-axis", "ball-place"], ""),
    },
    Case {
        name: "another bar of the same nominal length",
        make: |f| ["c-high", "a-far"].iter().for_each(|begin| edit_lengths(f, begin, |_, length| length + 0.4)),
        due: Named(&["bar-other"], "0.4"),
    },
    Case {
        name: "the other bar in the session",
        make: |f| edit_tests(f, "c-high", "bar_length: 150", "bar_length: 100"),
        due: Refused("check bar_length and which recording belongs to the test"),
    },
    Case {
        name: "C stands 20 mm beside its line in the machine file",
        make: |f| edit(f, "machine.yaml", "C: {origin: [0, 0, 0]", "C: {origin: [0, 20, 0]"),
        due: Named(&["axis-line"], "correct 'origin' of C"),
    },
    Case {
        name: "A lies 30 mm lower in the machine file",
        make: |f| edit(f, "machine.yaml", "A: {origin: [0, 0, 0]", "A: {origin: [0, 0, -30]"),
        due: Named(&["axis-line"], "correct 'origin' of A"),
    },
    Case {
        name: "A turns about Y in the machine file",
        make: |f| edit(f, "machine.yaml", "A: {origin", "A: {direction: [0, 1, 0], origin"),
        due: Named(&["axis-direction"], "A turns about X by the lengths"),
    },
    Case {
        name: "machine file of another machine",
        make: |f| {
            edit(f, "machine.yaml", "[wCAbYXZt]", "[wCBbYXZt]");
            edit(f, "machine.yaml", "  A: {", "  B: {");
        },
        due: Refused("no axis 'A'"),
    },
    Case {
        name: "C typed 2 degrees off in the far test of A",
        make: |f| edit_tests(f, "a-far", "C: 0", "C: 2"),
        due: Named(&["standing-axis"], "C stood at about"),
    },
    Case {
        name: "A typed 1 degree off in the high test of C",
        make: |f| edit_tests(f, "c-high", "A: 0", "A: 1"),
        due: Named(&["standing-axis"], "A stood at about"),
    },
    Case {
        name: "C stands 2 mm beside its line in the machine file",
        make: |f| edit(f, "machine.yaml", "C: {origin: [0, 0, 0]", "C: {origin: [0, 2, 0]"),
        due: Named(&["axis-line"], "correct 'origin' of C"),
    },
    Case {
        name: "x of the pivot typed 1 mm off",
        make: |f| edit(f, "session.yaml", PIVOT, "pivot: {link: C, at: [1, 100, 0]}"),
        due: Named(&["ball-place"], "pivot on C at (1, 100, 0) stands at about (0.0"),
    },
    Case {
        name: "pivot a tenth of a millimetre off",
        make: |f| edit(f, "session.yaml", PIVOT, "pivot: {link: C, at: [0, 100.1, 0]}"),
        due: Doubted("times its spread"),
    },
    // files of other tests
    Case {
        name: "one recording copied over its repeat",
        make: |f| copy(f, "c-short-ccw.csv", &["c-short-cw.csv"]),
        due: Named(&["same-recording"], "c-short-ccw, c-short-cw"),
    },
    Case {
        name: "one recording copied into six tests",
        make: |f| copy(f, "c-short-ccw.csv", &["c-short-cw.csv", "c-side-ccw.csv", "c-side-cw.csv"]),
        due: Named(&["same-recording"], "give each test its own recording"),
    },
    Case {
        name: "every test listed twice",
        make: |f| {
            let text = f["session.yaml"].clone();
            let (_, tests) = text.split_once("tests:\n").unwrap();
            let again = tests.replace("- name: ", "- name: again-");
            f.insert("session.yaml".into(), text.clone() + &again);
        },
        due: Named(&["same-recording"], "list a recording once"),
    },
    Case {
        name: "files of two directions exchanged",
        make: |f| exchange(f, "c-short-ccw.csv", "c-short-cw.csv"),
        due: Named(&["direction"], "c-short-ccw, c-short-cw"),
    },
    Case {
        name: "files of two pivots exchanged",
        make: |f| exchange(f, "c-short-ccw.csv", "c-side-ccw.csv"),
        due: Named(&["files-exchanged"], "c-short-ccw and c-side-ccw"),
    },
    Case {
        name: "files of two pivots exchanged in both directions",
        make: |f| {
            exchange(f, "c-short-ccw.csv", "c-side-ccw.csv");
            exchange(f, "c-short-cw.csv", "c-side-cw.csv");
        },
        due: Named(&["files-exchanged"], "each with its repeats"),
    },
    Case {
        name: "files of a slow and a fast program exchanged",
        make: |f| {
            edit_rows(f, "c-side", |rows| rows.iter_mut().for_each(|row| row[0] *= 2.0));
            edit_tests(f, "c-side", "feed: 500", "feed: 250");
            exchange(f, "c-short-ccw.csv", "c-side-ccw.csv");
            exchange(f, "c-short-cw.csv", "c-side-cw.csv");
        },
        due: Named(
            &["files-exchanged"],
            "c-short-ccw and c-side-ccw ran at each other's stated feed, as in 1 further pair",
        ),
    },
    Case {
        name: "positions in whole degrees",
        make: |f| edit_rows(f, "a-short", |rows| rows.iter_mut().for_each(|row| row[1] = row[1].round())),
        due: Named(&["values-rounded"], "A"),
    },
    Case {
        name: "deviations of a program of the wrong sign",
        make: |f| edit_lengths(f, "c-side", |_, length| 200.0 - length),
        due: Named(&["reading-sign"], "c-side"),
    },
    Case {
        name: "deviations of a program a tenth",
        make: |f| edit_lengths(f, "c-side", |_, length| 100.0 + 0.1 * (length - 100.0)),
        due: Named(&["unit"], "a tenth of what they should be"),
    },
    Case {
        name: "deviations of a program ten times too large",
        make: |f| edit_lengths(f, "c-side", |_, length| 100.0 + 10.0 * (length - 100.0)),
        due: Named(&["unit"], "ten times too large"),
    },
    Case {
        name: "deviations half as large again in the last tests",
        make: |f| {
            for begin in ["c-side", "a-high"] {
                edit_lengths(f, begin, |_, length| 100.0 + 1.5 * (length - 100.0));
            }
        },
        // of the tests between the two readings say nothing, so that it may as well be the first ones
        due: Named(&["unit"], "times what they should be"),
    },
    Case {
        name: "readings of one file in steps of 5 micrometres",
        make: |f| edit_lengths(f, "c-side-cw", |_, length| (length / 0.005).round() * 0.005),
        due: Named(&["values-rounded"], "readings of c-side-cw go by steps of 5 µm"),
    },
    Case {
        name: "C in turns",
        make: |f| edit_rows(f, "c-", |rows| rows.iter_mut().for_each(|row| row[1] /= 360.0)),
        due: Named(&["unit"], "C is in turns"),
    },
    Case {
        name: "lengths three rows late everywhere",
        make: |f| edit_rows(f, "", |rows| rows_late(rows, 3)),
        due: Named(&["time-shift"], "lengths stand 3 rows later"),
    },
    Case {
        name: "lengths of one program a row late",
        make: |f| edit_rows(f, "c-side", |rows| rows_late(rows, 1)),
        due: Named(&["time-shift"], "c-side-ccw, c-side-cw"),
    },
    Case {
        name: "A in gon",
        make: |f| edit_rows(f, "a-", |rows| rows.iter_mut().for_each(|row| row[1] /= 0.9)),
        due: Named(&["unit"], "as it does in gon"),
    },
    Case {
        name: "A a twentieth too large",
        make: |f| edit_rows(f, "a-", |rows| rows.iter_mut().for_each(|row| row[1] *= 1.05)),
        due: Named(&["unit"], "the column A is 1.05"),
    },
    Case {
        name: "every recording zeroed at its start",
        make: |f| {
            edit_rows(f, "", |rows| {
                let (first, bar) = (rows[0][2], rows[0][2].round());
                rows.iter_mut().for_each(|row| row[2] += bar - first);
            })
        },
        due: Named(&["readings-processed"], "zeroed at the start of every recording"),
    },
    Case {
        name: "the mean taken off every recording",
        make: |f| {
            edit_rows(f, "", |rows| {
                let mean = rows.iter().map(|row| row[2]).sum::<f64>() / rows.len() as f64;
                rows.iter_mut().for_each(|row| row[2] += mean.round() - mean);
            })
        },
        due: Named(&["readings-processed"], "the mean was taken off"),
    },
    Case {
        name: "a trend taken off one program",
        make: |f| take_off(f, "a-far", &[|share| share]),
        due: Named(&["readings-processed"], "a trend over time was taken off the readings of a-far-ccw, a-far-cw"),
    },
    Case {
        name: "the centre of its circle taken off one program",
        make: |f| take_off(f, "c-side", &[|share| (TAU * share).cos(), |share| (TAU * share).sin()]),
        due: Named(&["readings-processed"], "the centre of the circle was taken off the readings of c-side"),
    },
    Case {
        name: "deviations of one program without their sign",
        make: |f| edit_lengths(f, "c-side", |_, length| length.round() + (length - length.round()).abs()),
        due: Named(&["readings-processed"], "c-side-ccw, c-side-cw lost their sign"),
    },
    Case {
        name: "deviations of one program twice as large",
        make: |f| edit_lengths(f, "c-side", |_, length| length.round() + 2.0 * (length - length.round())),
        due: Named(&["unit"], "c-side-ccw, c-side-cw are about 2.00 times"),
    },
    Case {
        name: "deviations of one direction halved",
        make: |f| edit_lengths(f, "a-high-cw", |_, length| length.round() + 0.5 * (length - length.round())),
        due: Named(&["unit"], "a-high-cw are about 0.50 times"),
    },
    Case {
        name: "deviations of two recordings of two programs twice as large",
        make: |f| {
            for name in ["a-high-cw", "c-side-ccw"] {
                edit_lengths(f, name, |_, length| length.round() + 2.0 * (length - length.round()));
            }
        },
        due: Named(&["unit"], "c-side-ccw, a-high-cw are about 2.00 times"),
    },
    Case {
        name: "deviations of three recordings of three programs turned",
        make: |f| {
            for name in ["a-far-ccw", "a-high-cw", "c-side-ccw"] {
                edit_lengths(f, name, |_, length| 2.0 * length.round() - length);
            }
        },
        due: Named(&["reading-sign"], "a-far-ccw, c-side-ccw, a-high-cw have the wrong sign"),
    },
    Case {
        name: "half of a recording drawn along a straight line",
        make: |f| {
            edit_rows(f, "c-side-ccw", |rows| {
                let (first, last) = (rows[30][2], rows[90][2]);
                for (row, values) in rows.iter_mut().enumerate().take(90).skip(30) {
                    values[2] = first + (row - 30) as f64 / 60.0 * (last - first);
                }
            })
        },
        due: Named(&["readings-processed"], "of c-side-ccw follow a smooth curve to the last digit"),
    },
    Case {
        name: "a program drawn from its own circle, with a hundredth of a micrometre on it",
        make: |f| {
            let noise = draws(7, ROWS);
            edit_rows(f, "c-side", |rows| {
                let read: Vec<f64> = rows.iter().map(|row| row[2]).collect();
                let mean = read.iter().sum::<f64>() / ROWS as f64;
                let of = |wave: fn(f64) -> f64| -> f64 {
                    let waves = rows.iter().zip(&read).skip(1).map(|(row, length)| length * wave(row[1].to_radians()));
                    2.0 * waves.sum::<f64>() / (ROWS - 1) as f64
                };
                let (a, b) = (of(f64::cos), of(f64::sin));
                for (row, noise) in rows.iter_mut().zip(&noise) {
                    let (sin, cos) = row[1].to_radians().sin_cos();
                    row[2] = mean + a * cos + b * sin + 1e-5 * noise;
                }
            })
        },
        due: Named(&["readings-processed"], "readings of c-side-ccw, c-side-cw scatter by 0.01"),
    },
    Case {
        name: "a machine lock in one program",
        make: |f| {
            let noise = draws(8, ROWS);
            edit_rows(f, "c-side", |rows| {
                let at_rest = if rows[0][1] < 1.0 { rows[0][2] } else { rows[ROWS - 1][2] };
                rows.iter_mut().zip(&noise).for_each(|(row, noise)| row[2] = at_rest + 2e-4 * noise);
            })
        },
        due: Named(&["standing-axis"], "no axis moved in c-side-ccw, c-side-cw"),
    },
    Case {
        name: "angles of A without their sign",
        make: |f| edit_rows(f, "a-", |rows| rows.iter_mut().for_each(|row| row[1] = row[1].abs())),
        due: Named(&["axis-sign"], "lost its sign: it turns back at 0"),
    },
    // order of readings
    Case {
        name: "readings of one recording from the other end",
        make: |f| {
            edit_rows(f, "c-side-cw", |rows| {
                let lengths: Vec<f64> = rows.iter().rev().map(|row| row[2]).collect();
                rows.iter_mut().zip(lengths).for_each(|(row, length)| row[2] = length);
            })
        },
        due: Named(&["readings-order"], "c-side-cw are written from the other end"),
    },
    Case {
        name: "readings of one recording moved round by 30 rows",
        make: |f| {
            edit_rows(f, "c-side-ccw", |rows| {
                let count = rows.len();
                let lengths: Vec<f64> = (0..count).map(|row| rows[(row + 30) % count][2]).collect();
                rows.iter_mut().zip(lengths).for_each(|(row, length)| row[2] = length);
            })
        },
        due: Named(&["readings-order"], "c-side-ccw"),
    },
    Case {
        name: "rows lost and the others drawn over the gap",
        make: |f| {
            edit_rows(f, "c-side-ccw", |rows| {
                let (first, last) = (rows[0], rows[rows.len() - 1]);
                rows.drain(50..62);
                let count = (rows.len() - 1) as f64;
                for (row, values) in rows.iter_mut().enumerate() {
                    let share = row as f64 / count;
                    (0..2).for_each(|k| values[k] = first[k] + share * (last[k] - first[k]));
                }
            })
        },
        due: Named(&["readings-order"], "readings of c-side-ccw are lost"),
    },
    Case {
        name: "sweeps of C stated from -180 that began at 0, no positions in the files",
        make: |f| without_positions(f, -180.0),
        due: Named(&["arc"], "a sweep of C from about"),
    },
    Case {
        name: "A and C the wrong way round in the machine's code",
        make: |f| edit(f, "machine.yaml", "[wCAbYXZt]", "[wACbYXZt]"),
        due: Named(&["axis-order"], "write the code as [wCAbYXZt]"),
    },
    Case {
        name: "a program zeroed for itself",
        make: |f| edit_lengths(f, "c-side", |_, length| length + 0.4),
        due: Named(&["reading-zero", "ball-place", "bar-other"], "c-side"),
    },
    Case {
        name: "a standing slide rounded",
        make: |f| edit_tests(f, "a-far", "X: -111.8034", "X: -112"),
        due: Named(&["standing-axis"], "X stood at about -111.8"),
    },
    Case {
        name: "angles of a program from another zero",
        make: |f| edit_rows(f, "c-side", |rows| rows.iter_mut().for_each(|row| row[1] -= 30.0)),
        due: Named(&["column-shifted"], "column C is off by about -30"),
    },
    Case {
        name: "angles of two programs from another zero",
        make: |f| {
            for begin in ["c-side", "c-high"] {
                edit_rows(f, begin, |rows| rows.iter_mut().for_each(|row| row[1] -= 30.0));
            }
        },
        due: Named(&["column-shifted"], "column C is off by about -30"),
    },
    Case {
        name: "angles of a program in radians",
        make: |f| edit_rows(f, "c-side", |rows| rows.iter_mut().for_each(|row| row[1] = row[1].to_radians())),
        due: Named(&["unit", "arc"], "c-side"),
    },
    Case {
        name: "files of two axes exchanged",
        make: |f| exchange(f, "c-short-ccw.csv", "a-short-ccw.csv"),
        due: Refused("axis C has neither a column"),
    },
    Case {
        name: "a file of another machine's session",
        make: |f| {
            let other = recorded(77, -2.0);
            f.insert("c-short-cw.csv".into(), other["c-short-cw.csv"].clone());
        },
        due: Named(&["foreign-file"], "c-short-cw does not belong"),
    },
    Case {
        name: "files of two programs from another day",
        make: |f| {
            let is_other = |name: &str| ["c-short-cw", "a-far-ccw"].contains(&name);
            let of_that_day = recorded_by(
                MACHINE,
                |text| pivots_moved(text, |name| (!name.starts_with("name:")).then_some([0.05, -0.04])),
                33,
                1.0,
            );
            f.extend(of_that_day.into_iter().filter(|(name, _)| is_other(name.trim_end_matches(".csv"))));
        },
        due: Named(&["foreign-file"], "c-short-cw, a-far-ccw do not belong"),
    },
    Case {
        name: "X touched off anew before the second half",
        make: |f| {
            recorded_elsewhere(f, |text| {
                let is_later = |part: &str| ["a-far", "c-side", "a-high"].iter().any(|begin| part.starts_with(begin));
                let moved = |part: &str| match is_later(part) {
                    true => part.replace("{X: 0,", "{X: 0.2,").replace("{X: -111.8034,", "{X: -111.6034,"),
                    false => part.to_string(),
                };
                text.split("  - name: ").map(moved).collect::<Vec<String>>().join("  - name: ")
            })
        },
        due: Named(&["standing-axis"], "its zero was touched off anew"),
    },
    Case {
        name: "spreads of both balls a thousand times too small",
        make: |f| edit(f, "session.yaml", "tests:", "spread: {pivot: 0.02 um, spindle_ball: 0.003 um}\ntests:"),
        due: Named(&["unit"], "spreads are stated a thousand times too small"),
    },
    Case {
        name: "all spreads a thousand times too small",
        make: |f| edit(f, "session.yaml", "tests:", SPREADS_TOO_SMALL),
        due: Named(&["unit"], "spreads are stated a thousand times too small"),
    },
    Case {
        name: "the spindle ball's spread in nanometres",
        make: |f| edit(f, "session.yaml", "tests:", "spread: {spindle_ball: 0.003 um}\ntests:"),
        due: Doubted("every σ would hold only with that"),
    },
    Case {
        name: "half of a file",
        make: |f| edit_rows(f, "c-side-cw", |rows| rows.truncate(ROWS / 2)),
        due: Named(&["arc"], "cut short"),
    },
    Case {
        name: "the sweep of another test",
        make: |f| edit_tests(f, "c-side-cw", "    feed", "    sweep: {axis: C, from: 180, to: 90, step: 3}\n    feed"),
        due: Named(&["arc"], "c-side-cw"),
    },
    Case {
        name: "the sweep of the other direction",
        make: |f| edit_tests(f, "c-side-cw", "    feed", "    sweep: {axis: C, from: 0, to: 360, step: 3}\n    feed"),
        due: Named(&["direction"], "c-side-cw"),
    },
    // rows
    Case {
        name: "a dwell left in, positions spread over it",
        make: |f| {
            edit_rows(f, "c-", |rows| {
                let (first, last) = (rows[0], rows[ROWS - 1]);
                let noise = draws(3, 20);
                let dwell = |row: [f64; 3], k: usize| [0.0, 0.0, row[2] + 2e-4 * noise[k]];
                let mut all: Vec<[f64; 3]> = (0..12).map(|k| dwell(first, k)).collect();
                all.extend(rows.iter());
                all.extend((12..20).map(|k| dwell(last, k)));
                let step = (last[0] - first[0]) / (ROWS - 1) as f64;
                for k in 0..all.len() {
                    all[k][0] = step * k as f64;
                    all[k][1] = first[1] + (last[1] - first[1]) * k as f64 / (all.len() - 1) as f64;
                }
                *rows = all;
            });
        },
        due: Named(&["dwell"], "cut those rows"),
    },
    Case {
        name: "a dwell left in, positions standing",
        make: |f| {
            edit_rows(f, "a-high-cw", |rows| {
                let noise = draws(4, 30);
                let last = rows[ROWS - 1];
                rows.extend((0..30).map(|k| [last[0] + 0.1 * (k + 1) as f64, last[1], last[2] + 2e-4 * noise[k]]));
            });
        },
        due: Named(&["dwell"], "rows 121 to 151"),
    },
    Case {
        name: "both directions in one file, positions spread over them",
        make: |f| {
            for name in ["c-short", "c-high", "c-side"] {
                let back = f[&format!("{name}-cw.csv")].clone();
                let back: Vec<f64> =
                    back.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
                edit_rows(f, &format!("{name}-ccw"), |rows| {
                    let (count, last) = (rows.len() + back.len(), rows[ROWS - 1][0]);
                    let lengths: Vec<f64> = rows.iter().map(|row| row[2]).chain(back.iter().copied()).collect();
                    let at = |k: usize| k as f64 / (count - 1) as f64;
                    *rows = (0..count).map(|k| [last * at(k), 360.0 * at(k), lengths[k]]).collect();
                });
            }
            let text = f["session.yaml"].clone();
            let parts: Vec<&str> =
                text.split("  - name: ").filter(|part| !(part.starts_with("c-") && part.contains("-cw.csv"))).collect();
            f.insert("session.yaml".into(), parts.join("  - name: "));
        },
        due: Named(&["both-directions"], "make two tests of each"),
    },
    Case {
        name: "every row twice",
        make: |f| {
            edit_rows(f, "c-side-ccw", |rows| {
                *rows = rows.iter().flat_map(|row| [*row, [row[0] + 0.1, row[1], row[2]]]).collect();
            });
        },
        due: Named(&["doubled-rows"], "keep one row for each position"),
    },
    Case {
        name: "times in milliseconds",
        make: |f| edit_rows(f, "", |rows| rows.iter_mut().for_each(|row| row[0] *= 1e3)),
        due: Named(&["unit", "session-time"], "seconds"),
    },
    Case {
        name: "times in milliseconds, without the beginnings of tests",
        make: |f| {
            edit_rows(f, "", |rows| rows.iter_mut().for_each(|row| row[0] *= 1e3));
            for k in 1..2 * DESIGNS.len() {
                edit(f, "session.yaml", &format!("started_at: {}\n", k * EVERY_S), "started_at: 0\n");
            }
        },
        due: Named(&["unit"], "milliseconds"),
    },
    Case {
        name: "times backwards",
        make: |f| edit_rows(f, "a-far", |rows| rows.reverse()),
        due: Refused("times rise from row to row"),
    },
    Case {
        name: "angles in radians",
        make: |f| edit_rows(f, "c-", |rows| rows.iter_mut().for_each(|row| row[1] = row[1].to_radians())),
        due: Named(&["unit"], "C is in radians"),
    },
    Case {
        name: "sign of an axis turned",
        make: |f| edit_rows(f, "a-", |rows| rows.iter_mut().for_each(|row| row[1] = -row[1])),
        due: Refused("outside"),
    },
    Case {
        name: "angles of one direction written from the wrong end",
        make: |f| {
            ["c-short-cw", "c-high-cw", "c-side-cw"].iter().for_each(|name| reverse_angles(f, name));
        },
        due: Named(&["angle-reversed", "axis-sign"], "C"),
    },
    Case {
        name: "all angles of A written from the wrong end",
        make: |f| reverse_angles(f, "a-"),
        due: Named(&["angle-reversed"], "A of these recordings is written from the wrong end"),
    },
    Case {
        name: "all angles of C written from the wrong end, on an arc like its mirror image",
        make: |f| reverse_angles(f, "c-"),
        due: Named(&["angle-reversed"], "C"),
    },
    Case {
        name: "a sweep of C that stood in the middle, positions drawn over it",
        make: |f| stand(f, "c-side-ccw", 2e-4),
        due: Named(&["dwell"], "c-side-ccw"),
    },
    Case {
        name: "a sweep of C that stood in the middle with one reading, positions drawn over it",
        make: |f| stand(f, "c-side-ccw", 0.0),
        due: Named(&["dwell"], "the axis stood in rows"),
    },
    Case {
        name: "a sense of A and the length of a bar",
        make: |f| {
            edit(f, "machine.yaml", "A: {origin", "A: {reversed: true, origin");
            ["c-high", "a-far"].iter().for_each(|begin| edit_lengths(f, begin, |_, length| length + 0.7));
        },
        due: Named(&["axis-sign", "bar-other"], "two mistakes at once"),
    },
    Case {
        name: "feed of another program",
        make: |f| edit(f, "session.yaml", "feed: 500", "feed: 2000"),
        due: Named(&["feed"], "correct the feed"),
    },
    Case {
        name: "two tests at one time",
        make: |f| edit_tests(f, "c-side-cw", "started_at: 1080", "started_at: 980"),
        due: Named(&["session-time"], "started_at"),
    },
    Case {
        name: "a test before the session",
        make: |f| edit_tests(f, "c-side-cw", "started_at: 1080", "started_at: -1080"),
        due: Named(&["session-time"], "before its session began"),
    },
    // lengths
    Case {
        name: "deviations in place of lengths",
        make: |f| edit_lengths(f, "c-short", |_, length| length - 100.0),
        due: Refused("deviation"),
    },
    Case {
        name: "lengths in inches",
        make: |f| edit_lengths(f, "", |_, length| length / 25.4),
        due: Refused("inches"),
    },
    Case {
        name: "lengths in µm",
        make: |f| edit_lengths(f, "", |_, length| 1e3 * length),
        due: Refused("check bar_length"),
    },
    Case {
        name: "the gauge stuck in one test",
        make: |f| edit_lengths(f, "c-side-cw", |_, _| 100.0123),
        due: Named(&["gauge-stuck"], "c-side-cw"),
    },
    Case {
        name: "the gauge stuck for a while",
        make: |f| hold(f, "c-side-cw", 40..75),
        due: Named(&["gauge-stuck"], "35 readings of c-side-cw in a row"),
    },
    Case {
        name: "a fine gauge that stuck, where no other readings are equal",
        make: |f| {
            edit_lengths(f, "", |row, length| length + 1e-7 * (row * 7919 % 97) as f64);
            hold(f, "c-side-cw", 40..60);
        },
        due: Named(&["gauge-stuck"], "20 readings of c-side-cw in a row"),
    },
    Case {
        name: "the bar at the end of its stroke",
        make: |f| edit_lengths(f, "c-side-cw", |_, length| length.min(100.01)),
        due: Named(&["stroke-end"], "end of its stroke"),
    },
    Case {
        name: "1 mm of noise",
        make: |f| {
            let noise = draws(1, 2 * ROWS);
            edit_lengths(f, "", |row, length| length + noise[(7 * row + (1e7 * length) as usize) % noise.len()]);
        },
        due: Unjudged("readings scatter by"),
    },
    Case {
        name: "three of ten readings off by 0.1 mm",
        make: |f| {
            let noise = draws(2, 2 * ROWS);
            edit_lengths(f, "", |row, length| {
                let draw = noise[(7 * row + (1e7 * length) as usize) % noise.len()];
                if draw > 0.52 { length + 0.1 } else { length }
            });
        },
        due: Unjudged("look after the gauge"),
    },
    Case {
        name: "one of eight readings off by 0.1 mm",
        make: |f| edit_lengths(f, "", |row, length| if row % 8 == 3 { length - 0.1 } else { length }),
        due: Unjudged("far from their neighbours"),
    },
    Case {
        name: "most readings missing",
        make: |f| {
            let text = f["a-far-cw.csv"].clone();
            let lines = text.lines().enumerate().map(|(index, line)| match index % 4 {
                0 => format!("{line}\n"),
                _ => format!("{},\n", line.rsplit_once(',').unwrap().0),
            });
            f.insert("a-far-cw.csv".into(), lines.collect());
        },
        due: Named(&["readings-missing"], "a-far-cw"),
    },
    // digits
    Case {
        name: "a gauge that was off all morning",
        make: |f| edit_lengths(f, "", |_, length| length.round()),
        due: Named(&["gauge-stuck"], "no reading differs"),
    },
    Case {
        name: "a gauge whose range ends at 10 µm on either side",
        make: |f| edit_lengths(f, "", |_, length| length.clamp(length.round() - 0.01, length.round() + 0.01)),
        due: Named(&["stroke-end"], "end of its stroke"),
    },
    Case {
        name: "lengths with two decimals",
        make: |f| edit_lengths(f, "", |_, length| (100.0 * length).round() / 100.0),
        due: Named(&["values-rounded"], "all lengths are multiples of 0.01 mm"),
    },
    Case {
        name: "a recording added to itself",
        make: |f| {
            edit_rows(f, "c-side-cw", |rows| {
                let step = rows[1][0] - rows[0][0];
                let again = rows.last().unwrap()[0] + step;
                let second: Vec<[f64; 3]> = rows.iter().map(|row| [row[0] + again, row[1], row[2]]).collect();
                rows.extend(second);
            })
        },
        due: Named(&["doubled-rows"], "added to itself"),
    },
    Case {
        name: "A of one planned recording 2° beside its sweep",
        make: |f| {
            for (name, (axis, from, to), ..) in DESIGNS {
                for (way, from, to) in [("ccw", from, to), ("cw", to, from)] {
                    let sweep = format!(
                        "sweep: {{axis: {axis}, from: {from}, to: {to}, step: 1}}\n    recording: {name}-{way}.csv"
                    );
                    edit(f, "session.yaml", &format!("recording: {name}-{way}.csv"), &sweep);
                }
            }
            edit_rows(f, "a-high-cw", |rows| rows.iter_mut().for_each(|row| row[1] += 1.5));
        },
        due: Named(&["column-shifted"], "beside the sweep"),
    },
    Case {
        name: "half of a recording in another unit",
        make: |f| {
            edit_lengths(f, "c-side-cw", |row, length| match row < 60 {
                true => length,
                false => 100.0 + (10.0 * (length - 100.0)).round() / 1e4,
            });
        },
        due: Named(&["gauge-stuck", "readings-processed"], "c-side-cw in a row"),
    },
    // texts
    Case {
        name: "header missing",
        make: |f| {
            let text = f["c-side-cw.csv"].clone();
            f.insert("c-side-cw.csv".into(), text.split_once('\n').unwrap().1.into());
        },
        due: Refused("c-side-cw.csv"),
    },
    Case {
        name: "decimal commas",
        make: |f| edit(f, "c-side-cw.csv", ".", ","),
        due: Refused("decimal commas need ;"),
    },
    Case {
        name: "a file cut in mid-row",
        make: |f| {
            let text = f["c-side-cw.csv"].clone();
            f.insert("c-side-cw.csv".into(), text[..text.len() / 2].trim_end_matches(|c| c != ',').into());
        },
        due: Refused("c-side-cw.csv"),
    },
];

fn written(files: &Files, folder: &Path) {
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

/// Whether a fault is told as one of these effects in such words, by itself or beside one that leaves the same.
fn is_told(fault: &DataFault, effects: &[&str], words: &str) -> bool {
    let own = effects.contains(&fault.kind.name()) && fault.says.contains(words);
    own || fault.rivals.iter().any(|rival| effects.contains(&rival.kind.name()) && rival.says.contains(words))
}

/// What is asked: both examine a session first, and answer the same.
#[derive(Clone, Copy, PartialEq)]
enum Verb {
    Identify,
    Diagnose,
    Both,
}

/// What is wrong with the answers on a case; empty where they are as they should be.
fn wrong(case: &Case, verb: Verb) -> String {
    let mut files = sound().clone();
    (case.make)(&mut files);
    let folder = tempfile::tempdir().unwrap();
    written(&files, folder.path());
    let session = match (load_session(&folder.path().join("session.yaml")), &case.due) {
        (Err(refusal), Refused(words)) => {
            let message = refusal.to_string();
            return if message.contains(words) { String::new() } else { format!("refused with '{message}'") };
        }
        (Err(refusal), _) => return format!("refused: {refusal}"),
        (Ok(_), Refused(_)) => return "not refused".into(),
        (Ok(session), _) => session,
    };
    let options = Options::default();
    let mut answers: Vec<(Option<DataFault>, Option<String>)> = Vec::new();
    if verb != Verb::Diagnose {
        let examination = match examine(&session, &options) {
            Ok(examination) => examination,
            Err(why) => return format!("{why}"),
        };
        let determined = examination.fit.iter().flat_map(|fit| &fit.estimates).filter(|one| one.determined).count();
        let is_doubted = matches!(case.due, Doubted(_));
        if determined > 0 || examination.is_sound() != is_doubted {
            return format!("{determined} determined");
        }
        let doubt = examination.warnings.last().filter(|_| is_doubted);
        answers.push((examination.fault, doubt.cloned().or(examination.unjudged)));
    }
    if verb != Verb::Identify {
        let diagnosis = match diagnose(&session, &options) {
            Ok(diagnosis) => diagnosis,
            Err(why) => return format!("{why}"),
        };
        if diagnosis.is_sound() || !diagnosis.findings.is_empty() {
            return format!("diagnosed as {:?} {:?}", diagnosis.verdict, diagnosis.findings.first().map(|f| &f.cause));
        }
        answers.push((diagnosis.data_fault, diagnosis.unjudged));
    }
    for (fault, unjudged) in &answers {
        let is_right = match (&case.due, fault, unjudged) {
            (Named(effects, words), Some(fault), _) => is_told(fault, effects, words),
            (Unjudged(words) | Doubted(words), None, Some(reason)) => reason.contains(words),
            _ => false,
        };
        if !is_right {
            let told = fault.iter().flat_map(|fault| {
                let rivals = fault.rivals.iter().map(|rival| format!("{}: {}", rival.kind.name(), rival.says));
                [format!("{}: {}", fault.kind.name(), fault.says)].into_iter().chain(rivals)
            });
            return format!("told as {:?} {unjudged:?}", told.collect::<Vec<_>>());
        }
    }
    String::new()
}

#[test]
fn every_mistake_is_named_or_refused_and_nothing_is_claimed() {
    assert!(CASES.len() >= 40);
    // the verbs in turn; FIVEAXIS_MISTAKES=both for both, which takes twice as long
    let both = std::env::var("FIVEAXIS_MISTAKES").is_ok_and(|wanted| wanted == "both");
    let verb = |k: usize| match (both, k % 2) {
        (true, _) => Verb::Both,
        (false, 0) => Verb::Identify,
        (false, _) => Verb::Diagnose,
    };
    let wrong: Vec<String> = CASES
        .par_iter()
        .enumerate()
        .filter_map(|(k, case)| {
            let wrong = wrong(case, verb(k));
            (!wrong.is_empty()).then(|| format!("{}: {wrong}", case.name))
        })
        .collect();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), CASES.len(), wrong.join("\n"));
}

#[test]
fn an_inclined_axis_that_is_inclined_the_other_way_is_named() {
    let inclined = |direction: &str| {
        changed(MACHINE, "A: {origin: [0, 0, 0],", &format!("A: {{origin: [0, 0, 0], direction: {direction},"))
    };
    // an arc about a line that is inclined has one length where the spindle ball stands on the line
    let on_the_line = |text: String| -> String {
        text.split("  - name: ").filter(|test| !test.starts_with("a-far")).collect::<Vec<_>>().join("  - name: ")
    };
    let mut files = recorded_by(&inclined("[0, 1, -1]"), on_the_line, 21, 1.0);
    files.insert("machine.yaml".into(), inclined("[0, 1, 1]"));
    let folder = tempfile::tempdir().unwrap();
    written(&files, folder.path());
    let session = load_session(&folder.path().join("session.yaml")).unwrap();
    let examination = examine(&session, &Options::default()).unwrap();
    let fault = examination.fault.unwrap_or_else(|| panic!("{:?}", examination.unjudged));
    assert!(is_told(&fault, &["axis-direction"], "A turns about [0, 1, -1]"), "{} {:?}", fault.says, fault.rivals);
}

#[test]
fn deviations_stated_per_100_mm_of_bar_are_told_where_bars_differ() {
    let sound = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/gallery/07-nothing-wrong");
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&sound).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "yaml") {
            std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    let session = load_session(&sound.join("session.yaml")).unwrap();
    for test in &session.tests {
        let (name, bar_mm) = (format!("{}.csv", test.name), test.bar_length_mm.unwrap());
        let text = std::fs::read_to_string(sound.join(&name)).unwrap();
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        for line in &mut lines[1..] {
            let (before, length) = line.rsplit_once(',').unwrap();
            // a row without a reading stays one
            if let Ok(length_mm) = length.parse::<f64>() {
                *line = format!("{before},{:.7}", bar_mm + 100.0 / bar_mm * (length_mm - bar_mm));
            }
        }
        std::fs::write(folder.path().join(name), lines.join("\n")).unwrap();
    }
    let found = diagnose(&load_session(&folder.path().join("session.yaml")).unwrap(), &Options::default()).unwrap();
    let fault = found.data_fault.expect("fault");
    assert!(is_told(&fault, &["unit"], "stated per 100 mm of bar"), "{} {:?}", fault.says, fault.rivals);
}

#[test]
fn the_session_without_a_mistake_is_clean_and_determined() {
    let folder = tempfile::tempdir().unwrap();
    written(sound(), folder.path());
    let session = load_session(&folder.path().join("session.yaml")).unwrap();
    let examination = examine(&session, &Options::default()).unwrap();
    assert_eq!((&examination.fault, &examination.unjudged), (&None, &None));
    assert!(examination.warnings.is_empty(), "{:?}", examination.warnings);
    assert!(examination.fit.unwrap().estimates.iter().take(8).all(|estimate| estimate.determined));
    let diagnosis = diagnose(&session, &Options::default()).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::Clean);
}

#[test]
fn readings_that_change_fast_have_all_their_digits() {
    let beside = |text: String| {
        let parts = text.split("  - name: ").map(|part| match part.starts_with("a-short") {
            true => changed(
                part,
                "spindle_ball: {link: Z, at: [0, 0, 0]",
                "spindle_ball: {link: Z, at: [0, 0, 0.9], setup: second",
            ),
            false => part.to_string(),
        });
        parts.collect::<Vec<String>>().join("  - name: ")
    };
    let files = recorded_by(MACHINE, beside, 20, 1.0);
    let folder = tempfile::tempdir().unwrap();
    written(&files, folder.path());
    let session = load_session(&folder.path().join("session.yaml")).unwrap();
    let lengths =
        &session.tests.iter().find(|test| test.name == "a-short-ccw").unwrap().recording.as_ref().unwrap().length_mm;
    let slowest = lengths.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(f64::INFINITY, f64::min);
    println!("the slowest change of a-short-ccw is {:.1} µm per row", 1e3 * slowest);
    assert!(examine(&session, &Options::default()).unwrap().fault.is_none());
}

#[test]
fn a_coarse_gauge_may_repeat_its_readings() {
    let longest = |files: &Files| {
        let mut longest = 0;
        edit_rows(&mut files.clone(), "", |rows| {
            let runs = rows.chunk_by(|one, next| one[2] == next[2]).map(<[_]>::len);
            longest = runs.fold(longest, usize::max);
        });
        longest
    };
    // steps in which many readings in a row are equal
    let coarse = [0.5e-3, 0.7e-3, 1e-3, 1.4e-3, 2e-3].into_iter().find_map(|step: f64| {
        let mut files = sound().clone();
        edit_lengths(&mut files, "", |_, length| (length / step).round() * step);
        (longest(&files) >= 13).then_some(files)
    });
    let folder = tempfile::tempdir().unwrap();
    written(&coarse.unwrap(), folder.path());
    let session = load_session(&folder.path().join("session.yaml")).unwrap();
    assert_eq!(examine(&session, &Options::default()).unwrap().fault, None);
}

#[test]
fn computed_lengths_may_repeat_each_other() {
    // without noise the repeats of a test are equal row by row, and no copies
    let folder = tempfile::tempdir().unwrap();
    let again = session_text(true).split_once("tests:\n").unwrap().1.replace("- name: ", "- name: again-");
    let truth = ERRORS.iter().fold(MACHINE.to_string(), |text, (from, to)| changed(&text, from, to));
    std::fs::write(folder.path().join("machine.yaml"), truth).unwrap();
    std::fs::write(folder.path().join("session.yaml"), session_text(true) + &again).unwrap();
    let mut session = load_session(&folder.path().join("session.yaml")).unwrap();
    let traces = simulate(&session, Composition::Exact).unwrap();
    for (test, trace) in session.tests.iter().zip(&traces) {
        let csv = path_csv(&session.machine, test, &trace.motion, &trace.length_mm, LengthColumn::LengthMm);
        std::fs::write(folder.path().join(format!("{}.csv", test.name)), csv).unwrap();
    }
    let mut text = session_text(false);
    text += &session_text(false)
        .split_once("tests:\n")
        .unwrap()
        .1
        .replace("- name: ", "- name: again-")
        .replace("recording: ", "recording: again-");
    let text =
        text.lines().filter(|line| !line.contains("started_at")).map(|line| format!("{line}\n")).collect::<String>();
    std::fs::write(folder.path().join("session.yaml"), text).unwrap();
    session = load_session(&folder.path().join("session.yaml")).unwrap();
    let examination = examine(&session, &Options::default()).unwrap();
    assert_eq!((examination.fault, examination.unjudged), (None, None));
}

/// Standard output of the program, and its exit code.
fn fiveaxis(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn tests_that_do_not_say_when_they_ran_are_taken_one_after_the_other() {
    let mut files = sound().clone();
    let text = files.get_mut("session.yaml").unwrap();
    *text = text.lines().filter(|line| !line.contains("started_at")).map(|line| format!("{line}\n")).collect();
    let folder = tempfile::tempdir().unwrap();
    written(&files, folder.path());
    let file = folder.path().join("session.yaml");
    let saved = folder.path().join("saved");
    let (code, json, error) =
        fiveaxis(&["diagnose", file.to_str().unwrap(), "--json", "--save", saved.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{error}");
    let json: Value = serde_json::from_str(&json).unwrap();
    assert!(json["warnings"].to_string().contains("one after the other"), "{}", json["warnings"]);
    assert_eq!(json["verdict"], "clean");
    // what is saved has these times
    let saved = load_session(&saved.join("session.yaml")).unwrap();
    let begins: Vec<f64> = saved.tests.iter().map(|test| test.started_at_s).collect();
    let ends = saved.tests.iter().map(|test| {
        let time = test.recording.as_ref().unwrap().time_s().unwrap();
        test.started_at_s + time.last().unwrap()
    });
    assert!(begins.iter().skip(1).zip(ends).all(|(begin, end)| (begin - end).abs() < 1e-6), "{begins:?}");
}

#[test]
fn a_column_in_radians_is_named_where_the_session_states_the_axis_in_degrees() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let folder_of_plan = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/captures");
    let planned = folder_of_plan.join("session.yaml");
    let words = ["--instrument", "default", "--draw-setups", "--seed", "3", "--out"];
    let (code, ..) =
        fiveaxis(&[&["simulate", planned.to_str().unwrap()], &words[..], &[out.to_str().unwrap()]].concat());
    assert_eq!(code, Some(0));
    for name in ["session.yaml", "machine.yaml"] {
        std::fs::copy(folder_of_plan.join(name), out.join(name)).unwrap();
    }
    // a test of C holds A at -90 degrees, by the session
    for name in ["a-100-1-ccw", "a-100-1-cw", "a-100-2-ccw", "a-100-2-cw"] {
        let file = out.join(format!("{name}.csv"));
        let text = std::fs::read_to_string(&file).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        let column = header.split(',').position(|title| title == "A_deg").unwrap();
        let in_radians = |row: &str| {
            let mut fields: Vec<String> = row.split(',').map(String::from).collect();
            fields[column] = format!("{:.9}", fields[column].parse::<f64>().unwrap().to_radians());
            fields.join(",") + "\n"
        };
        std::fs::write(&file, format!("{header}\n{}", rows.lines().map(in_radians).collect::<String>())).unwrap();
    }
    let session = load_session(&out.join("session.yaml")).unwrap();
    let examination = examine(&session, &Options::default()).unwrap();
    let fault = examination.fault.unwrap_or_else(|| panic!("{:?}", examination.unjudged));
    assert!(is_told(&fault, &["unit"], "A is in radians"), "{} {:?}", fault.says, fault.rivals);
}

#[test]
fn the_program_says_so_in_text_and_json_and_saves_nothing() {
    for (name, verdict) in [
        ("pivot 2 mm off", "data fault"),
        ("one recording copied over its repeat", "data fault"),
        ("1 mm of noise", "cannot be judged"),
    ] {
        let case = CASES.iter().find(|case| case.name == name).unwrap();
        let mut files = sound().clone();
        (case.make)(&mut files);
        let folder = tempfile::tempdir().unwrap();
        written(&files, folder.path());
        let session = folder.path().join("session.yaml");
        let session = session.to_str().unwrap();
        let (code, text, error) = fiveaxis(&["identify", session]);
        assert_eq!((code, error.as_str()), (Some(3), ""), "{name}");
        assert!(text.contains("NOT determined") && !text.contains(" determined, relative"), "{name}: {text}");
        assert!(!text.contains("For the control"), "{name}: {text}");
        let (_, text, _) = fiveaxis(&["diagnose", session]);
        let heading = if verdict == "data fault" { "DATA FAULT" } else { "THESE READINGS CANNOT BE JUDGED" };
        assert!(text.contains(heading) && text.contains("left out as gross outliers"), "{name}: {text}");
        for verb in ["identify", "diagnose"] {
            let (_, json, _) = fiveaxis(&[verb, session, "--json"]);
            let json: Value = serde_json::from_str(&json).unwrap();
            assert_eq!(json["verdict"], verdict, "{name}: {json}");
            let figures = if verb == "identify" { &json } else { &json["fit"] };
            assert!(figures["left_out_share"].is_number(), "{name}: {json}");
            let saved = folder.path().join("saved");
            let (code, _, error) = fiveaxis(&[verb, session, "--save", saved.to_str().unwrap()]);
            assert_eq!(code, Some(3), "{name}");
            assert!(error.contains("nothing is saved") && !saved.exists(), "{name}: {error}");
        }
        let (code, _, error) = fiveaxis(&["identify", session, "--method", "chapter5"]);
        assert!(code == Some(3) && error.contains("not to be believed"), "{name}: {error}");
    }
}

#[test]
fn diagnose_repeats_every_warning_of_identify() {
    let mut files = sound().clone();
    // five spreads, which a careless hand may leave
    edit(&mut files, "session.yaml", PIVOT, "pivot: {link: C, at: [0, 100.1, 0]}");
    let folder = tempfile::tempdir().unwrap();
    written(&files, folder.path());
    let session = folder.path().join("session.yaml");
    let told = |verb: &str| -> Vec<Value> {
        let (_, json, _) = fiveaxis(&[verb, session.to_str().unwrap(), "--json"]);
        let json: Value = serde_json::from_str(&json).unwrap();
        let warnings = json["warnings"].as_array().unwrap().iter().cloned();
        warnings.chain([json["reason"].clone()]).filter(|says| !says.is_null()).collect()
    };
    let warned = told("identify");
    assert!(warned[0].as_str().is_some_and(|says| says.contains("times its spread")), "{warned:?}");
    assert_eq!(told("diagnose"), warned);
    let (_, text, _) = fiveaxis(&["diagnose", session.to_str().unwrap()]);
    assert!(text.contains("times its spread"), "{text}");
}

#[test]
fn deviations_in_inches_are_told_by_a_noise_that_no_gauge_has() {
    let mut files = sound().clone();
    edit_rows(&mut files, "", |rows| rows.iter_mut().for_each(|row| row[2] = 1e3 * (row[2] - row[2].round()) / 25.4));
    let csv = files.iter_mut().filter(|(name, _)| name.ends_with(".csv"));
    csv.for_each(|(_, text)| *text = changed(text, "length_mm", "deviation_um"));
    let folder = tempfile::tempdir().unwrap();
    written(&files, folder.path());
    let session = load_session(&folder.path().join("session.yaml")).unwrap();
    let fault = examine(&session, &Options::default()).unwrap().fault.unwrap();
    assert!(is_told(&fault, &["unit"], "where gauges resolve 0.1 µm: they are in inches"), "{}", fault.says);
    assert_eq!(diagnose(&session, &Options::default()).unwrap().verdict, Verdict::DataFault);
}

#[test]
fn a_location_error_that_no_machine_has_is_warned_of() {
    let warned = |files: &Files| {
        let folder = tempfile::tempdir().unwrap();
        written(files, folder.path());
        let session = load_session(&folder.path().join("session.yaml")).unwrap();
        let warnings = examine(&session, &Options::default()).unwrap().warnings;
        warnings.iter().any(|warning| warning.contains("EX0C of") && warning.contains("more than machines in use have"))
    };
    assert!(!warned(sound()));
    let mut files = sound().clone();
    edit(&mut files, "machine.yaml", "C: {origin: [0, 0, 0]", "C: {origin: [1, 0, 0]");
    assert!(warned(&files));
}
