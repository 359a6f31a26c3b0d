//! A diagnosis as JSON, terminal text, page and pictures; all are made from the JSON value.

mod answers;
pub mod before_after;
pub(crate) mod cause_title;
pub mod chain_map;
pub mod diagnosis;
pub mod diagnosis_page;
pub mod diagnosis_text;
pub mod finding_words;
mod quantity_words;
pub mod shape_words;
mod unrolled;
pub mod unseen;
