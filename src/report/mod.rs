//! Values to text for people and programs: terminal tables, JSON, YAML and SVG. It computes no results and writes no files.

pub mod capture;
pub mod check;
pub mod circles;
pub mod clearance;
pub mod compensate;
pub mod control;
mod diagnoses;
mod files;
mod fits;
pub mod history;
pub mod inverse;
mod pictures;
pub mod plan;
pub mod reconciliation;
pub mod setup_sheet;
pub mod simulation;
pub mod survey;
pub mod survey_page;
pub mod thesis;
pub mod volume;
mod wording;

pub use diagnoses::{
    before_after, chain_map, diagnosis, diagnosis_page, diagnosis_text, finding_words, shape_words, unseen,
};
pub use files::yaml::{machine_yaml, session_yaml};
pub use files::{machine_file, recording, urdf};
pub use fits::{fit, fit_page, fit_text};
pub use pictures::{polar, trace_plots};
pub use wording::sense_words::{InsteadJson, SenseJson};
pub use wording::{found, linear_axes, meetings, table, words};
