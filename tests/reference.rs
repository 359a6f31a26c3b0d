//! Lengths and derivatives against values computed elsewhere at 60 digits (thesis's four tests, all PIGEs).

use crate::shared_data;
use std::path::Path;

use fiveaxis::chain::{Chain, Composition, Geometry, Sensitivity};
use fiveaxis::load::machine_from_yaml;
use nalgebra::Vector3;

const MACHINE: &str = "name: reference\ncode: '[wCAbYXZt]'\naxes: {}\n";
const UM: f64 = 1e-3;
const DEG: f64 = std::f64::consts::PI / 180.0;

/// EB0A EC0A (deg) EY0A EZ0A (µm) EA0C EB0C (deg) EX0C EY0C (µm) of a named case.
fn case_errors(case: &str) -> Option<[f64; 8]> {
    let names = ["ty0a", "tz0a", "ey0a", "ez0a", "tx0c", "ty0c", "ex0c", "ey0c"];
    let sizes = [0.01, 0.01, 10.0, 10.0, 0.01, 0.01, 10.0, 10.0];
    Some(match case {
        "none" => [0.0; 8],
        "all" => sizes,
        "mixed" => [0.01, -0.007, 10.0, -8.0, 0.006, -0.009, 5.0, -4.0],
        "big" => [1.0, -0.7, 1000.0, -800.0, 0.6, -0.9, 500.0, -400.0],
        single => {
            let index = names.iter().position(|name| *name == single)?;
            let mut errors = [0.0; 8];
            errors[index] = sizes[index];
            errors
        }
    })
}

fn location_errors(chain_axes: &[&str], e: &[f64; 8]) -> Vec<[f64; 6]> {
    chain_axes
        .iter()
        .map(|axis| match *axis {
            "A" => [0.0, e[2] * UM, e[3] * UM, 0.0, e[0] * DEG, e[1] * DEG],
            "C" => [e[6] * UM, e[7] * UM, 0.0, e[4] * DEG, e[5] * DEG, 0.0],
            _ => [0.0; 6],
        })
        .collect()
}

struct Pose {
    positions: Vec<f64>,
    pivot: Vector3<f64>,
    spindle: Vector3<f64>,
}

fn pose(chain_axes: &[&str], test: &str, theta_deg: f64) -> Pose {
    let far = (150.0f64 * 150.0 - 100.0 * 100.0).sqrt();
    let (axis, pivot, spindle) = match test {
        "A1" => ("A", [0.0, 100.0, 0.0], [0.0, 0.0, 0.0]),
        "A2" => ("A", [0.0, 100.0, 0.0], [-far, 0.0, 0.0]),
        "C1" => ("C", [100.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        _ => ("C", [100.0, 0.0, 0.0], [0.0, 0.0, far]),
    };
    let positions = chain_axes.iter().map(|name| if *name == axis { theta_deg * DEG } else { 0.0 }).collect();
    Pose { positions, pivot: Vector3::from(pivot), spindle: Vector3::from(spindle) }
}

#[test]
fn lengths_agree_with_sixty_digit_values_better_than_a_nanometre() {
    let Some(folder) = shared_data::folder("reference") else { return };
    let machine = machine_from_yaml(Path::new("reference.yaml"), MACHINE.into()).unwrap();
    let chain = Chain::of(&machine);
    let axes = machine.axis_names();
    let text = std::fs::read_to_string(folder.join("reference_traces.csv")).unwrap();
    let mut worst = [0.0f64; 2];
    let mut rows = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = line.split(',').collect();
        let Ok(theta) = fields[2].parse::<f64>() else { continue };
        let Some(errors) = case_errors(fields[1]) else { panic!("unknown case {}", fields[1]) };
        let errors = location_errors(&axes, &errors);
        let pose = pose(&axes, fields[0], theta);
        for (index, composition) in [Composition::Exact, Composition::FirstOrder].into_iter().enumerate() {
            let geometry = Geometry::new(&chain, &errors, composition);
            let pivot = (chain.link("w").unwrap(), &pose.pivot);
            let length = geometry.length(pivot, (chain.link("t").unwrap(), &pose.spindle), &pose.positions, None);
            let expected: f64 = fields[4 + index].parse().unwrap();
            worst[index] = worst[index].max((length - expected).abs());
        }
        rows += 1;
    }
    println!("{rows} rows, worst difference: exact {:.2e} mm, first order {:.2e} mm", worst[0], worst[1]);
    assert_eq!(rows, 10848);
    // asked for: 1e-9 mm; a few units of the last place of 300 mm are reached
    assert!(worst[0] < 1e-11 && worst[1] < 1e-11, "{worst:?}");
}

#[test]
fn derivatives_agree_with_sixty_digit_values() {
    let Some(folder) = shared_data::folder("reference") else { return };
    let machine = machine_from_yaml(Path::new("reference.yaml"), MACHINE.into()).unwrap();
    let chain = Chain::of(&machine);
    let axes = machine.axis_names();
    let (a, c) = (machine.axis_index("A").unwrap(), machine.axis_index("C").unwrap());
    let text = std::fs::read_to_string(folder.join("reference_jacobian.csv")).unwrap();
    let mut worst = 0.0f64;
    let mut rows = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = line.split(',').collect();
        let Ok(theta) = fields[2].parse::<f64>() else { continue };
        let errors = location_errors(&axes, &case_errors(fields[1]).unwrap());
        let composition = if fields[3] == "exact" { Composition::Exact } else { Composition::FirstOrder };
        let geometry = Geometry::new(&chain, &errors, composition);
        let pose = pose(&axes, fields[0], theta);
        let mut s = Sensitivity::zeros(axes.len());
        let pivot = (chain.link("w").unwrap(), &pose.pivot);
        geometry.sensitivity(pivot, (chain.link("t").unwrap(), &pose.spindle), &pose.positions, None, &mut s);
        let found = [
            s.location[a][4],
            s.location[a][5],
            s.location[a][1],
            s.location[a][2],
            s.location[c][3],
            s.location[c][4],
            s.location[c][0],
            s.location[c][1],
            s.pivot.x,
            s.pivot.y,
            s.pivot.z,
            s.spindle.x,
            s.spindle.y,
            s.spindle.z,
        ];
        for (value, field) in found.iter().zip(&fields[5..]) {
            worst = worst.max((value - field.parse::<f64>().unwrap()).abs());
        }
        rows += 1;
    }
    println!("{rows} rows, worst difference {worst:.2e}");
    assert_eq!(rows, 240);
    // levers of 300 mm: a few units of their last place
    assert!(worst < 1e-10, "{worst:e}");
}
