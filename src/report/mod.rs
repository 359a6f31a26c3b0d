//! Values to text for people and programs: terminal tables, JSON, YAML and SVG. It computes no results and writes no files.

pub mod before_after;
pub mod capture;
mod cards;
pub mod chain_map;
pub mod check;
pub mod circles;
mod course;
pub mod diagnosis;
pub mod diagnosis_page;
pub mod diagnosis_text;
mod effect_yaml;
pub mod finding_words;
pub mod fit;
pub mod fit_page;
pub mod fit_text;
pub mod linear_axes;
pub mod meetings;
mod number;
pub mod polar;
pub mod recording;
pub mod residual_plot;
mod sense_words;
pub mod setup_sheet;
pub mod simulation;
pub mod survey;
pub mod survey_page;
pub mod table;
pub mod thesis;
pub mod trace_plots;
pub mod words;
mod yaml;

pub use effect_yaml::effect_yaml;
pub use sense_words::{InsteadJson, SenseJson};
pub use words::{approach_in_words, what_moves};
pub use yaml::{machine_yaml, session_yaml};
