//! The candidates of a search: which effect at which place through which outlets, over which grid of shapes. It judges nothing.

mod catalogue;
mod curves;
mod family;
mod growth;
mod lifts;
mod linear;
mod motions;
mod play;
mod poses;
mod rotary;
mod setups;
mod spindles;
mod vibrations;

pub use self::catalogue::families;
pub use self::family::{ALONG, CandidateFamily, Refined, family_terms, terms};
pub(crate) use self::motions::{travelled, visited};
