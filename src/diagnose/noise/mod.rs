//! Noise of recordings and poses whatever physics is missing, and its lines in time.

pub(crate) mod noise_floor;
pub(crate) mod pose_noise;
pub(crate) mod spectrum;
pub(crate) mod zero_walk;
