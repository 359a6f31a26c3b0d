//! One machine over months: how its errors moved, told from what the sessions could see.
//!
//! Each error's values over time are explained by a constant, a line over time (drift) or a constant with one step, by
//! the sessions' own standard deviations and one scatter between sessions, over which is averaged. Of the three the likeliest is
//! told, when its odds against the constant are high enough.

mod trend;

pub use trend::{Course, Point, Trend, trend};
