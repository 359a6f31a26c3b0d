//! Numbers, tables, words and markup that all reports share.

pub mod found;
pub mod linear_axes;
pub(crate) mod markup;
pub mod meetings;
pub(crate) mod number;
pub(crate) mod sense_words;
pub mod table;
pub mod words;
