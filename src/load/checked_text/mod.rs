//! Text of files before any format: bounded, printable, with the place of every key, refused with one message.

pub(crate) mod cut_number;
pub(crate) mod decimal;
pub(crate) mod document;
pub mod limits;
pub(crate) mod message;
pub mod printable;
pub(crate) mod quantity;
pub(crate) mod text;
