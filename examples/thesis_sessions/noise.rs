//! What a ball bar adds to a true length, in the time domain: white and correlated scatter, slow drift, 0.1 µm steps.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// White part of a reading, 1 sigma.
pub const WHITE_UM: f64 = 0.15;
/// First-order autoregressive part, stationary 1 sigma.
pub const CORRELATED_UM: f64 = 0.15;
/// Time over which the correlated part forgets.
pub const CORRELATION_S: f64 = 1.2;
/// Random walk of the zero, per square root of a second (0.3 µm in an hour).
pub const WALK_UM_PER_ROOT_S: f64 = 0.005;
/// Warm-up of the bar over the session, 1 sigma of its final size.
pub const WARM_UP_UM: f64 = 0.3;
/// Time constant of the warm-up.
pub const WARM_UP_S: f64 = 2400.0;
/// Step of the instrument's reading.
pub const RESOLUTION_MM: f64 = 0.0001;

pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// One bar over one session: remembers its drift from run to run.
pub struct Instrument {
    random: ChaCha8Rng,
    warm_up_um: f64,
    walk_um: f64,
    correlated_um: f64,
    now_s: f64,
}

impl Instrument {
    pub fn new(mut random: ChaCha8Rng) -> Instrument {
        let warm_up_um = WARM_UP_UM * normal(&mut random);
        Instrument { random, warm_up_um, walk_um: 0.0, correlated_um: 0.0, now_s: 0.0 }
    }

    /// Reading of a true length at a session time; times must not go backwards.
    pub fn read_mm(&mut self, time_s: f64, true_mm: f64) -> f64 {
        let step_s = time_s - self.now_s;
        self.now_s = time_s;
        self.walk_um += WALK_UM_PER_ROOT_S * step_s.sqrt() * normal(&mut self.random);
        let kept = (-step_s / CORRELATION_S).exp();
        let fresh = CORRELATED_UM * (1.0 - kept * kept).sqrt() * normal(&mut self.random);
        self.correlated_um = kept * self.correlated_um + fresh;
        let warm_up_um = self.warm_up_um * (1.0 - (-time_s / WARM_UP_S).exp());
        let white_um = WHITE_UM * normal(&mut self.random);
        let error_um = warm_up_um + self.walk_um + self.correlated_um + white_um;
        let reading_mm = true_mm + error_um * 1e-3;
        (reading_mm / RESOLUTION_MM).round() * RESOLUTION_MM
    }
}
