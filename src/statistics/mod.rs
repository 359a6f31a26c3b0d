//! Statistics without geometry and sessions: noise and whitening, robust location and scale, digits, products and principal components of columns, evidence.

mod digits;
mod evidence;
mod minimum;
mod moments;
mod noise;
mod noise_model;
mod principal;
mod products;
mod robust;
mod whitener;

pub use digits::{ON_STEP, step_of};
pub use evidence::{BlockEvidence, climbed, implausibility, judge, likeliest_priors, log_determinant, probability_of};
pub use minimum::{Least, least_along, minimise_few, minimise_smooth};
pub use moments::{Fitted, mean, rms, standard_deviation};
pub use noise::{Absorbed, fit_noise, misfit};
pub use noise_model::{NOISE_FLOOR_MM, NoiseModel};
pub use principal::principal;
pub use products::{Factor, ROW_STEP, add_cross_products, add_products, add_products_with, weighted_products};
pub use robust::{OF_THIRD_DIFFERENCES, median, noise_of_rows, robust_sigma, third_differences};
pub use whitener::Whitener;
