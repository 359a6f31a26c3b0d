//! Finds the physics that a fit left out: where, what, how much, how sure. It simulates through the same effects as every other room.

mod floor;
mod ground;
mod library;
mod search;
mod stage;
mod thin;

pub use ground::{Column, Ground, Term};
pub use library::{Family, families, terms};
pub use search::{Candidate, Found, Grounds, Search, search};
pub use stage::{Judgement, Stage};
pub use thin::thin;
