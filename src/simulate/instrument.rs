//! A real length gauge: resolution, stroke and noise laid over ideal traces. It knows no geometry and reads no files.
//!
//! `reading = round((L + w + a + d) / resolution) · resolution`: white noise w; correlated noise a, an
//! Ornstein–Uhlenbeck process sampled at the times of the rows, `ρ = e^(−Δt/τ)`; drift d, a random walk that starts
//! at zero with every test.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::trace::Trace;
use crate::session::Session;

/// A length gauge as its data file describes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instrument {
    /// Step of the readings, mm; zero: as fine as numbers are.
    pub resolution_mm: f64,
    /// Shortest and longest reading relative to the bar's length, mm; gauges without a bar have no limit.
    pub stroke_mm: (f64, f64),
    /// Standard deviation of the white noise, mm.
    pub white_mm: f64,
    /// Standard deviation of the correlated noise, mm.
    pub correlated_mm: f64,
    /// Time after which its correlation has fallen to 1/e, s.
    pub correlation_time_s: f64,
    /// Standard deviation of the drift after one second, mm; it grows with the root of time.
    pub drift_mm_per_sqrt_s: f64,
}

impl Default for Instrument {
    /// Resolution and stroke as makers of wireless ball bars state them (0.1 µm, ±1 mm); noise as in recordings at
    /// 500 mm/min: 0.15 µm white, 0.15 µm correlated over 1.2 s, a drift of 0.2 µm in a trace of 100 s.
    fn default() -> Instrument {
        Instrument {
            resolution_mm: 1e-4,
            stroke_mm: (-1.0, 1.0),
            white_mm: 0.15e-3,
            correlated_mm: 0.15e-3,
            correlation_time_s: 1.2,
            drift_mm_per_sqrt_s: 0.02e-3,
        }
    }
}

/// Why an instrument cannot record a trace.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InstrumentError {
    #[error(
        "test '{test}', row {row}: length {length_mm:.4} mm is {by_mm:.4} mm {side} the stroke of the {bar_mm} mm bar ({from_mm:.4} to {to_mm:.4} mm); move the pivot or choose another bar"
    )]
    OutsideStroke {
        test: String,
        /// From 1, the header not counted.
        row: usize,
        length_mm: f64,
        by_mm: f64,
        side: &'static str,
        bar_mm: f64,
        from_mm: f64,
        to_mm: f64,
    },
}

impl Instrument {
    /// What the instrument reads of ideal traces; `traces` are those of the session's tests, in its order.
    ///
    /// Every test has a random stream of its own, by its place in the session: adding one behind the others leaves their readings as they
    /// were.
    pub fn read(&self, session: &Session, mut traces: Vec<Trace>, seed: u64) -> Result<Vec<Trace>, InstrumentError> {
        for (index, trace) in traces.iter_mut().enumerate() {
            let mut random = stream(seed, NOISE_STREAMS + index as u64);
            self.disturb(trace, &mut random);
            if let Some(bar_mm) = session.tests[index].bar_length_mm {
                self.check_stroke(trace, bar_mm)?;
            }
        }
        Ok(traces)
    }

    fn disturb(&self, trace: &mut Trace, random: &mut ChaCha8Rng) {
        let mut draw = || -> f64 { StandardNormal.sample(random) };
        let (mut correlated, mut drift) = (self.correlated_mm * draw(), 0.0);
        let time_s = trace.motion.time_s.clone();
        for (row, length_mm) in trace.length_mm.iter_mut().enumerate() {
            if row > 0 {
                // static poses have no common time: every reading stands for itself
                let step_s = time_s.as_ref().map_or(f64::INFINITY, |time| (time[row] - time[row - 1]).max(0.0));
                let rho = (-step_s / self.correlation_time_s).exp();
                correlated = rho * correlated + self.correlated_mm * (1.0 - rho * rho).sqrt() * draw();
                if step_s.is_finite() {
                    drift += self.drift_mm_per_sqrt_s * step_s.sqrt() * draw();
                }
            }
            *length_mm += self.white_mm * draw() + correlated + drift;
            if self.resolution_mm > 0.0 {
                *length_mm = (*length_mm / self.resolution_mm).round() * self.resolution_mm;
            }
        }
    }

    fn check_stroke(&self, trace: &Trace, bar_mm: f64) -> Result<(), InstrumentError> {
        let (from_mm, to_mm) = (bar_mm + self.stroke_mm.0, bar_mm + self.stroke_mm.1);
        for (row, &length_mm) in trace.length_mm.iter().enumerate() {
            let (by_mm, side) =
                if length_mm < from_mm { (from_mm - length_mm, "below") } else { (length_mm - to_mm, "above") };
            if by_mm > 0.0 {
                let (test, row) = (trace.test.clone(), row + 1);
                return Err(InstrumentError::OutsideStroke {
                    test,
                    row,
                    length_mm,
                    by_mm,
                    side,
                    bar_mm,
                    from_mm,
                    to_mm,
                });
            }
        }
        Ok(())
    }
}

/// Random streams of setups lie below those of noise.
const NOISE_STREAMS: u64 = 1 << 32;

/// A reproducible stream of random numbers.
pub(super) fn stream(seed: u64, index: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(index);
    random
}
