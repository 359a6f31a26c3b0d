//! The thesis's result tables as `examples/thesis/published` ships them, in µm and arcsec.

use std::path::Path;

use fiveaxis::machine::ErrorName;
use fiveaxis::units::parse_quantity;

/// Average and standard deviation of one error by one method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    pub average: f64,
    pub deviation: f64,
}

/// One error of one chapter's tables.
pub fn published(chapter: u8, error: &str) -> Published {
    let file = format!("examples/thesis/published/chapter{chapter}.yaml");
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).expect("published results");
    let value: serde_yaml::Value = serde_yaml::from_str(&text).expect("YAML");
    let name = ErrorName::parse(error, &["A", "C"]).expect("name");
    let number = |key: &str| {
        let text = value["errors"][error][key].as_str().unwrap_or_else(|| panic!("{error} {key}"));
        let measure = name.component.measure();
        measure.to_output(parse_quantity(text, measure).expect("quantity"))
    };
    Published { average: number("value"), deviation: number("deviation") }
}
