//! What the readings as a whole say, and how it is told.

pub(crate) mod claims;
pub(crate) mod diagnosed_session;
pub(crate) mod diagnosis;
pub(crate) mod explanation;
pub(crate) mod irregular_motion;
pub(crate) mod location_errors;
pub(crate) mod recurring;
pub(crate) mod shares;
pub(crate) mod shift_of_one_test;
