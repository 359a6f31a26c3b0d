//! Recordings: no panic, and accepted columns are of one length.
#![no_main]

use std::path::Path;
use std::sync::LazyLock;

use fiveaxis::load::{machine_from_yaml, recording_from_csv};
use fiveaxis::machine::Machine;
use libfuzzer_sys::fuzz_target;

static MILL: LazyLock<Machine> = LazyLock::new(|| {
    let text = "name: mill\ncode: '[wCAbYXZt]'\naxes: {A: {range: [-30, 110]}}\n";
    machine_from_yaml(Path::new("machine.yaml"), text.into()).expect("the machine is sound")
});

fuzz_target!(|input: (bool, &str)| {
    let bar = input.0.then_some(100.0);
    if let Ok(recording) = recording_from_csv(Path::new("a.csv"), input.1, &MILL, bar) {
        assert!(recording.readings() > 0);
        assert!(recording.positions.iter().all(|column| column.len() == recording.len()));
    }
});
