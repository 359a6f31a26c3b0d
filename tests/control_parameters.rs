//! `fiveaxis control` end to end: signs of parameters, the limit, present values, heads component by component.

use crate::{recorded, shipped};
use std::path::Path;

use assert_cmd::Command;
use fiveaxis::chain::{Chain, Composition, Geometry};
use fiveaxis::control::{Control, What, backlash, held, held_where, left_over, numbers, tables};
use fiveaxis::identify::{Options, axis_lines, identify};
use fiveaxis::inverse::Tool;
use fiveaxis::load::{load_machine_and_bodies, load_session};
use fiveaxis::machine::{AxisKind, ComponentError, ComponentForm, Effect, Outlet, Place, Size};
use fiveaxis::volume::poses;
use nalgebra::Vector3;
use serde_json::Value;

fn run(arguments: &[&str]) -> (Option<i32>, Value) {
    let output = Command::cargo_bin("fiveaxis")
        .expect("built")
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .arg("--json")
        .output()
        .expect("run");
    let text = String::from_utf8(output.stdout).expect("text");
    (output.status.code(), serde_json::from_str(&text).expect("JSON"))
}

const SESSION: &str = "examples/thesis/chapter5/session.yaml";

#[test]
fn parameters_have_the_signs_of_the_page_on_controls() {
    // the fit: C's own shift y −52.9 µm, A's y 36.2 µm and z −34.0 µm
    for (control, name, expected) in [
        ("sinumerik", "$TC_CARR16", -52.9),
        // what closes the chain takes both changes
        ("sinumerik", "$TC_CARR19", 52.9 - 36.2),
        ("sinumerik", "$TC_CARR5", 36.2),
        ("fanuc", "No. 19701", 36.2),
        ("fanuc", "No. 19704", -52.9),
        ("linuxcnc", "xyzac-trt-kins.y-offset", 52.9),
        ("linuxcnc", "xyzac-trt-kins.z-rot-point", -34.0),
        ("linuxcnc", "xyzac-trt-kins.y-rot-point", 36.2 - 52.9),
    ] {
        let (code, value) = run(&["control", SESSION, "--control", control, "--directions", "carried"]);
        assert_eq!(code, Some(0), "{value}");
        let list = value["parameters"].as_array().expect("parameters");
        let found = list.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name} in {list:?}"));
        assert!((found["add_um"].as_f64().expect("change") - expected).abs() < 0.3, "{name}: {found}");
    }
}

#[test]
fn large_changes_are_refused_and_present_values_added() {
    let said = ["control", SESSION, "--control", "fanuc", "--directions", "carried"];
    let (code, value) = run(&[&said[..], &["--limit", "20"]].concat());
    assert_eq!(code, Some(2));
    assert!(value["error"].to_string().contains("more than the limit of 20"), "{value}");
    let (code, _) = run(&[&said[..], &["--limit", "20", "--force"]].concat());
    assert_eq!(code, Some(0));
    let scratch = tempfile::tempdir().expect("folder");
    let file = scratch.path().join("present.txt");
    std::fs::write(&file, "# now\nNo. 19701 = 0.5\n").expect("written");
    let (code, value) = run(&[&said[..], &["--present", file.to_str().expect("text")]].concat());
    assert_eq!(code, Some(0));
    let list = value["parameters"].as_array().expect("parameters");
    let found = list.iter().find(|one| one["name"] == "No. 19701").expect("19701");
    assert!((found["new_mm"].as_f64().expect("value") - 0.5362).abs() < 3e-4, "{found}");
    std::fs::write(&file, "No. 19701 is 0.5\n").expect("written");
    let (code, value) = run(&[&said[..], &["--present", file.to_str().expect("text")]].concat());
    assert_eq!(code, Some(2));
    assert!(value["error"].to_string().contains("name = value"), "{value}");
}

#[test]
fn a_head_tells_its_pivot_length_and_each_component_that_is_determined() {
    let scratch = tempfile::tempdir().expect("folder");
    let machine = "name: head\ncode: \"[wXYbZCAt]\"\ndirections: iso841\naxes:\n  A: {origin: [0, 0, 200]}\n  C: {origin: [0, 0, 0]}\n";
    std::fs::write(scratch.path().join("machine.yaml"), machine).expect("written");
    let mut session = String::from("machine: machine.yaml\nspread: {spindle_ball: 200 um}\ntests:\n");
    for (name, axis, from, to, pivot) in [
        ("a-side", "A", -60, 60, "[0, 100, 0]"),
        ("a-below", "A", -60, 60, "[0, 0, -100]"),
        ("c-side", "C", -170, 170, "[100, 0, 0]"),
    ] {
        let positions = if axis == "A" { "{X: 0, Y: 0, Z: 0, C: 0}" } else { "{X: 0, Y: 0, Z: 0, A: 30}" };
        session += &format!(
            "  - {{name: {name}, bar_length: 100, pivot: {{link: X, at: {pivot}}}, spindle_ball: {{link: t, at: [0, 0, 0]}}, positions: {positions}, feed: 500, sweep: {{axis: {axis}, from: {from}, to: {to}, step: 1}}}}\n"
        );
    }
    let file = scratch.path().join("session.yaml");
    std::fs::write(&file, session).expect("written");
    let planned = load_session(Path::new(&file)).expect("session");
    // the spindle ball hangs 60 µm lower than stated: a longer pivot
    let mut real = planned.clone();
    real.tests.iter_mut().for_each(|test| test.spindle_ball.at.z -= 0.06);
    let mut traces = fiveaxis::simulate::simulate(&real, Composition::Exact).expect("traces");
    for (trace, own) in
        traces.iter_mut().zip(fiveaxis::simulate::simulate(&planned, Composition::Exact).expect("traces"))
    {
        trace.motion = own.motion;
    }
    let recorded = recorded::recorded(&planned, &traces);
    let fit = identify(&recorded, &Options::default()).expect("fit");
    let lines = axis_lines(&recorded, &fit);
    let list = numbers(&recorded, &fit, &lines);
    let pivot: Vec<_> = list.iter().filter(|number| number.what == What::Pivot).collect();
    let z = pivot.iter().find(|number| number.component == 2).expect("pivot z");
    println!("pivot z {:.2} ± {:.2} µm, determined {}", 1e3 * z.change, 1e3 * z.sigma, z.determined);
    assert!(z.determined && (z.change + 0.06).abs() < 4.0 * z.sigma.max(1e-4), "{z:?}");
    assert!(list.iter().any(|number| matches!(number.what, What::Vector { .. })));
}

/// A session of the gallery as `diagnose` saves it.
fn saved(session: &str, folder: &Path) -> String {
    let (code, value) = run(&["diagnose", session, "--save", folder.to_str().expect("text")]);
    assert_eq!(code, Some(0), "{value}");
    folder.join("session.yaml").to_str().expect("text").to_string()
}

#[test]
fn lost_motion_that_was_found_is_given_as_backlash() {
    let scratch = tempfile::tempdir().expect("folder");
    let session = saved("examples/gallery/03-lost-motion/session.yaml", &scratch.path().join("found"));
    for (control, parameter) in [
        ("fanuc", "No. 1851 of Y"),
        ("sinumerik", "MD32450 $MA_BACKLASH[0] of Y"),
        ("heidenhain", "MP710 (iTNC 530), MP_backLash of Y"),
    ] {
        let out = scratch.path().join(control);
        let (code, value) = run(&["control", &session, "--control", control, "--out", out.to_str().expect("text")]);
        assert_eq!(code, Some(0), "{value}");
        let list = value["backlash"].as_array().expect("backlash");
        assert_eq!(list.len(), 1, "{list:?}");
        assert_eq!(list[0]["parameter"], parameter);
        // 2.4 µm to each side were hidden
        let width = list[0]["add"].as_f64().expect("width");
        assert!((width - 0.0048).abs() < 0.0002, "{width} mm");
        let text = std::fs::read_to_string(out.join("backlash.csv")).expect("file");
        assert_eq!(text.lines().nth(1), Some(format!("Y,\"{parameter}\",{width:.6},mm").as_str()));
        // what is not entered takes nothing away, and nothing that is entered does harm
        let p95 = |key: &str| value[key]["position_p95_um"].as_f64().expect("figure");
        assert!(p95("volume_after") <= p95("volume_now") + 1e-6, "{value}");
    }
}

#[test]
fn tables_hold_what_was_found_over_position_and_reversal() {
    let scratch = tempfile::tempdir().expect("folder");
    let session = saved("examples/gallery/01-worm-gear/session.yaml", &scratch.path().join("found"));
    let out = scratch.path().join("control");
    let folder = out.to_str().expect("text");
    let (code, value) = run(&["control", &session, "--control", "linuxcnc", "--out", folder]);
    assert_eq!(code, Some(0), "{value}");
    // a worm of 96 teeth: its wave is in the table as it is in the machine as found, read between the rows
    let found = load_session(Path::new(&session)).expect("session").machine;
    let c = found.axis_index("C").expect("C");
    let own = found.effects.iter().find(|effect| effect.place.axis() == Some(c)).expect("the worm");
    let part = |name: &str, order: f64| -> f64 {
        let is_it =
            |size: &&fiveaxis::machine::Size| size.function.starts_with(name) && order_of(&size.function) == order;
        own.sizes.iter().filter(is_it).map(|size| size.value * fiveaxis::units::ARCSEC_PER_RAD).sum()
    };
    let orders: Vec<f64> =
        own.sizes.iter().filter(|size| size.function.starts_with("cos")).map(|s| order_of(&s.function)).collect();
    let wave = |deg: f64| -> f64 {
        let each = orders.iter().map(|&order| {
            let (sine, cosine) = (order * deg.to_radians()).sin_cos();
            part("cos", order) * cosine + part("sin", order) * sine
        });
        each.sum()
    };
    let text = std::fs::read_to_string(out.join("ECC.csv")).expect("table");
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().expect("number")).collect()).collect();
    let zero = wave(0.0);
    for pair in rows.windows(2) {
        let middle = 0.5 * (pair[0][0] + pair[1][0]);
        let told = 0.5 * (pair[0][1] + pair[1][1]);
        let off = (told - (wave(middle) - zero)).abs().min((told - wave(middle)).abs());
        assert!(off < 0.4, "at {middle} deg: {told} arcsec for {}", wave(middle));
        assert_eq!(pair[0][1], -pair[0][2]);
    }
    // too fine for the rows of a COMP_FILE: said, and not written
    assert!(!out.join("C.comp").exists());
    assert!(value["not_held"].to_string().contains("ECC waves too fast"), "{}", value["not_held"]);
}

/// The order in the name of a function: 96 of `cos96`.
fn order_of(function: &str) -> f64 {
    function.trim_start_matches(|c: char| c.is_ascii_alphabetic()).parse().unwrap_or(0.0)
}

#[test]
fn an_axis_that_lags_stands_lower_on_its_way_up_whichever_way_it_counts() {
    for machine in ["hermle-c600u", "table-table-ca-moving-table-x"] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("machines/{machine}.yaml"));
        let (mut machine, _) = load_machine_and_bodies(&file).expect("machine");
        let x = machine.axis_index("X").expect("X");
        machine.machine_zero[x] = Some(120.0);
        // which way in R the carried part goes at positive commands
        let chain = Chain::of(&machine);
        let at = |q: f64| {
            let mut positions = vec![0.0; machine.axes.len()];
            positions[x] = q;
            Geometry::nominal(&chain).point(chain.carried_by(x), &Vector3::zeros(), &positions, None)
        };
        let way = (at(1.0) - at(0.0)).x.signum();
        // it lags in the sense in which it carries its part
        let outlet = Outlet::own(&machine, x);
        let size = Size { outlet, function: String::new(), value: 2e-3 };
        machine.effects.push(Effect { sizes: vec![size], ..Effect::new("linear-backlash", Place::Axis(x)) });
        let component = machine.axes[x].own_component();
        machine.axes[x]
            .component_errors
            .push(ComponentError { component, form: ComponentForm::Polynomial(vec![40e-6 * way]) });
        let lost = backlash(Control::LinuxCnc, &machine);
        assert!((lost[0].width - 4e-3).abs() < 1e-12, "{lost:?}");
        let table = tables(&machine).into_iter().find(|table| table.error == "EXX").expect("a table");
        let text = table.linuxcnc(&machine).expect("a file");
        for line in text.lines() {
            let cells: Vec<f64> = line.split(' ').map(|cell| cell.parse().expect("number")).collect();
            let zero = machine.machine_zero[x].unwrap_or(0.0);
            let actual = (cells[0] - zero) * (1.0 + 40e-6) + zero;
            assert!((cells[1] - (actual - 2e-3)).abs() < 2e-6 && (cells[2] - (actual + 2e-3)).abs() < 2e-6, "{line}");
        }
    }
}

#[test]
fn a_control_that_holds_all_places_leaves_nothing_of_them() {
    let mut seen = 0;
    for file in shipped::machine_files() {
        let (mut machine, bodies) = load_machine_and_bodies(&file).expect("machine");
        let Some(tool) = Tool::of(&machine, &bodies, None) else { continue };
        for axis in &mut machine.axes {
            axis.location_errors = [0.0; 6];
            axis.component_errors.clear();
        }
        let nominal = machine.clone();
        let rotary: Vec<usize> =
            (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == AxisKind::Rotary).collect();
        for (k, &axis) in rotary.iter().enumerate() {
            // places alone, across the line: no control here holds directions
            let (place, along) = (Vector3::new(0.03 + 0.01 * k as f64, -0.02, 0.05), machine.axes[axis].direction);
            let across = place - along * along.dot(&place);
            machine.axes[axis].location_errors[..3].copy_from_slice(across.as_slice());
        }
        let poses = poses(&machine, tool, None, 300).expect("poses");
        let [now, after] =
            [&nominal, &held(&machine)].map(|known| left_over(&machine, known, tool, &poses).position_mm.largest);
        assert!(now > 5e-3 && after < 1e-9, "{}: {now} mm, then {after}", file.display());
        // a part that is not entered stays
        let carried = *rotary.last().expect("a rotary axis");
        let partly =
            left_over(&machine, &held_where(&machine, &|axis, _| axis != carried), tool, &poses).position_mm.largest;
        assert!(partly > 1e-3, "{}: {partly}", file.display());
        seen += 1;
    }
    assert!(seen > 10, "{seen}");
}
