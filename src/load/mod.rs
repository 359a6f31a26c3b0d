//! Files to values: machine and session YAML, URDF, recordings. The only room that knows formats; nothing here computes positions.

mod axis;
mod bodies;
mod component_form;
mod document;
mod effects;
mod instrument;
mod kit;
mod machine;
mod mesh;
mod message;
mod positions;
mod quantity;
mod range;
mod recording;
mod rows;
mod session;
mod survey;
mod test;
mod test_path;
mod text;
mod urdf;

pub use bodies::{load_machine_and_bodies, load_machine_and_bodies_with_links, mesh_files};
pub use instrument::load_instrument;
pub use kit::{load_kit, standard_kit};
pub use machine::{load_machine, load_machine_with_links, machine_from_yaml};
pub use message::LoadError;
pub use positions::{PositionsError, positions_from_text};
pub use recording::recording_from_csv;
pub use rows::Rows;
pub use session::{load_session, load_session_with, names_tests};
pub use survey::{ShardFile, load_shard, shard_title};
pub use text::read_limited;
pub use urdf::{LinkChoice, bodies_from_urdf, machine_from_urdf};
