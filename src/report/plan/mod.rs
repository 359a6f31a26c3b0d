//! A plan as terminal text and as JSON. It chooses nothing.

mod json;
mod text;

pub use json::plan_json;
pub use text::plan_text;
