//! One machine over months: how its errors moved, told from what the sessions could see.
//!
//! Each error's values over time are explained by a constant, a line over time (drift) or a constant with one step, by
//! weighted least squares with the sessions' own standard deviations and one scatter between sessions. Of the three the one
//! with the least Bayesian information criterion is told, when it beats the constant by a margin.

mod trend;

pub use trend::{Course, Point, Trend, trend};
