//! The setup sheet: a stand-alone HTML page to print, one sheet of paper for the plan and one for each test. It computes nothing.

mod dry_run;
mod mounting;
mod page;
mod picture;
mod readings;
mod sheet;
mod trade_off;

pub use page::{MARKER, setup_sheet};
pub use picture::{Outline, View};
pub use sheet::Sheet;
