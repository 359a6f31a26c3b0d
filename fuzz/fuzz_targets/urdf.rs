//! Robot descriptions: no panic, and what is accepted is written as a machine file that is accepted.
#![no_main]

use std::path::Path;

use fiveaxis::load::{LinkChoice, machine_from_urdf, machine_from_yaml};
use fiveaxis::report::machine_yaml;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(machine) = machine_from_urdf(Path::new("robot.urdf"), text, &LinkChoice::default()) {
        machine_from_yaml(Path::new("written.yaml"), machine_yaml(&machine)).expect("what is written is read");
    }
});
