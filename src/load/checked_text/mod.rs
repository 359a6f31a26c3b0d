//! Text of files before any format: bounded, printable, with the place of every key, refused with one message.

pub(crate) mod cut_number;
pub(crate) mod document;
pub(crate) mod fields;
pub mod limits;
pub(crate) mod message;
pub mod printable;
pub(crate) mod quantity;
pub(crate) mod text;
