//! The sense of axes: words against points that the machine moves, what is refused without it, what recordings tell of it.

use crate::shipped;
use std::path::Path;
use std::process::Command;

use fiveaxis::chain::{Chain, Composition, Geometry, sense_in_words};
use fiveaxis::identify::{Options, TurnedSense, identify, turned_senses};
use fiveaxis::load::{load_machine, load_session, machine_from_yaml};
use fiveaxis::machine::{Directions, Machine, SpindleSide};
use fiveaxis::session::{Marks, Session};
use fiveaxis::simulate::simulate;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn machine(yaml: &str) -> Machine {
    machine_from_yaml(Path::new("machine.yaml"), yaml.into()).unwrap()
}

/// Every axis with all axes at zero, the tool along −z.
fn words(machine: &Machine) -> Vec<String> {
    let zero = vec![0.0; machine.axes.len()];
    (0..machine.axes.len()).map(|axis| sense_in_words(machine, axis, &zero)).collect()
}

fn check(yaml: &str, expected: &[&str]) {
    assert_eq!(words(&machine(yaml)), expected, "{yaml}");
}

#[test]
fn tables_heads_and_inclined_axes_in_words() {
    let code = |code: &str, more: &str| format!("name: m\ncode: \"{code}\"\ndirections: iso841\n{more}axes: {{}}\n");
    check(
        &code("[wCAbYXZt]", ""),
        &[
            "C+: the table turns clockwise seen from above",
            "A+ lifts the front edge of the table",
            "Y+: the spindle goes to the back",
            "X+: the spindle goes right",
            "Z+: the spindle goes up",
        ],
    );
    check(
        &code("[wCAbYXZt]", "").replace("iso841", "carried"),
        &[
            "C+: the table turns counter-clockwise seen from above",
            "A+ lifts the back edge of the table",
            "Y+: the spindle goes to the back",
            "X+: the spindle goes right",
            "Z+: the spindle goes up",
        ],
    );
    check(
        &code("[wXYbZCBt]", ""),
        &[
            "X+: the table goes left",
            "Y+: the table goes to the front",
            "Z+: the spindle goes up",
            "C+: the spindle head turns counter-clockwise seen from above",
            "B+: the spindle nose swings left",
        ],
    );
    check(
        &code("[wCBbXYZAt]", ""),
        &[
            "C+: the table turns clockwise seen from above",
            "B+ lifts the right edge of the table",
            "X+: the spindle goes right",
            "Y+: the spindle goes to the back",
            "Z+: the spindle goes up",
            "A+: the spindle nose swings to the back",
        ],
    );
    // a nutating table and head at 45°, and a slide at 45°
    check(
        "name: m\ncode: \"[wCBbXYZAt]\"\ndirections: iso841\naxes: {B: {direction: [0, 1, 1]}, A: {direction: [1, 0, 1]}, X: {direction: [1, 0, -1]}}\n",
        &[
            "C+: the table turns clockwise seen from above",
            "B+ lifts the right edge of the table and turns it clockwise seen from above",
            "X+: the spindle goes right and down",
            "Y+: the spindle goes to the back",
            "Z+: the spindle goes up",
            "A+: the spindle nose swings to the back",
        ],
    );
    // reversed flips one axis beside the file's sense; gravity along -y puts the operator in front of the spindle
    check(
        "name: m\ncode: \"[wBZbXYAt]\"\ndirections: iso841\ngravity: [0, -1, 0]\naxes: {X: {reversed: true}}\n",
        &[
            "B+: the table turns clockwise seen from above",
            "Z+: the table goes to the back",
            "X+: the spindle goes left",
            "Y+: the spindle goes up",
            "A+: the spindle nose swings up",
        ],
    );
}

#[test]
fn an_axis_is_told_as_it_stands() {
    let trunnion = machine("name: m\ncode: \"[wCAbYXZt]\"\ndirections: iso841\naxes: {}\n");
    let at = [0.0, 90f64.to_radians(), 0.0, 0.0, 0.0];
    // A at +90 lifts the front edge: the table looks to the back, and the operator sees C turn behind it
    let seen = sense_in_words(&trunnion, 0, &at);
    assert_eq!(seen, "C+ lifts the right edge of the table");
    assert_eq!(sense_in_words(&trunnion, 1, &at), "A+ lifts the front edge of the table");
}

/// A unit vector in R of a word of the operator's, who looks along +y with x to the right and z up.
fn way(word: &str) -> Vector3<f64> {
    match word {
        "right" => Vector3::x(),
        "left" => -Vector3::x(),
        "to the back" | "back" => Vector3::y(),
        "to the front" | "front" => -Vector3::y(),
        "up" | "above" => Vector3::z(),
        "down" => -Vector3::z(),
        other => panic!("no direction: {other}"),
    }
}

/// The words after `before`, up to `end`, as one direction.
fn sum(words: &str, before: &str, end: &str, between: &str) -> Option<Vector3<f64>> {
    let rest = words.split_once(before)?.1;
    let rest = rest.split_once(end).map_or(rest, |(rest, _)| rest);
    Some(rest.split(between).map(way).sum())
}

/// Every word of a sense must agree with where points go that the axis carries, by differences of their places.
fn agrees(machine: &Machine, axis: usize, words: &str) {
    const SMALL: f64 = 1e-4;
    // words name whole directions and pairs and triples of them: parts from sin 15° on may be named, so that three words
    // may lie 34° off the motion, two 30°
    let near =
        |way: Vector3<f64>, named: Vector3<f64>| way.normalize().dot(&named.normalize()) > 34f64.to_radians().cos();
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let link = chain.carried_by(axis);
    let zero = vec![0.0; chain.axis_count()];
    let mut moved = zero.clone();
    moved[axis] = SMALL;
    let goes =
        |at: Vector3<f64>| (geometry.point(link, &at, &moved, None) - geometry.point(link, &at, &zero, None)) / SMALL;
    let mut checked = 0;
    if let Some(named) = sum(words, " goes ", "\n", " and ") {
        let way = goes(Vector3::new(3.0, 4.0, 5.0));
        assert!(near(way, named), "{words}: {way}");
        checked += 1;
    }
    if let Some(edge) = sum(words, " lifts the ", " edge", " ") {
        // edges of a table about R's origin, one against the other: a table off the axis may rise as a whole
        let e = edge.normalize() * 100.0;
        let tilts = |e: Vector3<f64>| goes(e).z - goes(-e).z;
        assert!(tilts(e) > 0.0, "{words}");
        let across = Vector3::new(-e.y, e.x, 0.0);
        assert!(tilts(across).abs() < 0.58 * tilts(e), "{words}: another edge rises as much");
        checked += 1;
    }
    if let Some(nose) = sum(words, " nose swings ", "\n", " and ") {
        let swing = goes(Vector3::zeros()) - goes(Vector3::new(0.0, 0.0, 100.0));
        assert!(near(swing, nose), "{words}: {swing}");
        checked += 1;
    }
    if let Some((how, from)) = words.split_once(" seen from ") {
        let eye = way(from.trim_start_matches("the "));
        // a point a quarter turn on: right of an upright line as the eye sees it
        let arm = if eye.x.abs() > 0.5 { Vector3::y() } else { Vector3::x() };
        let turn = (arm * 100.0).cross(&(goes(arm * 100.0) - goes(Vector3::zeros()))).dot(&eye);
        assert_eq!(turn > 0.0, how.ends_with("counter-clockwise"), "{words}: {turn}");
        checked += 1;
    }
    assert!(checked > 0, "{words}");
}

#[test]
fn words_agree_with_where_points_go() {
    const SEED: u64 = 841;
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    println!("seed {SEED}");
    let mut machines: Vec<Machine> = shipped::machine_files().iter().map(|file| load_machine(file).unwrap()).collect();
    for machine in &machines {
        assert_eq!(machine.directions, Some(Directions::Iso841), "{}", machine.name);
    }
    // only the words for who looks along +y are read back here
    machines.retain(|machine| machine.gravity == -Vector3::z());
    for round in 0..300 {
        let mut machine = machines[round % 10].clone();
        machine.directions = [None, Some(Directions::Carried), Some(Directions::Iso841)][random.random_range(0..3)];
        for axis in &mut machine.axes {
            axis.reversed = random.random_bool(0.3);
            axis.direction = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0)).normalize();
            axis.origin = Vector3::from_fn(|_, _| random.random_range(-300.0..300.0));
        }
        machines.push(machine);
    }
    let mut seen = 0;
    let upright = SpindleSide { link: "t".into(), nose: Vector3::z(), direction: Vector3::z(), gauge_length_mm: 1.0 };
    for machine in &machines {
        let zero = vec![0.0; machine.axes.len()];
        for spindle in [Some(upright.clone()), None] {
            let machine = Machine { spindle, ..machine.clone() };
            for axis in 0..machine.axes.len() {
                agrees(&machine, axis, &sense_in_words(&machine, axis, &zero));
                seen += 1;
            }
        }
    }
    assert!(seen > 3000, "{seen}");
}

fn chapter5() -> Session {
    load_session(&Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis/chapter5/session.yaml")).unwrap()
}

fn sense_of<'a>(session: &Session, senses: &'a [TurnedSense], name: &str) -> &'a TurnedSense {
    senses.iter().find(|sense| sense.named(&session.machine) == name).unwrap()
}

#[test]
fn chapter_5_cannot_tell_the_sense_of_its_axes() {
    let session = chapter5();
    let fit = identify(&session, &Options::default()).unwrap();
    let senses = turned_senses(&session, &fit).unwrap();
    let a = sense_of(&session, &senses, "A");
    assert!(!a.is_told() && !a.looks_wrong(), "{}", a.worse_by);
    // the whole fit again with the sense turned
    let mut other = session.clone();
    let axis = other.machine.axis_index("A").unwrap();
    other.machine.axes[axis].reversed = true;
    let turned = identify(&other, &Options::default()).unwrap();
    for moved in &a.moved {
        let k = moved.unknown;
        assert_eq!(moved.stated, fit.estimates[k].value);
        let off = (turned.estimates[k].value - moved.turned).abs() / turned.estimates[k].sigma;
        assert!(off < 0.1, "{}: {off} sigma", fit.unknowns[k].label);
    }
    let names: Vec<&str> = a.moved.iter().map(|moved| fit.unknowns[moved.unknown].label.as_str()).collect();
    // EB0A, -1.29 arcsec in this session, is too small to move EB0C with it
    assert!(names.contains(&"EZ0A"), "{names:?}");
    // the bar of the proposed test fits on with the sense as stated and not with the other
    let test = a.test.as_ref().unwrap();
    let bar_mm = session.tests[test.test].bar_length_mm.unwrap();
    assert!((test.stated_mm - bar_mm).abs() < 1e-6 && (test.turned_mm - bar_mm).abs() > 5.0, "{test:?}");
}

#[test]
fn a_design_that_is_its_own_mirror_image_leaves_senses_open_together() {
    // C carries B on a fork; all balls lie in the plane y = 0, which the mirror across y leaves where it is
    let folder = tempfile::tempdir().unwrap();
    let machine = "name: fork\ncode: \"[wbXYZCBt]\"\ndirections: iso841\naxes:\n  X: {range: [-500, 500]}\n  Y: {range: [-500, 500]}\n  \
                   Z: {range: [-300, 300]}\n  C: {origin: [0, 0, 0]}\n  B: {origin: [0, 0, 300]}\n";
    std::fs::write(folder.path().join("machine.yaml"), machine).unwrap();
    let mut text = String::from("machine: machine.yaml\ntests:\n");
    for (name, follow, c, from, to) in [
        ("axial", "axial", 0, -37, 37),
        ("tangential", "tangential", 0, -50, 14),
        ("tangential-aside", "tangential", 90, -50, 14),
        ("axial-aside", "axial", 90, -37, 37),
    ] {
        text += &format!(
            "  - {{name: {name}, bar_length: 100, pivot: {{link: b, at: [0, 0, -15]}}, spindle_ball: {{link: t, at: [0, 0, -100]}}, positions: {{C: {c}}}, feed: 500, sweep: {{axis: B, from: {from}, to: {to}, step: 1, follow: {follow}}}}}\n"
        );
    }
    std::fs::write(folder.path().join("session.yaml"), text).unwrap();
    let planned = load_session(&folder.path().join("session.yaml")).unwrap();
    let mut real = planned.clone();
    let axis = |name: &str| planned.machine.axis_index(name).unwrap();
    real.machine.axes[axis("C")].location_errors[3] = 1e-4;
    real.machine.axes[axis("B")].location_errors[0] = 0.03;
    real.machine.axes[axis("B")].location_errors[5] = 8e-5;
    let traces = simulate(&real, Composition::Exact).unwrap();
    let recorded = crate::recorded::recorded(&planned, &traces);
    let fit = identify(&recorded, &Options::default()).unwrap();
    let senses = turned_senses(&recorded, &fit).unwrap();
    for alone in ["Y", "C"] {
        assert!(sense_of(&recorded, &senses, alone).is_told(), "{alone}");
    }
    let together = sense_of(&recorded, &senses, "Y and C");
    assert!(!together.is_told() && !together.looks_wrong() && !together.moved.is_empty(), "{together:?}");
    // a look at the axes tells them: both are named
    let look = together.how_to_tell(&recorded);
    assert!(look.contains("move each of Y and C a little in +"), "{look}");
    // with both turned the whole fit is as good, and errors have other signs
    let mut mirrored = recorded.clone();
    together.axes.iter().for_each(|&axis| mirrored.machine.axes[axis].reversed ^= true);
    let other = identify(&mirrored, &Options::default()).unwrap();
    assert!(other.rms_mm < 1.1 * fit.rms_mm + 1e-6, "{} {}", other.rms_mm, fit.rms_mm);
}

#[test]
fn a_pivot_off_the_symmetry_tells_the_sense() {
    // the same tests, and one more sweep of A with the spindle ball 20 mm above the axis
    let mut session = chapter5();
    let z = session.machine.axis_index("Z").unwrap();
    let mut more = session.tests[0].clone();
    more.name = "a-above".into();
    more.positions[z] = Some(20.0);
    session.tests.push(more);
    let noisy = session.clone();
    session.machine.axes[0].location_errors[0] = 0.02;
    let traces = simulate(&session, Composition::Exact).unwrap();
    let mut measured = noisy;
    for (test, trace) in measured.tests.iter_mut().zip(&traces) {
        let recording = test.recording.as_mut().unwrap();
        // a pattern of 1 um stands for noise
        let noise = |row: usize| 1e-3 * if row.is_multiple_of(3) { 1.0 } else { -0.5 };
        recording.length_mm = trace.length_mm.iter().enumerate().map(|(row, mm)| mm + noise(row)).collect();
    }
    let fit = identify(&measured, &Options::default()).unwrap();
    let senses = turned_senses(&measured, &fit).unwrap();
    let a = sense_of(&measured, &senses, "A");
    assert!(a.is_told() && !a.looks_wrong() && a.test.is_none() && a.moved.is_empty(), "{a:?}");
    // C turns a ball about the spindle ball's own line still: its mirror image fits as well
    assert!(!sense_of(&measured, &senses, "C").is_told());
}

#[test]
fn marks_that_a_capture_shows_tell_the_sense() {
    let mut session = chapter5();
    let seen = |session: &Session| {
        let fit = identify(session, &Options::default()).unwrap();
        let senses = turned_senses(session, &fit).unwrap();
        sense_of(session, &senses, "A").clone()
    };
    assert_eq!(seen(&session).by_marks, 0.0);
    // the pivot 100 mm from A's line, on which the spindle ball stands: the bar turns with A, and stands 2° outside the arc
    let bars_deg = {
        let angles = &session.tests[0].recording.as_ref().unwrap().positions[0];
        [angles[0].to_degrees() - 2.0, angles[angles.len() - 1].to_degrees() + 2.0]
    };
    let [near_mm, far_mm] = bars_deg.map(|deg| 0.4 * (1.0 - (2.0 * deg).to_radians().cos()));
    let with = |session: &mut Session, seen_mm: [f64; 2]| {
        let marks =
            Marks { move_mm: 0.4, feed_mm_per_min: 60.0, hold_s: 0.6, rest_s: 0.5, gap_s: 1.0, seen_mm: Some(seen_mm) };
        session.tests[0].marks = Some(marks);
    };
    assert_eq!(session.tests[0].overshoot, Some(2.0));
    with(&mut session, [0.4, 0.4]);
    let told = seen(&session);
    // the mark after the arc, at 72°, speaks louder than the one before it, at -22°
    assert!(near_mm > 0.1 && far_mm > near_mm, "{near_mm} {far_mm}");
    assert!((told.by_marks / (far_mm / 0.02).powi(2) - 1.0).abs() < 2e-3, "{} {far_mm}", told.by_marks);
    assert!(told.is_told() && !told.looks_wrong() && told.moved.is_empty() && told.test.is_none());
    // had A gone the other way, the bar would have got longer by less, or shorter
    with(&mut session, [0.4 - near_mm, 0.4 - far_mm]);
    let turned = seen(&session);
    assert!((turned.by_marks + told.by_marks).abs() < 4e-3 * told.by_marks, "{}", turned.by_marks);
    assert!(turned.looks_wrong());
}

/// Exit code, standard output and standard error.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

const UNSTATED: &str = "the machine file does not say which way its axes go: write 'directions: iso841' (a positive command \
moves the tool in the positive sense relative to the workpiece, as most controls do) or 'directions: carried' (it moves the \
carried part right-handed) under its name, or give --directions; `check` says in words what each sense means";

#[test]
fn nothing_leaves_for_a_machine_without_a_stated_sense() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mill = std::fs::read_to_string(format!("{}/machines/hermle-c600u.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let silent = mill.replacen("directions: iso841\n", "", 1);
    assert_ne!(silent, mill);
    std::fs::write(folder.join("silent.yaml"), &silent).unwrap();
    std::fs::write(folder.join("mill.yaml"), &mill).unwrap();
    let (code, out, err) = run(folder, &["plan", "silent.yaml", "--out", "plan"]);
    assert_eq!((code, out.as_str(), err), (Some(2), "", format!("fiveaxis: silent.yaml: {UNSTATED}\n")));
    assert!(!folder.join("plan").exists());
    let (code, out, err) = run(folder, &["plan", "mill.yaml", "--directions", "carried", "--out", "plan"]);
    let differ = "fiveaxis: mill.yaml: the machine file states directions: iso841, the option says carried; keep one, after a look at the machine: `check` says in words what each sense means\n";
    assert_eq!((code, out.as_str(), err.as_str()), (Some(2), "", differ));
    // said by the option, the sense stands in the plan's own machine file and in its programs
    let option = ["plan", "silent.yaml", "--method", "chapter5", "--directions", "iso841", "--out", "plan"];
    let (code, _, err) = run(folder, &option);
    assert_eq!(code, Some(0), "{err}");
    assert_eq!(load_machine(&folder.join("plan/machine.yaml")).unwrap().directions, Some(Directions::Iso841));
    let sheet = std::fs::read_to_string(folder.join("plan/setup-sheet.html")).unwrap();
    assert!(
        sheet.contains("iso841: a positive command moves the tool in the positive sense relative to the workpiece")
    );
    let programs = std::fs::read_dir(folder.join("plan/nc/linuxcnc")).unwrap();
    for program in programs {
        let text = std::fs::read_to_string(program.unwrap().path()).unwrap();
        assert!(text.contains("sense of axes: iso841"), "{text}");
    }
    // check says both readings
    let (_, out, _) = run(folder, &["check", "silent.yaml"]);
    assert!(out.contains("NOT stated, read as carried") && out.contains("A+ lifts the back edge of the table"));
    assert!(out.contains("with 'directions: iso841'") && out.contains("A+ lifts the front edge of the table"));
}

#[test]
fn numbers_for_a_control_are_withheld_without_a_stated_sense() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis/chapter5");
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
    }
    let stated = std::fs::read_to_string(folder.join("machine.yaml")).unwrap();
    std::fs::write(folder.join("machine.yaml"), stated.replacen("directions: carried\n", "", 1)).unwrap();
    let json = |arguments: &[&str]| -> serde_json::Value {
        let (code, out, err) = run(folder, arguments);
        assert_eq!(code, Some(0), "{err}");
        serde_json::from_str(&out).unwrap()
    };
    let silent = json(&["identify", "session.yaml", "--json"]);
    assert_eq!(silent["control_withheld"], UNSTATED);
    assert_eq!(silent["control"].as_array().unwrap().len(), 0);
    let said = json(&["identify", "session.yaml", "--directions", "carried", "--json"]);
    assert_eq!(said["control"].as_array().unwrap().len(), 2);
    assert_eq!(said["directions"], "carried");
    assert_eq!(said["location_errors"], silent["location_errors"]);
    let says = said["senses"].as_array().unwrap().iter().find(|sense| sense["axis"] == "A").unwrap()["says"].as_str();
    let says = says.unwrap();
    assert!(
        says.starts_with("these tests cannot tell A's sense: with A reversed they fit as well and give "),
        "{says}"
    );
    assert!(says.contains("move A a little in + and see: A+ lifts the back edge of the table"), "{says}");
}
