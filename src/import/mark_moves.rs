//! When the moves of marks ended, how fast they were and how long they took to slow down, fitted to the readings of each move's
//! second half and of the rest behind it. Which readings those are is found in `marks`.
//!
//! `y = level − s·r(t_e − t)`, s the sense of the move, `r(u)` the way that is left u before its end: `v·w·g(u/w)` while the
//! control slows down (u < w), `v·(u − w/2)` before. v and w are the same for all moves. `g(x) = x²/2` where the speed falls
//! evenly, `x/2 − sin(πx)/2π` where it falls as a squared sine; the readings say which. The begin of a move is not used: lost
//! motion delays it.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use crate::statistics::minimise_few;

/// The second half of a move and the rest behind it.
pub(super) struct SecondHalf {
    /// Times, s, and readings, mm.
    pub rows: Vec<(f64, f64)>,
    /// +1 where the readings grow.
    pub sense: f64,
    /// First guess of its end, s, for a control that needs no time to slow down.
    pub end_s: f64,
}

/// What the moves tell together.
pub(super) struct Moves {
    /// End of each move, s.
    pub end_s: Vec<f64>,
    /// Speed, mm/s.
    pub speed: f64,
    /// Time in which a move comes to rest, s.
    pub ramp_s: f64,
    /// Covariance of the ends, s², then speed and ramp.
    covariance: DMatrix<f64>,
}

/// Two kinds of control, with the share of each and the middle, s, and the standard deviation of the logarithm of their ramps: the
/// acceleration of slides of 0.2 to 1 m/s² at the speed of a mark, and a time constant whatever the speed.
const KINDS: [(f64, f64, f64); 2] = [(0.8, 4e-3, 0.7), (0.2, 0.12, 0.6)];
/// Ramps from which the search begins, s.
const RAMPS_S: [f64; 2] = [0.005, 0.15];
/// How well the first guess of an end is known where readings of its move are missing, s.
const GUESS_S: f64 = 0.05;
/// Gauss–Newton steps for end and level of one move.
const STEPS: usize = 6;

impl Moves {
    /// Standard deviation of `end[k] + by_speed·speed + by_ramp·ramp`, s.
    pub fn sigma(&self, k: usize, by_speed: f64, by_ramp: f64) -> f64 {
        let ends = self.end_s.len();
        let mut way = DVector::zeros(ends + 2);
        (way[k], way[ends], way[ends + 1]) = (1.0, by_speed, by_ramp);
        (way.transpose() * &self.covariance * &way)[(0, 0)].max(0.0).sqrt()
    }

    /// Standard deviation of the speed, mm/s.
    pub fn speed_sigma(&self) -> f64 {
        let k = self.end_s.len();
        self.covariance[(k, k)].max(0.0).sqrt()
    }
}

/// How a control slows down.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    lasts_s: f64,
    /// As a squared sine, else evenly.
    smooth: bool,
}

/// Way left `before_s` before the end, mm, with its derivatives by `before_s`, by the speed and by the ramp.
fn left(before_s: f64, speed: f64, ramp: Ramp) -> [f64; 4] {
    let x = before_s / ramp.lasts_s;
    if before_s <= 0.0 {
        [0.0; 4]
    } else if x < 1.0 {
        let (way, rate) = match ramp.smooth {
            true => (0.5 * x - (PI * x).sin() / (2.0 * PI), 0.5 * (1.0 - (PI * x).cos())),
            false => (0.5 * x * x, x),
        };
        [speed * ramp.lasts_s * way, speed * rate, ramp.lasts_s * way, speed * (way - x * rate)]
    } else {
        let part = before_s - 0.5 * ramp.lasts_s;
        [speed * part, speed, part, -0.5 * speed]
    }
}

/// End and level of one move at a speed and a ramp, and the squares that are left.
fn ended(half: &SecondHalf, speed: f64, ramp: Ramp) -> (f64, f64, f64) {
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| half.rows.iter().map(of).sum::<f64>() / half.rows.len() as f64;
    let mut end_s = half.end_s + 0.5 * ramp.lasts_s;
    let mut level = mean(&|row| row.1 + half.sense * left(end_s - row.0, speed, ramp)[0]);
    for _ in 0..STEPS {
        let (mut aa, mut ab, mut bb, mut ar, mut br) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for &(time, value) in &half.rows {
            let [way, slope, ..] = left(end_s - time, speed, ramp);
            let (off, by_end) = (value - level + half.sense * way, -half.sense * slope);
            aa += 1.0;
            ab += by_end;
            bb += by_end * by_end;
            ar += off;
            br += by_end * off;
        }
        let determinant = aa * bb - ab * ab;
        if determinant <= 1e-9 * aa * bb {
            break;
        }
        level += (bb * ar - ab * br) / determinant;
        // no step longer than the ramp: beyond it the readings know nothing of the slope
        let step = (aa * br - ab * ar) / determinant;
        end_s += step.clamp(-0.1, 0.1);
    }
    let squares = half.rows.iter().map(|row| row.1 - level + half.sense * left(end_s - row.0, speed, ramp)[0]);
    (end_s, level, squares.map(|off| off * off).sum())
}

/// Minus twice the logarithm of a ramp's prior density, and the standard deviation of its logarithm there.
fn prior(ramp_s: f64) -> (f64, f64) {
    let kinds = KINDS.map(|(share, middle_s, spread)| {
        (share / spread * (-0.5 * ((ramp_s / middle_s).ln() / spread).powi(2)).exp(), spread)
    });
    let likeliest = if kinds[0].0 > kinds[1].0 { kinds[0].1 } else { kinds[1].1 };
    (-2.0 * (kinds[0].0 + kinds[1].0).max(f64::MIN_POSITIVE).ln(), likeliest)
}

/// Ends, speed and ramp of all moves; `speed` is a first guess, mm/s, `sigma_mm` the noise of a reading. `None` where the
/// readings do not determine them.
pub(super) fn ends_of(halves: &[SecondHalf], speed: f64, sigma_mm: f64) -> Option<Moves> {
    let at =
        |x: &[f64; 2], ramp: Ramp| (speed * (0.1 * x[0]).exp(), Ramp { lasts_s: ramp.lasts_s * x[1].exp(), ..ramp });
    let cost = |x: &[f64; 2], ramp: Ramp| {
        let (speed, ramp) = at(x, ramp);
        let squares: f64 = halves.iter().map(|half| ended(half, speed, ramp).2).sum();
        squares / (sigma_mm * sigma_mm) + prior(ramp.lasts_s).0
    };
    let (ramp, x) = [false, true]
        .into_iter()
        .flat_map(|smooth| RAMPS_S.map(|lasts_s| Ramp { lasts_s, smooth }))
        .map(|ramp| (ramp, minimise_few([0.0; 2], 0.2, |x| cost(x, ramp))))
        .min_by(|one, other| cost(&one.1, one.0).total_cmp(&cost(&other.1, other.0)))?;
    let (speed, ramp) = at(&x, ramp);
    let ramp_s = ramp.lasts_s;
    let solved: Vec<(f64, f64, f64)> = halves.iter().map(|half| ended(half, speed, ramp)).collect();
    let end_s: Vec<f64> = solved.iter().map(|(end, ..)| *end).collect();
    let rows: usize = halves.iter().map(|half| half.rows.len()).sum();
    let squares: f64 = solved.iter().map(|(.., squares)| squares).sum();
    // columns: ends, speed, ramp, levels
    let ends = halves.len();
    let width = 2 * ends + 2;
    let mut normal = DMatrix::zeros(width, width);
    for (k, half) in halves.iter().enumerate() {
        for &(time, _) in &half.rows {
            let [_, slope, by_speed, by_ramp] = left(end_s[k] - time, speed, ramp).map(|value| -half.sense * value);
            let columns = [(k, slope), (ends, by_speed), (ends + 1, by_ramp), (ends + 2 + k, 1.0)];
            for (i, a) in columns {
                columns.iter().for_each(|(j, b)| normal[(i, *j)] += a * b);
            }
        }
    }
    // a control's form of slowing down is not the model's: what is left says by how much
    let spare = rows.saturating_sub(width).max(1) as f64;
    let variance = (squares / spare).max(sigma_mm * sigma_mm);
    normal /= variance;
    (0..ends).for_each(|k| normal[(k, k)] += GUESS_S.powi(-2));
    normal[(ends + 1, ends + 1)] += (prior(ramp_s).1 * ramp_s).powi(-2);
    let covariance = normal.cholesky()?.inverse().view((0, 0), (ends + 2, ends + 2)).into_owned();
    (speed > 0.0 && end_s.iter().all(|end| end.is_finite())).then_some(Moves { end_s, speed, ramp_s, covariance })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A move of 0.4 mm at 1 mm/s that slows down over `ramp_s`, read every `step_s`.
    fn half(end_s: f64, sense: f64, ramp: Ramp, step_s: f64) -> SecondHalf {
        let middle_s = end_s - 0.5 * (0.4 + ramp.lasts_s);
        let count = ((end_s + 0.3 - middle_s) / step_s) as usize;
        let rows = (0..count)
            .map(|k| middle_s + step_s * k as f64)
            .map(|time| (time, 7.0 - sense * left(end_s - time, 1.0, ramp)[0]))
            .collect();
        SecondHalf { rows, sense, end_s: end_s - 0.5 * ramp.lasts_s + 0.003 }
    }

    #[test]
    fn slow_moves_end_when_the_machine_stands() {
        for (ramp_s, smooth) in [(0.003, false), (0.1, true), (0.29, false), (0.29, true)] {
            for step_s in [0.002, 0.03] {
                let due = [1.0, 2.013, 9.38, 10.1];
                let halves: Vec<SecondHalf> = due
                    .iter()
                    .zip([1.0, -1.0, 1.0, -1.0])
                    .map(|(end, sense)| half(*end, sense, Ramp { lasts_s: ramp_s, smooth }, step_s))
                    .collect();
                let moves = ends_of(&halves, 1.04, 2e-4).expect("determined");
                for (k, (end, due)) in moves.end_s.iter().zip(due).enumerate() {
                    let off = end - due;
                    assert!(off.abs() < 3.0 * moves.sigma(k, 0.0, 0.0) + 1e-4, "{ramp_s} {step_s}: {off}");
                    // a ramp that falls between two readings moves an end by half of it
                    let most = 2e-3 + 0.2 * step_s;
                    assert!(moves.sigma(k, 0.0, 0.0) < most, "{ramp_s} {step_s}: ± {}", moves.sigma(k, 0.0, 0.0));
                }
                assert!((moves.speed - 1.0).abs() < 5e-3, "{}", moves.speed);
            }
        }
    }
}
