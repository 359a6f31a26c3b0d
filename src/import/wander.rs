//! The slow wander of a gauge and of what no model holds: an Ornstein–Uhlenbeck process beside white noise, and the filter that whitens
//! both. It knows no timing.
//!
//! `y = … + a + w`: a with standard deviation `size_mm`, correlated as `e^(−Δt/memory_s)`; w white. Readings that wander together
//! are worth few: taken for white, a wander of 0.2 µm reads as the form of another pace.

/// A wander.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wander {
    /// Standard deviation, mm.
    pub size_mm: f64,
    /// Time after which its correlation has fallen to 1/e, s.
    pub memory_s: f64,
}

/// What gauges are known for at usual feeds.
const USUAL: Wander = Wander { size_mm: 0.2e-3, memory_s: 1.2 };
/// Standard deviations of the logarithms of size and memory: a machine's forms that no model holds count as wander.
const SPREADS: [f64; 2] = [1.5, 0.7];

impl Default for Wander {
    fn default() -> Wander {
        USUAL
    }
}

impl Wander {
    /// The usual wander with logarithms of its size and memory so many spreads off.
    pub fn off(by: &[f64; 2]) -> Wander {
        let [size, memory] = [0, 1].map(|k| (SPREADS[k] * by[k]).exp());
        Wander { size_mm: USUAL.size_mm * size, memory_s: USUAL.memory_s * memory }
    }

    /// Minus twice the logarithm of its prior density.
    pub fn cost(self) -> f64 {
        self.spreads().map(|off| off * off).iter().sum()
    }

    /// Its logarithms in spreads from the usual ones; the inverse of [`Wander::off`].
    pub fn spreads(self) -> [f64; 2] {
        let off = [self.size_mm / USUAL.size_mm, self.memory_s / USUAL.memory_s].map(f64::ln);
        [off[0] / SPREADS[0], off[1] / SPREADS[1]]
    }
}

/// One row's share in the filter.
#[derive(Debug, Clone, Copy)]
struct Gain {
    /// Part of the wander that remains since the row before.
    rho: f64,
    /// Part of an innovation that is wander.
    gain: f64,
    /// One over the innovation's standard deviation, 1/mm.
    scale: f64,
}

/// The filter that makes rows at given times independent with unit variance.
#[derive(Debug, Clone)]
pub(super) struct Filter {
    gains: Vec<Gain>,
    /// Logarithm of the determinant of the rows' covariance.
    pub log_determinant: f64,
}

impl Filter {
    /// For rows at `time_s` with white noise `white_mm`.
    pub fn of(wander: Wander, time_s: &[f64], white_mm: &[f64]) -> Filter {
        let (mut variance, mut log_determinant) = (wander.size_mm.powi(2), 0.0);
        let mut before = time_s.first().copied().unwrap_or(0.0);
        let row = |(&time, &white): (&f64, &f64)| {
            let rho = (-(time - before) / wander.memory_s).exp();
            before = time;
            variance = rho * rho * variance + (1.0 - rho * rho) * wander.size_mm.powi(2);
            let innovation = variance + white * white;
            let gain = variance / innovation;
            variance *= 1.0 - gain;
            log_determinant += innovation.ln();
            Gain { rho, gain, scale: innovation.sqrt().recip() }
        };
        let gains = time_s.iter().zip(white_mm).map(row).collect();
        Filter { gains, log_determinant }
    }

    /// Whitens columns in place, `width` of them, row by row.
    pub fn apply(&self, rows: &mut [f64], width: usize) {
        let mut wander = vec![0.0; width];
        for (row, Gain { rho, gain, scale }) in rows.chunks_exact_mut(width).zip(&self.gains) {
            for (value, wander) in row.iter_mut().zip(&mut wander) {
                let expected = rho * *wander;
                let innovation = *value - expected;
                *wander = expected + gain * innovation;
                *value = scale * innovation;
            }
        }
    }
}
