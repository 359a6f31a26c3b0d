//! Machine files: no panic, and what is accepted is written as a file that is accepted.
#![no_main]

use std::path::Path;

use fiveaxis::load::machine_from_yaml;
use fiveaxis::report::machine_yaml;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: String| {
    if let Ok(machine) = machine_from_yaml(Path::new("machine.yaml"), text) {
        let written = machine_yaml(&machine);
        machine_from_yaml(Path::new("written.yaml"), written).expect("what is written is read");
    }
});
