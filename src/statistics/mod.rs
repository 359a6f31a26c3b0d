//! Statistics without geometry and sessions: noise and whitening, robust location and scale, products and principal components of columns, evidence.

mod evidence;
mod minimum;
mod noise;
mod principal;
mod products;
mod robust;

pub use evidence::{BlockEvidence, climbed, judge, likeliest_prior, log_determinant};
pub use minimum::{least_along, minimise_few};
pub use noise::{Absorbed, NOISE_FLOOR_MM, NoiseModel, Whitener, fit_noise, misfit};
pub use principal::principal;
pub use products::{Factor, ROW_STEP, add_cross_products, add_products, weighted_products};
pub use robust::{median, noise_of_rows, rms, robust_sigma};
