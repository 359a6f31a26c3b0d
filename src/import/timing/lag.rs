//! How axes follow their commands: servos lag by a time constant, the same for all axes of a machine, or it would cut no round
//! circles. `τẋ = c − x`. It knows no course.

/// A time constant, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lag(pub f64);

impl Lag {
    /// Lags shorter than this are none, s: a tenth of a servo's cycle.
    pub const NONE_S: f64 = 1e-4;

    /// What a speed that has risen evenly for `since_s`, at one a second, lags to: `t − τ(1 − e^(−t/τ))`.
    pub fn of_rising(self, since_s: f64) -> f64 {
        if since_s <= 0.0 {
            0.0
        } else if self.0 < Lag::NONE_S {
            since_s
        } else {
            since_s + self.0 * (-since_s / self.0).exp_m1()
        }
    }

    /// How long after its end a move at `speed` still has more than `left_mm` to go, s: `vτe^(−t/τ)` behind the command's end, which an
    /// end stands for that is later by the lag.
    pub fn tail_s(self, speed: f64, left_mm: f64) -> f64 {
        let behind = (speed * self.0 / left_mm).max(1.0).ln() - 1.0;
        self.0 * behind.max(0.0)
    }
}

/// What is thought of lags before any reading.
pub(crate) struct LagPrior {
    /// Standard deviation of half a normal density, s.
    pub sigma_s: f64,
}

/// Servos with position gains of 16 to 70 1/s, as machines have them without feed-forward, lag by 15 to 60 ms; with it, by few.
/// Half a normal density has a third below 13 ms and a twentieth beyond 60.
pub(crate) const LAG: LagPrior = LagPrior { sigma_s: 0.03 };
/// Longest lag that is sought, s: loops with a gain below 8 1/s cut no corner.
const LONGEST_S: f64 = 0.12;

impl LagPrior {
    /// A lag so many spreads from another, none below zero.
    pub fn off(&self, from: Lag, spreads: f64) -> Lag {
        Lag((from.0 + self.sigma_s * spreads).abs().min(LONGEST_S))
    }

    /// Minus twice the logarithm of its prior density.
    pub fn cost(&self, lag: Lag) -> f64 {
        (lag.0 / self.sigma_s).powi(2)
    }
}
