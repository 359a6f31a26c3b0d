//! Values to text for people: terminal tables, JSON and SVG. It computes no results and writes no files.

pub mod fit;
pub mod polar;
pub mod table;
