//! Numbers, tables and words that all reports share.

pub mod linear_axes;
pub mod meetings;
pub(crate) mod number;
pub(crate) mod sense_words;
pub mod table;
pub mod words;
