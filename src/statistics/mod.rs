//! Statistics without geometry and sessions: noise and whitening, robust location and scale, digits, products and principal components of columns, evidence.

mod digits;
mod evidence;
mod minimum;
mod moments;
mod noise;
mod noise_model;
mod parabolas;
mod principal;
mod products;
mod robust;
mod whitener;

pub(crate) use digits::{ON_STEP, step_of};
pub use evidence::{BlockEvidence, judge, log_determinant};
pub(crate) use evidence::{climbed, implausibility, likeliest_priors, probability_of};
pub use minimum::{Least, minimise_smooth};
pub(crate) use minimum::{least_along, minimise_few};
pub(crate) use moments::standard_deviation;
pub use moments::{Fitted, mean, rms};
pub use noise::{Absorbed, fit_noise, misfit, white_noise};
pub(crate) use noise_model::NOISE_FLOOR_MM;
pub use noise_model::NoiseModel;
pub(crate) use parabolas::{Local, parabolas};
pub(crate) use principal::principal;
pub(crate) use products::{add_cross_products, add_products, add_products_with};
pub use robust::median;
pub(crate) use robust::{OF_THIRD_DIFFERENCES, independent_share, noise_of_rows, robust_sigma, third_differences};
pub use whitener::Whitener;
