//! A run that is not even: held on the way, or with its feed changed there. Shares of a run, no positions.

/// How a run is uneven: at a share of its way it stands for a while, and goes on at another pace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// Where, as a share of the run's way, from 0 to 1.
    pub at: f64,
    /// How long it stands there, s.
    pub held_s: f64,
    /// Pace behind over that before.
    pub ratio: f64,
}

impl Bend {
    pub(crate) const NONE: Bend = Bend { at: 0.5, held_s: 0.0, ratio: 1.0 };

    /// Pace before, way per time, of a run whose whole way takes `whole_s`.
    pub(super) fn before(&self, whole_s: f64) -> f64 {
        (self.at + (1.0 - self.at) / self.ratio) / (whole_s - self.held_s).max(f64::MIN_POSITIVE)
    }

    /// Share of the way gone where an even run of `whole_s` has gone `even`.
    pub(crate) fn gone(&self, even: f64, whole_s: f64) -> f64 {
        if *self == Bend::NONE {
            return even;
        }
        let (time_s, before) = (even * whole_s, self.before(whole_s));
        let reached_s = self.at / before;
        if time_s < reached_s {
            before * time_s
        } else {
            self.at + before * self.ratio * (time_s - reached_s - self.held_s).max(0.0)
        }
    }

    /// The inverse: share of the way of an even run where this one has gone `gone`.
    pub(crate) fn even(&self, gone: f64, whole_s: f64) -> f64 {
        if *self == Bend::NONE {
            return gone;
        }
        let before = self.before(whole_s);
        let time_s = match gone <= self.at {
            true => gone / before,
            false => self.at / before + self.held_s + (gone - self.at) / (before * self.ratio),
        };
        time_s / whole_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bend_keeps_the_ends_and_its_inverse_leads_back() {
        for bend in [Bend { at: 0.3, held_s: 0.5, ratio: 0.9 }, Bend { at: 0.7, held_s: 0.0, ratio: 1.2 }, Bend::NONE] {
            assert!(bend.gone(0.0, 20.0).abs() < 1e-12 && (bend.gone(1.0, 20.0) - 1.0).abs() < 1e-12);
            for k in 0..=20 {
                let gone = f64::from(k) / 20.0;
                assert!((bend.gone(bend.even(gone, 20.0), 20.0) - gone).abs() < 1e-9, "{bend:?} {gone}");
            }
        }
        // half a second at rest of twenty: at the middle of the time of what moves
        let held = Bend { at: 0.5, held_s: 2.0, ratio: 1.0 };
        assert!((held.gone(0.5, 20.0) - 0.5).abs() < 1e-12 && (held.gone(0.45, 20.0) - 0.5).abs() < 1e-12);
        assert!((held.gone(0.4, 20.0) - 0.4 * 20.0 / 18.0).abs() < 1e-12);
    }
}
