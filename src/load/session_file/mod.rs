//! Session files: tests with their balls, paths and recordings.

pub(crate) mod marks;
pub(crate) mod parts;
pub(crate) mod recordings;
pub(crate) mod session;
pub(crate) mod test;
pub(crate) mod test_file;
pub(crate) mod test_path;
pub(crate) mod test_reader;
mod uncut;
