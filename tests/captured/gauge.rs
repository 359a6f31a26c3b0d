//! A machine with errors of its own under balls placed by hand, and the gauge between them; kinematics of the tests' own.

use std::collections::BTreeMap;

use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::session::{Ball, Test};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::super::plain_machine::{Plain, distance};

/// Standard deviations with which pivots and spindle balls are placed, and a bar is calibrated, mm.
const PLACED_MM: [f64; 3] = [20e-3, 3e-3, 0.5e-3];
/// Noise of a reading: white, and with a memory of some seconds, mm.
const WHITE_MM: f64 = 0.15e-3;
const SLOW_MM: f64 = 0.15e-3;
const MEMORY_S: f64 = 1.2;
/// Step of readings, mm.
const STEP_MM: f64 = 1e-4;

/// One machine with its errors, and where balls and bars of a session were found to be.
pub struct Erring {
    machine: Machine,
    random: ChaCha8Rng,
    placed: BTreeMap<String, [f64; 3]>,
    /// Part of the usual offsets with which balls and bars are placed.
    part: f64,
}

impl Erring {
    /// Some tens of micrometres and arc seconds on rotary axes, some arc seconds on slides.
    pub fn drawn(machine: &Machine, seed: u64) -> Erring {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut machine = machine.clone();
        for axis in &mut machine.axes {
            let is_linear = axis.kind == AxisKind::Linear;
            for (k, error) in axis.location_errors.iter_mut().enumerate() {
                let most = if k < 3 { 0.03 } else { 1e-4 };
                // a slide is not displaced, and its own lie is the machine's
                *error += if is_linear && k < 3 {
                    0.0
                } else {
                    random.random_range(-most..most) * if is_linear { 0.3 } else { 1.0 }
                };
            }
        }
        Erring { machine, random, placed: BTreeMap::new(), part: 1.0 }
    }

    /// The same with a part of each error: sweeps of one axis are nearly flat.
    pub fn by_part(machine: &Machine, seed: u64, part: f64) -> Erring {
        let mut erring = Erring::drawn(machine, seed);
        for (axis, nominal) in erring.machine.axes.iter_mut().zip(&machine.axes) {
            for (error, nominal) in axis.location_errors.iter_mut().zip(&nominal.location_errors) {
                *error = nominal + part * (*error - nominal);
            }
        }
        Erring { part, ..erring }
    }

    /// Deviations from the bar's stated length, mm.
    pub fn read(
        &mut self,
        nominal: &Machine,
        test: &Test,
        times_s: &[f64],
        positions: &[Vec<f64>],
        random: &mut ChaCha8Rng,
    ) -> Vec<f64> {
        assert_eq!(nominal.axes.len(), self.machine.axes.len());
        let pivot = self.placed(&test.pivot, PLACED_MM[0]);
        let spindle = self.placed(&test.spindle_ball, PLACED_MM[1]);
        let bar_mm = test.bar_length_mm.expect("planned");
        let [off_mm, ..] = self.off(&format!("bar {bar_mm}"), PLACED_MM[2]);
        let plain = Plain { machine: &self.machine, errs: true, tip: [0.0; 3], axis: [0.0, 0.0, 1.0] };
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let mut slow = SLOW_MM * normal();
        let mut before = times_s.first().copied().unwrap_or(0.0);
        times_s
            .iter()
            .zip(positions)
            .map(|(time, q)| {
                let memory = (-(time - before) / MEMORY_S).exp();
                slow = memory * slow + SLOW_MM * (1.0 - memory * memory).sqrt() * normal();
                before = *time;
                let ends = [(&test.pivot.link, pivot), (&test.spindle_ball.link, spindle)];
                let [one, other] = ends.map(|(link, at)| plain.ball(link, at, q));
                let reading = distance(one, other) - bar_mm + off_mm + slow + WHITE_MM * normal();
                (reading / STEP_MM).round() * STEP_MM
            })
            .collect()
    }

    fn placed(&mut self, ball: &Ball, spread_mm: f64) -> [f64; 3] {
        let off = self.off(&format!("{} {:?}", ball.link, ball.at), spread_mm);
        std::array::from_fn(|k| ball.at[k] + ball.sign(k) * off[k])
    }

    /// The placement of a thing, drawn when it is first mounted.
    fn off(&mut self, name: &str, spread_mm: f64) -> [f64; 3] {
        let (random, spread_mm) = (&mut self.random, self.part * spread_mm);
        let draw = || {
            std::array::from_fn(|_| -> f64 {
                spread_mm * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, random)
            })
        };
        *self.placed.entry(name.to_string()).or_insert_with(draw)
    }
}
