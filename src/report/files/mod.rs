//! Machines, sessions and recordings as files that other programs, and this one, read back. It writes none.

pub(crate) mod effect_yaml;
pub mod machine_file;
pub mod recording;
pub mod urdf;
pub(crate) mod yaml;
pub(crate) mod yaml_text;
