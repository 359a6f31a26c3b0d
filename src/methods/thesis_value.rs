//! The thesis's methods by name, and a location error as one of them finds it.

use std::fmt;

use crate::machine::ErrorName;

/// One of the thesis's methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThesisMethod {
    /// Two pivot mountings, each axis tested with the short and the extended bar.
    Chapter4,
    /// One pivot mounting for all four tests.
    Chapter5,
    /// Each axis tested with the short bar at two positions along it.
    Chapter6,
}

impl fmt::Display for ThesisMethod {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            ThesisMethod::Chapter4 => "chapter4",
            ThesisMethod::Chapter5 => "chapter5",
            ThesisMethod::Chapter6 => "chapter6",
        })
    }
}

/// One location error as a method finds it.
#[derive(Debug, Clone, PartialEq)]
pub struct ThesisValue {
    pub name: ErrorName,
    /// mm or rad.
    pub value: f64,
    /// Standard deviation of one set of runs, mm or rad; `None` without repeats.
    pub run_deviation: Option<f64>,
    /// Standard deviation of the mean of all runs, mm or rad: repeatability alone, setups are not in it.
    pub mean_deviation: Option<f64>,
    /// Inner axis: the outer error that was taken out of this value, and the value (mm or rad) with it left in.
    pub left_in: Option<(ErrorName, f64)>,
}
