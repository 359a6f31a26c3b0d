//! Robot descriptions (URDF) to a [`Machine`](crate::machine::Machine): metres to mm, fixed joints folded, the code read off the joint tree. Solids are in `collision`.

mod checks;
mod collision;
mod description;
mod ends;
mod frames;
mod mesh;
mod places;
mod reader;
mod tree;

pub use description::{bodies_from_urdf, ends_from_urdf, machine_from_urdf, mesh_names};
pub use ends::LinkChoice;
