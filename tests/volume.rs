//! Errors over the work volume against closed formulas, and the command end to end.

use std::path::Path;

use assert_cmd::Command;
use fiveaxis::chain::Chain;
use fiveaxis::diagnose::examine;
use fiveaxis::disturbances::into_component_errors;
use fiveaxis::identify::{Options, fitted_session};
use fiveaxis::inverse::Tool;
use fiveaxis::load::{load_machine, load_session, machine_from_yaml};
use fiveaxis::machine::{Component, Machine};
use fiveaxis::units::ARCSEC_PER_RAD;
use fiveaxis::volume::{Figures, Part, causes, pose_errors, poses, spread};
use nalgebra::Vector3;

const POSES: usize = 4000;

#[test]
fn single_errors_have_the_sizes_that_geometry_says() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/hermle-c600u.yaml");
    let mut machine = load_machine(&file).expect("machine");
    let tool = Tool::of(&machine, None).expect("tool");
    let c = machine.axis_index("C").expect("C");
    let set = poses(&machine, tool, None, POSES).expect("poses");
    // a shift of the table moves every tip alike and turns nothing
    machine.axes[c].location_errors[Component::EX.index()] = 0.02;
    let chain = Chain::of(&machine);
    let figures = Figures::of(&pose_errors(&machine, &chain, tool, &set));
    for value in [figures.position_mm.mean, figures.position_mm.p95, figures.position_mm.largest] {
        assert!((value - 0.02).abs() < 1e-9, "{value}");
    }
    assert!(figures.direction_rad.largest < 1e-12);
    // a tilt of the table turns the tool by its angle everywhere and moves a tip by its distance from the line
    machine.axes[c].location_errors = [0.0; 6];
    machine.axes[c].location_errors[Component::EA.index()] = 1e-4;
    let found = causes(&machine, tool, &set);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].name, "EA0C");
    let errors = pose_errors(&machine, &chain, tool, &set);
    for (pose, error) in set.iter().zip(&errors) {
        // about R's x as C's carrier has it: C turns what it carries back to the workpiece's frame
        let sign = machine.motion_sign(c);
        let angle = sign * pose[c];
        let x = Vector3::new(angle.cos(), -angle.sin(), 0.0);
        let arm = x.cross(&error.tip_mm).norm();
        assert!((error.off_mm.norm() - 2.0 * (0.5e-4f64).sin() * arm).abs() < 1e-9, "{error:?}");
    }
    // across a tilt about x the tool turns by as much as it is not along x
    assert!(found[0].figures.direction_rad.largest < 1e-4 + 1e-12);
    assert!(found[0].figures.direction_rad.largest > 0.99e-4);
    let part = Part { low: Vector3::new(-50.0, -50.0, 0.0), high: Vector3::new(50.0, 50.0, 40.0) };
    let on_part = poses(&machine, tool, Some(&part), POSES).expect("poses");
    let errors = pose_errors(&machine, &chain, tool, &on_part);
    for error in &errors {
        assert!((0..3).all(|k| error.tip_mm[k] > part.low[k] - 1e-9 && error.tip_mm[k] < part.high[k] + 1e-9));
    }
    let far = Part { low: Vector3::repeat(5000.0), high: Vector3::repeat(5100.0) };
    assert!(poses(&machine, tool, Some(&far), POSES).is_err());
}

/// A plain machine with an effect.
fn with_effect(effect: &str) -> Machine {
    let text = format!(
        "name: mill\ncode: \"[wCAbYXZt]\"\ndirections: iso841\naxes:\n  X: {{range: [-300, 300]}}\n  Y: {{range: [-225, 225]}}\n  \
         Z: {{range: [-120, 330]}}\n  A: {{range: [-90, 110]}}\n  C: {{range: [-360, 360]}}\neffects:\n  - {effect}\n"
    );
    machine_from_yaml(Path::new("machine.yaml"), text).expect("machine")
}

#[test]
fn a_squareness_that_was_found_moves_the_line_of_its_slide() {
    let mut machine = with_effect("{effect: squareness, place: Y, sizes: {EC0Y: 30 arcsec}}");
    assert!(into_component_errors(&mut machine).is_empty() && machine.effects.is_empty());
    let y = machine.axis_index("Y").expect("Y");
    let angle = machine.axes[y].location_errors[Component::EC.index()];
    assert!((angle * ARCSEC_PER_RAD - 30.0).abs() < 1e-9, "{angle}");
}

#[test]
fn what_depends_on_more_than_its_axis_gets_no_table() {
    for effect in [
        "{effect: control-centre, place: C, sizes: {EXC: {cos: 50 um}}}",
        "{effect: clamp-lift, place: C, from: 10, to: 50, hysteresis: 20, sizes: {EZC: 20 um}}",
        "{effect: clamp-lift, place: C, from: 10, to: 50, rise: 1, sizes: {EZC: 20 um}}",
    ] {
        let mut machine = with_effect(effect);
        let left = into_component_errors(&mut machine);
        assert!(left.len() == 1 && effect.contains(&left[0]), "{effect}: {left:?}");
        assert!(machine.effects.len() == 1 && machine.axes.iter().all(|axis| axis.component_errors.is_empty()));
    }
    let mut machine = with_effect("{effect: clamp-lift, place: C, from: 10, to: 50, sizes: {EZC: 20 um}}");
    assert!(into_component_errors(&mut machine).is_empty());
    let c = machine.axis_index("C").expect("C");
    assert_eq!(machine.axes[c].component_errors.len(), 1);
}

#[test]
fn what_a_fit_leaves_open_is_drawn_over_all_the_travel() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let session = load_session(&root.join("examples/thesis/chapter5/session.yaml")).expect("session");
    let examination = examine(&session, &Options::default()).expect("fit");
    let fit = examination.fit.as_ref().expect("fit");
    let machine = fitted_session(&session, fit).machine;
    let tool = Tool::of(&machine, None).expect("tool");
    let sigma = |count: usize| {
        let set = poses(&machine, tool, None, count).expect("poses");
        spread(&machine, fit, tool, &set).sigma.position_mm.p95
    };
    let few = sigma(1000);
    // every fifth of them has its third axis in a fifth of its travel
    for count in [2000, 3000, 5000] {
        assert!((sigma(count) / few - 1.0).abs() < 1e-9, "{count}: {} and {few} mm", sigma(count));
    }
}

#[test]
fn the_command_tells_figures_with_uncertainties_and_writes_a_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let out = tempfile::tempdir().expect("folder");
    let run = |more: &[&str]| {
        let folder = out.path().join("volume");
        let output = Command::cargo_bin("fiveaxis")
            .expect("built")
            .current_dir(root)
            .args([
                "volume",
                "examples/thesis/chapter5/machine.yaml",
                "--errors",
                "examples/thesis/chapter5/session.yaml",
            ])
            .args(["--poses", "1000", "--json", "--out"])
            .arg(&folder)
            .args(more)
            .output()
            .expect("run");
        let text = String::from_utf8(output.stdout).expect("text");
        (output.status.code(), serde_json::from_str::<serde_json::Value>(&text).expect("JSON"), folder)
    };
    let (code, value, folder) = run(&[]);
    assert_eq!(code, Some(0), "{value}");
    let figure = |of: &str, name: &str| value[of]["position_um"][name].as_f64().expect(name);
    assert!(figure("figures", "mean") < figure("figures", "p95"));
    assert!(figure("sigma", "p95") > 0.01 && figure("sigma", "p95") < figure("figures", "p95"));
    let page = std::fs::read_to_string(folder.join("volume.html")).expect("page");
    assert!(page.matches("<svg").count() == 4 && page.contains("EY0C"));
    let table = std::fs::read_to_string(folder.join("volume.csv")).expect("table");
    assert_eq!(table.lines().count(), 1001);
    let (code, value, _) = run(&["--part", "1,2,3"]);
    assert_eq!(code, Some(2));
    assert!(value["error"].to_string().contains("two corners"));
}
