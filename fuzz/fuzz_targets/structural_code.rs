//! Structural codes, error names and quantities: no panic, and what is printed reads back.
#![no_main]

use fiveaxis::machine::{ErrorName, StructuralCode};
use fiveaxis::units::{Measure, parse_quantity};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(code) = StructuralCode::parse(text) {
        assert_eq!(StructuralCode::parse(&code.to_string()), Ok(code));
    }
    let axes = ["X", "A", "J1", "j1"];
    if let Ok(name) = ErrorName::parse(text, &axes) {
        assert_eq!(ErrorName::parse(&name.to_string(), &axes), Ok(name));
    }
    for measure in [Measure::Length, Measure::Angle] {
        if let Ok(value) = parse_quantity(text, measure) {
            assert!(value.is_finite());
        }
    }
});
