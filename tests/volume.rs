//! Errors over the work volume against closed formulas, and the command end to end.

use std::path::Path;

use assert_cmd::Command;
use fiveaxis::chain::Chain;
use fiveaxis::inverse::Tool;
use fiveaxis::load::load_machine;
use fiveaxis::machine::Component;
use fiveaxis::volume::{Figures, Part, causes, pose_errors, poses};
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
