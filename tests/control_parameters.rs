//! `fiveaxis control` end to end: signs of parameters, the limit, present values, heads component by component.

use crate::answers::answer;
use crate::{recorded, shipped};
use std::path::Path;

use assert_cmd::Command;
use fiveaxis::chain::{Chain, Composition, Geometry};
use fiveaxis::control::{
    Control, Number, Parameter, What, backlash, held, held_where, left_over, numbers, parameters, tables,
};
use fiveaxis::identify::{Options, axis_lines, identify};
use fiveaxis::inverse::Tool;
use fiveaxis::load::{load_machine_and_bodies, load_session};
use fiveaxis::machine::{AxisKind, ComponentError, ComponentForm, Effect, Machine, Outlet, Place, Size};
use fiveaxis::report::control::{ControlReport, control_text};
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

/// Points of a machine with all axes at zero: its lines from the bed outward, table first, and the spindle; by how much each is off, mm.
struct Off {
    file: &'static str,
    table: Vec<(&'static str, Vector3<f64>)>,
    head: Vec<(&'static str, Vector3<f64>)>,
    /// Of the spindle, beside the last line of the head.
    spindle: Vector3<f64>,
}

impl Off {
    /// What a fit would say of each line, and where it stands.
    fn numbers(&self, machine: &Machine) -> Vec<Number> {
        let index = |name: &str| machine.axis_index(name).expect("an axis");
        let mut list = Vec::new();
        let mut add = |axis: usize, what: What, change: Vector3<f64>| {
            list.extend((0..3).map(|component| Number {
                axis,
                what,
                component,
                change: change[component],
                sigma: 1e-3,
                determined: true,
            }));
        };
        for (branch, first) in [(&self.table, What::TableCentre), (&self.head, What::ZeroShift)] {
            for (k, (name, own)) in branch.iter().enumerate() {
                let what = if k == 0 { first } else { What::Vector { from: index(branch[k - 1].0) } };
                add(index(name), what, *own);
            }
        }
        if let Some((name, _)) = self.head.last() {
            add(index(name), What::Pivot, self.spindle);
        }
        list
    }

    /// How far a point stands off, from the bed outward.
    fn line(branch: &[(&'static str, Vector3<f64>)], count: usize) -> Vector3<f64> {
        branch[..count].iter().map(|(_, own)| own).sum()
    }
}

/// Vectors by their ends, as the makers' manuals name them: Sinumerik Operate commissioning manual 03/2013, page 502, and 12/2017, page 572
/// (T, P and M); Fanuc A-79348E, pages 80 to 84.
#[test]
fn vectors_of_the_makers_run_between_the_points_that_their_manuals_name() {
    let [one, two, three] =
        [(0.011, -0.023, 0.037), (0.041, 0.053, -0.067), (-0.071, 0.083, 0.097)].map(|(x, y, z)| Vector3::new(x, y, z));
    let cases = [
        Off { file: "head-head-ca-overhead-gantry", table: vec![], head: vec![("C", one), ("A", two)], spindle: three },
        Off { file: "hermle-c600u", table: vec![("A", one), ("C", two)], head: vec![], spindle: Vector3::zeros() },
        Off { file: "table-1-1-table-head-ca", table: vec![("C", one)], head: vec![("A", two)], spindle: three },
    ];
    for case in cases {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("machines/{}.yaml", case.file));
        let (machine, _) = load_machine_and_bodies(&path).expect("machine");
        let numbers = case.numbers(&machine);
        let (table, head) = (&case.table, &case.head);
        let spindle = Off::line(head, head.len()) + case.spindle;
        let bed = Vector3::zeros();
        let mut due: Vec<(Control, String, usize, Vector3<f64>)> = Vec::new();
        let mut expect = |control, name: &str, first, vector| due.push((control, name.to_string(), first, vector));
        let sinumerik = Control::Sinumerik;
        match (table.len(), head.len()) {
            (0, 2) => {
                let (i3, i2) = (Off::line(head, 2) - spindle, Off::line(head, 1) - Off::line(head, 2));
                expect(sinumerik, "$TC_CARR", 15, i3);
                expect(sinumerik, "$TC_CARR", 4, i2);
                expect(sinumerik, "$TC_CARR", 1, -(i2 + i3));
                expect(sinumerik, "MD24500 $MC_TRAFO5_PART_OFFSET_1", 0, -(i2 + i3));
                expect(sinumerik, "MD24560 $MC_TRAFO5_JOINT_OFFSET_1", 0, i2);
                expect(sinumerik, "MD24550 $MC_TRAFO5_BASE_TOOL_1", 0, i3);
                expect(Control::Fanuc, "No. ", 19709, i3);
                expect(Control::Fanuc, "No. ", 19712, i2);
            }
            (2, 0) => {
                let (i2, i3) = (Off::line(table, 1) - bed, Off::line(table, 2) - Off::line(table, 1));
                expect(sinumerik, "$TC_CARR", 4, i2);
                expect(sinumerik, "$TC_CARR", 15, i3);
                expect(sinumerik, "$TC_CARR", 18, -(i2 + i3));
                expect(sinumerik, "MD24550 $MC_TRAFO5_BASE_TOOL_1", 0, i2);
                expect(sinumerik, "MD24560 $MC_TRAFO5_JOINT_OFFSET_1", 0, i3);
                expect(sinumerik, "MD24500 $MC_TRAFO5_PART_OFFSET_1", 0, -(i2 + i3));
                expect(Control::Fanuc, "No. ", 19700, i2);
                expect(Control::Fanuc, "No. ", 19703, i3);
            }
            _ => {
                let (i2, i3) = (Off::line(head, 1) - spindle, Off::line(table, 1) - bed);
                expect(sinumerik, "$TC_CARR", 4, i2);
                expect(sinumerik, "$TC_CARR", 1, -i2);
                expect(sinumerik, "$TC_CARR", 15, i3);
                expect(sinumerik, "$TC_CARR", 18, -i3);
                expect(sinumerik, "MD24550 $MC_TRAFO5_BASE_TOOL_1", 0, i2);
                expect(sinumerik, "MD24560 $MC_TRAFO5_JOINT_OFFSET_1", 0, -i2);
                expect(sinumerik, "MD24558 $MC_TRAFO5_JOINT_OFFSET_PART_1", 0, i3);
                expect(sinumerik, "MD24500 $MC_TRAFO5_PART_OFFSET_1", 0, -i3);
                expect(Control::Fanuc, "No. ", 19709, i2);
                expect(Control::Fanuc, "No. ", 19700, i3);
            }
        }
        for control in [Control::Sinumerik, Control::Fanuc] {
            let given = parameters(control, &machine, &numbers, None);
            let of_control = || due.iter().filter(|(own, ..)| *own == control);
            assert_eq!(given.len(), 3 * of_control().count(), "{}: {given:?}", case.file);
            for (_, name, first, vector) in of_control() {
                for k in 0..3 {
                    let name = match name.starts_with("MD") {
                        true => format!("{name}[{k}]"),
                        false => format!("{name}{}", first + k),
                    };
                    let one = given.iter().find(|one| one.name == name).unwrap_or_else(|| panic!("{name}: {given:?}"));
                    assert!(
                        (one.change - vector[k]).abs() < 1e-12,
                        "{}: {name} {} for {}",
                        case.file,
                        one.change,
                        vector[k]
                    );
                }
            }
        }
    }
}

#[test]
fn slides_that_count_against_the_tool_turn_the_signs_of_parameters() {
    let folder = tempfile::tempdir().expect("folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let drawn = std::fs::read_to_string(root.join("machines/table-table-ca-moving-table-x.yaml")).expect("machine");
    assert!(drawn.contains("directions: iso841"));
    std::fs::write(folder.path().join("m.yaml"), drawn.replace("directions: iso841", "directions: carried"))
        .expect("written");
    let session = "machine: m.yaml\ntests:\n  - {name: c, bar_length: 100, pivot: {link: C, at: [100, 0, 0]}, spindle_ball: {link: t, at: [0, 0, 0]}, positions: {X: 0, Y: 0, Z: 0, A: 0}, recording: c.csv}\n";
    std::fs::write(folder.path().join("session.yaml"), session).expect("written");
    let rows: String = (0..90).map(|k| format!("{k},{},100.00{}\n", 4 * k, k % 7)).collect();
    std::fs::write(folder.path().join("c.csv"), format!("time_s,C_deg,length_mm\n{rows}")).expect("written");
    let file = folder.path().join("session.yaml");
    let (code, value) = run(&["control", file.to_str().expect("text"), "--control", "linuxcnc"]);
    assert_eq!(code, Some(2), "{value}");
    assert!(value["error"].to_string().contains("a positive command of X moves the tool the other way"), "{value}");
    // others take the parts along it with the opposite sign
    let [carried, iso] = ["carried", "iso841"].map(|directions| {
        let yaml = drawn.replace("directions: iso841", &format!("directions: {directions}"));
        let file = folder.path().join(format!("{directions}.yaml"));
        std::fs::write(&file, yaml).expect("written");
        load_machine_and_bodies(&file).expect("machine").0
    });
    let axis = carried.axis_index("A").expect("A");
    let number =
        |component| Number { axis, what: What::TableCentre, component, change: 0.02, sigma: 1e-3, determined: true };
    for (component, sign) in [(0, -1.0), (1, 1.0)] {
        let given = |machine: &Machine| parameters(Control::Fanuc, machine, &[number(component)], None)[0].change;
        assert_eq!(given(&carried), sign * given(&iso));
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
fn saved(name: &str) -> String {
    let answer = answer(name);
    assert_eq!(answer.code, Some(0), "{}", answer.json);
    answer.saved().join("session.yaml").to_str().expect("text").to_string()
}

#[test]
fn lost_motion_that_was_found_is_given_as_backlash() {
    let scratch = tempfile::tempdir().expect("folder");
    let session = saved("03-lost-motion");
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
    let session = saved("01-worm-gear");
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
        let (mut machine, _) = load_machine_and_bodies(&file).expect("machine");
        let Some(tool) = Tool::of(&machine, None) else { continue };
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
        let [now, after] = [&nominal, &held(&machine)]
            .map(|known| left_over(&machine, known, (tool, tool), &poses).position_mm.largest);
        assert!(now > 5e-3 && after < 1e-9, "{}: {now} mm, then {after}", file.display());
        // a part that is not entered stays
        let carried = *rotary.last().expect("a rotary axis");
        let partly = left_over(&machine, &held_where(&machine, &|axis, _| axis != carried), (tool, tool), &poses)
            .position_mm
            .largest;
        assert!(partly > 1e-3, "{}: {partly}", file.display());
        seen += 1;
    }
    assert!(seen > 10, "{seen}");
}

/// Recordings of a planned machine with location errors of C and a bend of X about x; the session's machine states the bend by
/// `bend`, under the axes.
fn bent(folder: &Path, bend: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let fiveaxis = |arguments: &[&str]| {
        let run = Command::cargo_bin("fiveaxis").expect("built").args(arguments).output().expect("run");
        assert!(run.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&run.stderr));
    };
    let text = |path: &Path| path.to_str().expect("text").to_string();
    let plan = folder.join("plan");
    let machine = text(&root.join("machines/table-head-cb-moving-table-y.yaml"));
    fiveaxis(&["plan", &machine, "--feed", "1500", "--circles", "--sigma", "3um,3arcsec", "--out", &text(&plan)]);
    let drawn = std::fs::read_to_string(&machine).expect("machine");
    let bent = drawn.replace(
        "X: {range: [-375, 375]}",
        "X: {range: [-375, 375], component_errors: {EAX: {polynomial: [0 arcsec, 0.001147 arcsec]}}}",
    );
    let c = "C: {origin: [0, 0, 0], range: [-360, 360]";
    let truth = bent.replace(c, &format!("{c}, errors: {{EX0C: 31 um, EY0C: -42 um}}"));
    std::fs::write(plan.join("truth.yaml"), truth).expect("written");
    let session = std::fs::read_to_string(plan.join("session.yaml")).expect("session");
    std::fs::write(plan.join("true.yaml"), session.replace("machine: machine.yaml", "machine: truth.yaml"))
        .expect("written");
    let recorded = folder.join("recorded");
    fiveaxis(&["simulate", &text(&plan.join("true.yaml")), "--out", &text(&recorded), "--instrument", "default"]);
    let stated = if bend.is_empty() { bent } else { format!("{drawn}\neffects:\n{bend}") };
    std::fs::write(recorded.join("machine.yaml"), stated).expect("written");
    let lines = session.lines().filter(|line| !line.trim_start().starts_with("sweep:") && !line.starts_with('#'));
    std::fs::write(recorded.join("session.yaml"), lines.collect::<Vec<_>>().join("\n") + "\n").expect("written");
    text(&recorded.join("session.yaml"))
}

#[test]
fn parameters_that_make_the_volume_worse_are_told_and_not_written() {
    let scratch = tempfile::tempdir().expect("folder");
    let session = bent(scratch.path(), "");
    let out = scratch.path().join("out");
    let said = ["control", &session, "--control", "heidenhain"];
    let (code, value) = run(&said);
    assert_eq!(code, Some(0), "{value}");
    let figure = |key: &str| value[key]["position_p95_um"].as_f64().expect("figure");
    assert!(figure("volume_after") > 1.05 * figure("volume_now"), "{value}");
    let warnings = value["warnings"].to_string();
    assert!(warnings.contains("make the volume worse") && warnings.contains("EAX over the travel of X"), "{warnings}");
    let with_out = [&said[..], &["--out", out.to_str().expect("text")]].concat();
    let (code, value) = run(&with_out);
    assert_eq!(code, Some(2));
    assert!(value["error"].to_string().contains("no files are written") && !out.exists(), "{value}");
    let (code, _) = run(&[&with_out[..], &["--force"]].concat());
    assert_eq!(code, Some(0));
    assert!(out.join("parameters.csv").is_file());
}

#[test]
fn what_was_found_ends_where_it_was_recorded_and_an_open_cause_is_told() {
    let scratch = tempfile::tempdir().expect("folder");
    let effect = "  - effect: straightness\n    place: X\n    degrees: [2]\n    half_travel: 100\n    \
                  cannot_tell_from: \"rotary-error-motion of C (EXC), 49 % against 49 %\"\n    \
                  sizes: {EAX: {degree2: 11.47 arcsec}}\n";
    let session = bent(scratch.path(), effect);
    let out = scratch.path().join("out");
    let (code, value) =
        run(&["control", &session, "--control", "fanuc", "--force", "--out", out.to_str().expect("text")]);
    assert_eq!(code, Some(0), "{value}");
    let warnings = value["warnings"].to_string();
    assert!(warnings.contains("the cause is open") && warnings.contains("its last value is held"), "{warnings}");
    let table = std::fs::read_to_string(out.join("EAX.csv")).expect("table");
    let rows: Vec<f64> =
        table.lines().skip(1).map(|line| line.split(',').next().expect("x").parse().expect("number")).collect();
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    assert!(first < -90.0 && first > -200.0 && last > 90.0 && last < 200.0, "{first} … {last} of ±375");
    let program = scratch.path().join("part.ngc");
    std::fs::write(&program, "G21 G90 G17 G94 G54 G49\nG0 X0 Y0 Z0 B0 C0\nG1 X200 F900\n").expect("written");
    let corrected = scratch.path().join("corrected.ngc");
    let machine = Path::new(&session).with_file_name("machine.yaml");
    let [program, machine, corrected] = [&program, &machine, &corrected].map(|file| file.to_str().expect("text"));
    let (code, value) =
        run(&["compensate", program, machine, "--errors", &session, "--offset", "G54:", "--out", corrected]);
    assert_eq!(code, Some(0), "{value}");
    let warnings = value["warnings"].to_string();
    assert!(warnings.contains("the cause is open") && warnings.contains("its last value is held"), "{warnings}");
}

#[test]
fn what_was_not_fitted_is_no_number_for_the_control() {
    let told = |free: &str| -> Vec<(String, bool)> {
        let (code, fit) = run(&["identify", SESSION, "--free", free]);
        assert_eq!(code, Some(0), "{fit}");
        let lines = fit["control"].as_array().expect("lines");
        lines.iter().map(|line| (line["axis"].as_str().expect("axis").into(), line["told"] == true)).collect()
    };
    // location errors of A are in these readings: without them nothing is determined
    assert_eq!(told("EX0C,EY0C,EA0C,EB0C"), [("C".into(), false), ("A".into(), false)]);
    assert_eq!(told("EX0C,EY0C,EA0C,EB0C,EY0A,EZ0A"), [("C".into(), true), ("A".into(), true)]);
}

#[test]
fn a_control_that_takes_nothing_is_promised_nothing() {
    assert!(!text_of(&[]).contains("must have become smaller"));
    // -4 ± 167 µm is no correction
    let text = text_of(&[parameter(-4e-3, 0.167)]);
    assert!(text.contains("Within their own sigma, and better left as they are: place of A, y."), "{text}");
    assert!(!text.contains("must have become smaller"), "{text}");
    assert!(text_of(&[parameter(-4e-3, 1e-3)]).contains("must have become smaller"));
}

fn parameter(change: f64, sigma: f64) -> Parameter {
    Parameter { name: "place of A, y".into(), meaning: String::new(), change, sigma, value: None, is_angle: false }
}

/// What is told of parameters alone.
fn text_of(parameters: &[Parameter]) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/hermle-c600u.yaml");
    let (machine, _) = load_machine_and_bodies(&file).expect("shipped machine");
    control_text(&ControlReport {
        machine: &machine,
        control: Control::Heidenhain,
        module: None,
        numbers: &[],
        parameters,
        present: &[],
        volume: None,
        tables: Vec::new(),
        backlash: Vec::new(),
        without_travel: Vec::new(),
        squareness: Vec::new(),
        stays: Vec::new(),
        notes: Vec::new(),
    })
}
