//! The examples of docs/formats.md are read by the readers they describe.

use std::path::Path;

use fiveaxis::load::{load_claim, load_instrument, load_session, machine_from_yaml};

const DOCUMENT: &str = include_str!("../docs/formats.md");

/// The YAML examples in their order.
fn examples() -> Vec<&'static str> {
    DOCUMENT.split("```yaml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

#[test]
fn every_example_is_read() {
    let [machine, component_errors, linear_axes, session, readings, instrument, results] = examples()[..] else {
        panic!("seven examples are expected")
    };
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        file
    };
    machine_from_yaml(Path::new("machine.yaml"), machine.into()).unwrap();
    let text = format!("name: c\ncode: '[wCAbYXZt]'\n{component_errors}");
    let forms = machine_from_yaml(Path::new("component_errors.yaml"), text).unwrap();
    assert_eq!(forms.axes.iter().map(|axis| axis.component_errors.len()).sum::<usize>(), 4);
    let text = format!("name: c\ncode: '[wCAbYXZt]'\naxes: {{}}\n{linear_axes}");
    let budget = machine_from_yaml(Path::new("linear_axes.yaml"), text).unwrap().linear_axes;
    assert!(budget.is_stated);
    approx::assert_relative_eq!(budget.positioning, 8e-6);
    approx::assert_relative_eq!(budget.straightness, 5e-6);
    write("machine.yaml", machine);
    write("a-short-cw.csv", "time_s,A_deg,length_mm\n0,70,99.99\n0.1,69.9,99.98\n");
    let session = load_session(&write("session.yaml", session)).unwrap();
    assert_eq!(session.tests[0].recording.as_ref().unwrap().len(), 2);
    write(
        "points.csv",
        "pose,X_mm,Y_mm,Z_mm,A_deg,C_deg,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,0,0,1,2,3,1,0,0,0\n1,0,0,0,0,90,2,-1,3,1,0,0,0\n2,0,0,0,0,180,-1,-2,3,1,0,0,0\n",
    );
    assert_eq!(load_session(&write("readings.yaml", readings)).unwrap().tests.len(), 6);
    assert_eq!(load_claim(&write("results.yaml", results)).unwrap().values.len(), 2);
    let instrument = load_instrument(&write("instrument.yaml", instrument)).unwrap();
    assert_eq!(instrument.correlation_time_s, 1.2);
}
