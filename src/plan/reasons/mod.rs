//! What stays undetermined, and why, in words. Nothing is chosen.
//!
//! | file | question |
//! |---|---|
//! | `no_length` | can any length tell it? |
//! | `untested` | which limit leaves an axis without a test, by how much? |
//! | `unfit` | why does a method of the thesis not fit a machine? |
//! | `forecast` | how well is each error told, and what keeps the others from it? |

pub(crate) mod forecast;
pub(crate) mod no_length;
pub(crate) mod unfit;
pub(crate) mod untested;
