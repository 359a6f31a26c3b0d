//! A fit as JSON, terminal text and page; text and page are made from the JSON value.

pub mod fit;
pub mod fit_page;
pub mod fit_text;
