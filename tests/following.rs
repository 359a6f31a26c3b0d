//! Planned paths whose linear axes move: the distance that following keeps, circles of slides that are not square, and what cannot be followed.

use std::path::Path;

use assert_cmd::Command;
use fiveaxis::chain::Chain;
use fiveaxis::load::load_session;
use fiveaxis::machine::Machine;
use fiveaxis::session::{Motion, Session};

const MACHINE: &str = "name: mill\ncode: \"[wCAbYXZt]\"\ndirections: iso841\naxes:\n  X: {range: [-300, 300]}\n  \
    Y: {range: [-225, 225]}\n  Z: {range: [-220, 330]}\n  A: {origin: [0, 0, 0], range: [-90, 110]}\n  \
    C: {origin: [0, 0, 0], range: [-360, 360]}\n";

fn session(machine: &str, test: &str) -> Session {
    let folder = tempfile::tempdir().expect("folder");
    let text = format!("name: planned\nmachine: machine.yaml\ntests:\n  - {{name: one, {test}}}\n");
    std::fs::write(folder.path().join("machine.yaml"), machine).expect("written");
    std::fs::write(folder.path().join("session.yaml"), text).expect("written");
    load_session(&folder.path().join("session.yaml")).expect("session")
}

/// Shortest and longest bar along the path of the only test, mm.
fn bars(session: &Session) -> [f64; 2] {
    let chain = Chain::of(&session.machine);
    let geometry = fiveaxis::chain::Geometry::nominal(&chain);
    let test = &session.tests[0];
    let motion = Motion::of(session, &chain, test).expect("path");
    let links = test.links(&chain).expect("links");
    let bars = (0..motion.rows()).map(|row| test.bar(&geometry, links, motion.row(row)).norm());
    bars.fold([f64::INFINITY, 0.0], |[least, most], bar| [least.min(bar), most.max(bar)])
}

fn following(bar: f64, further: &str) -> Session {
    let test = format!(
        "bar_length: {bar}, pivot: {{link: C, at: [0, 60, 0]}}, spindle_ball: {{link: Z, at: [0, 0, 0]}}, positions: {{A: 0}}, \
         sweep: {{axis: C, from: 0, to: 90, step: 5, follow: axial{further}}}"
    );
    session(MACHINE, &test)
}

#[test]
fn the_balls_are_kept_apart_by_what_the_path_states_or_the_bar_in_whole_millimetres() {
    let cases = [(101.6, ", length: 101.6", 101.6), (33.5, ", length: 33.25", 33.25), (99.9881, "", 100.0)];
    for (bar, further, kept) in cases {
        for end in bars(&following(bar, further)) {
            assert!((end - kept).abs() < 1e-6, "{bar}{further}: {end} mm");
        }
    }
}

#[test]
fn a_distance_that_no_bar_reaches_or_nothing_keeps_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let said = |sweep: &str| {
        let test = format!(
            "{{name: one, bar_length: 100, pivot: {{link: C, at: [0, 60, 0]}}, spindle_ball: {{link: Z, at: [0, 0, 0]}}, \
             positions: {{X: 0, Y: 0, Z: 0, A: 0}}, sweep: {sweep}}}"
        );
        let text = format!("name: planned\nmachine: machine.yaml\ntests:\n  - {test}\n");
        std::fs::write(folder.path().join("machine.yaml"), MACHINE).expect("written");
        std::fs::write(folder.path().join("session.yaml"), text).expect("written");
        load_session(&folder.path().join("session.yaml")).map(|_| ()).unwrap_err().to_string()
    };
    assert!(said("{axis: C, from: 0, to: 90, follow: axial, length: 110}").contains("within 5 mm"));
    assert!(said("{axis: C, from: 0, to: 90, follow: axial, length: -100}").contains("above zero"));
    assert!(said("{axis: C, from: 0, to: 90, length: 100}").contains("say 'follow'"));
}

#[test]
fn an_axis_that_carries_neither_ball_is_told_so() {
    let test = "bar_length: 100, pivot: {link: b, at: [0, 60, 0]}, spindle_ball: {link: Z, at: [0, 0, 0]}, positions: {A: 0}, \
        sweep: {axis: C, from: 0, to: 90, step: 5, follow: radial}";
    let session = session(MACHINE, test);
    let chain = Chain::of(&session.machine);
    let why = Motion::of(&session, &chain, &session.tests[0]).unwrap_err().to_string();
    assert!(why.contains("carries neither ball") && !why.contains("NaN"), "{why}");
}

#[test]
fn a_circle_of_slides_that_are_not_square_is_centred_where_the_balls_meet() {
    let machine = MACHINE.replace("Y: {range", "Y: {direction: [0.02, 1, 0], range");
    let test = "bar_length: 100, pivot: {link: C, at: [40, 60, 0]}, spindle_ball: {link: Z, at: [0, 0, 0]}, positions: {Z: 0, A: 0, C: 0}, \
        circle: {plane: XY, radius: 100, from: 0, to: 360, step: 1}";
    let session = session(&machine, test);
    let chain = Chain::of(&session.machine);
    let geometry = fiveaxis::chain::Geometry::nominal(&chain);
    let motion = Motion::of(&session, &chain, &session.tests[0]).expect("path");
    let links = session.tests[0].links(&chain).expect("links");
    let bar = |row: usize| session.tests[0].bar(&geometry, links, motion.row(row)).norm();
    // what lies opposite is as far away, on whatever curve a control runs that takes its slides for square
    for row in 0..180 {
        assert!((bar(row) - bar(row + 180)).abs() < 1e-6, "{row}: {} and {} mm", bar(row), bar(row + 180));
    }
}

#[test]
fn a_plan_for_a_bar_of_no_whole_millimetres_is_the_session_beside_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("folder");
    let kit = std::fs::read_to_string(root.join("kits/ballbar.yaml")).expect("kit");
    std::fs::write(folder.path().join("kit.yaml"), kit.replace("{length: 100,", "{length: 101.6,")).expect("written");
    let run = |arguments: &[&str]| {
        let output =
            Command::cargo_bin("fiveaxis").expect("built").current_dir(root).args(arguments).output().expect("run");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let (kit, plan) = (folder.path().join("kit.yaml"), folder.path().join("plan"));
    let of = |path: &Path| path.to_string_lossy().into_owned();
    run(&["plan", "machines/hermle-c600u.yaml", "--kit", &of(&kit), "--follow", "axial", "--out", &of(&plan)]);
    let session = load_session(&plan.join("session.yaml")).expect("session");
    let machine: &Machine = &session.machine;
    assert!(machine.axes.len() == 5 && !session.tests.is_empty());
    let chain = Chain::of(machine);
    let geometry = fiveaxis::chain::Geometry::nominal(&chain);
    for test in &session.tests {
        let links = test.links(&chain).expect("links");
        let motion = Motion::of(&session, &chain, test).expect("path");
        let bar = test.bar(&geometry, links, motion.row(motion.rows() / 2)).norm();
        assert!((bar - test.bar_length_mm.expect("bar")).abs() < 1e-3, "{}: {bar} mm", test.name);
    }
}
