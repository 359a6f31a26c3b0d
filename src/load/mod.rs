//! Files to values: machine and session YAML, URDF, recordings. The only room that knows formats; nothing here computes positions.

mod capture;
mod checked_text;
mod claim;
mod instrument;
mod kit;
mod links;
mod machine_file;
mod mesh;
mod moment;
mod positions;
mod present_values;
mod range;
mod recording;
mod rows;
mod session_file;
mod survey;
mod urdf;

pub use capture::{CaptureFile, CaptureHints, load_capture};
pub use checked_text::message::LoadError;
pub use checked_text::text::read_limited;
pub use checked_text::{limits, printable};
pub use claim::load_claim;
pub use instrument::load_instrument;
pub use kit::{load_kit, standard_kit};
pub use machine_file::bodies::{
    load_description, load_machine_and_bodies, load_machine_and_bodies_with_links, mesh_files,
};
pub use machine_file::machine::{load_machine, machine_from_yaml};
pub use moment::Moment;
pub use positions::{PositionsError, positions_from_text};
pub use present_values::load_present_values;
pub use recording::recording_from_csv;
pub use rows::Rows;
pub use session_file::session::{load_session, load_session_with, names_tests};
pub use survey::{ShardFile, load_shard, shard_title};
pub use urdf::{LinkChoice, machine_from_urdf};
