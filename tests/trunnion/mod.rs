//! The thesis's machine as a chain with errors of choice: lengths, arcs and their circles. Shared by the tests of its equations.

use std::path::Path;

use fiveaxis::chain::{Chain, Composition, Geometry};
use fiveaxis::load::machine_from_yaml;
use fiveaxis::machine::ErrorName;
use fiveaxis::units::{ARCSEC_PER_RAD, UM_PER_MM};
use nalgebra::Vector3;

const MACHINE: &str = "name: thesis\ncode: '[wCAbYXZt]'\naxes: {}\n";

/// Errors in µm and arcsec by ISO name.
pub type Errors<'a> = &'a [(&'a str, f64)];

/// Two balls: the pivot on a link, the spindle ball in R, mm.
#[derive(Clone, Copy)]
pub struct Balls {
    pub pivot: (&'static str, [f64; 3]),
    pub spindle: [f64; 3],
}

impl Balls {
    /// Length at angles of A and C, mm and degrees.
    pub fn length_mm(&self, errors: Errors, composition: Composition, [a_deg, c_deg]: [f64; 2]) -> f64 {
        let machine = machine_from_yaml(Path::new("thesis.yaml"), MACHINE.to_string()).expect("machine");
        let names = machine.axis_names();
        let mut values = machine.location_errors();
        for (name, size) in errors {
            let name = ErrorName::parse(name, &names).expect("error");
            let per = if name.component.is_angle() { ARCSEC_PER_RAD } else { UM_PER_MM };
            values[machine.axis_index(&name.axis).expect("axis")][name.component.index()] = size / per;
        }
        let chain = Chain::of(&machine);
        let at = |axis: &&str| match *axis {
            "A" => a_deg.to_radians(),
            "C" => c_deg.to_radians(),
            _ => 0.0,
        };
        let positions: Vec<f64> = names.iter().map(at).collect();
        let link = |name: &str| chain.link(name).expect("link");
        let (pivot, spindle) = (Vector3::from(self.pivot.1), Vector3::from(self.spindle));
        Geometry::new(&chain, &values, composition).length(
            (link(self.pivot.0), &pivot),
            (link("Z"), &spindle),
            &positions,
            None,
        )
    }
}
