//! What a machine or session file says, as terminal text and as JSON.

mod facts;
mod json;
mod text;

pub use facts::{LinkPose, MovingAxis, Placement, Senses, SessionCheck, TestCheck};
pub use json::{AxisJson, CheckJson, ErrorJson, LinkJson, PlacementJson, check_json};
pub use text::check_text;
