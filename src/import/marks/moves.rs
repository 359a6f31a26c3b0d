//! When the moves of marks ended, how fast they were and how long they took to slow down, fitted to the readings of each move's
//! second half and of the rest behind it. Which readings those are is found in `marks`.
//!
//! `y = level − s·r(t_e − t)`, s the sense of the move, `r(u)` the way that is left u before its end: `v·w·g(u/w)` while the
//! control slows down (u < w), `v·(u − w/2)` before. v and w are the same for all moves. `g(x) = x²/2` where the speed falls
//! evenly, `x/2 − sin(πx)/2π` where it falls as a squared sine; the readings say which. The begin of a move is not used: lost
//! motion delays it.
//!
//! Servos lag: axes follow the command by `τẋ = c − x`, τ the same for all axes and moves. What is left of the way is then
//! `r + τV`, V the speed that lags. A lag delays whatever is steady by τ, as a gauge's clock may: an end stands here for the
//! command's end plus τ, so that times of moves and of runs keep one zero, and only the tails behind ends tell τ.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use crate::import::likelihood::RampKind;
use crate::import::timing::lag::{LAG, Lag};
use crate::statistics::{mean, minimise_few};

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
    /// End of each move, s: of its command, later by the lag.
    pub end_s: Vec<f64>,
    /// Speed, mm/s.
    pub speed: f64,
    ramp: Ramp,
    /// Covariance of the ends, s², then speed, ramp and lag.
    covariance: DMatrix<f64>,
}

/// Two kinds of control: the acceleration of slides of 0.2 to 1 m/s² at the speed of a mark, and a time constant whatever the speed.
const KINDS: [RampKind; 2] =
    [RampKind { share: 0.8, middle_s: 4e-3, spread: 0.7 }, RampKind { share: 0.2, middle_s: 0.12, spread: 0.6 }];
/// Ramps from which the search begins, s.
const RAMPS_S: [f64; 2] = [0.005, 0.15];
/// Lags from which the search begins, s.
const LAGS_S: [f64; 2] = [0.0, 0.03];
/// How well the first guess of an end is known where readings of its move are missing, s.
const GUESS_S: f64 = 0.05;
/// Longest step of the search for an end, s: a ramp of most controls.
const LONGEST_STEP_S: f64 = 0.1;
/// Gauss–Newton steps for end and level of one move, and a step after which none is worth while, s.
const STEPS: usize = 6;
const SETTLED_S: f64 = 1e-7;

impl Moves {
    /// Time in which a move comes to rest, s.
    pub fn ramp_s(&self) -> f64 {
        self.ramp.lasts_s
    }

    /// Time constant of the servos' lag, s.
    pub fn lag_s(&self) -> f64 {
        self.ramp.lag.0
    }

    /// Standard deviation of `end[k] + by_speed·speed + by_ramp·ramp`, s.
    pub fn sigma(&self, k: usize, by_speed: f64, by_ramp: f64) -> f64 {
        let ends = self.end_s.len();
        let mut way = DVector::zeros(ends + SHARED);
        (way[k], way[ends], way[ends + 1]) = (1.0, by_speed, by_ramp);
        (way.transpose() * &self.covariance * &way)[(0, 0)].max(0.0).sqrt()
    }

    /// Standard deviation of the speed, mm/s.
    pub fn speed_sigma(&self) -> f64 {
        let k = self.end_s.len();
        self.covariance[(k, k)].max(0.0).sqrt()
    }

    /// Standard deviation of the lag, s.
    pub fn lag_sigma_s(&self) -> f64 {
        let k = self.end_s.len() + 2;
        self.covariance[(k, k)].max(0.0).sqrt()
    }
}

/// How a control slows down, and how the axes follow.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    lasts_s: f64,
    /// As a squared sine, else evenly.
    smooth: bool,
    lag: Lag,
    /// How long the move is commanded, s: it speeds up as it slows down.
    whole_s: f64,
}

impl Ramp {
    /// Way left `before_s` before the command's end, over the speed, s, and the speed commanded, over that of the move.
    fn commanded(self, before_s: f64) -> (f64, f64) {
        let x = before_s / self.lasts_s;
        if before_s <= 0.0 {
            (0.0, 0.0)
        } else if x >= 1.0 {
            (before_s - 0.5 * self.lasts_s, 1.0)
        } else if self.smooth {
            (self.lasts_s * (0.5 * x - (PI * x).sin() / (2.0 * PI)), 0.5 * (1.0 - (PI * x).cos()))
        } else {
            (0.5 * self.lasts_s * x * x, x)
        }
    }

    /// The speed that lags, over that of the move.
    fn speed(self, before_s: f64) -> f64 {
        if self.lag.0 < Lag::NONE_S {
            return self.commanded(before_s).1;
        }
        // what it still lacks since the move began falls as what it has left once the move ends
        self.slowing(self.lasts_s - before_s) - self.slowing(self.whole_s - before_s)
    }

    /// The lagging speed after a command has begun to slow down from even speed, over that.
    fn slowing(self, since_s: f64) -> f64 {
        let lag_s = self.lag.0;
        if since_s <= 0.0 {
            return 1.0;
        }
        let within_s = since_s.min(self.lasts_s);
        let decay = (-within_s / lag_s).exp();
        let at_end = if self.smooth {
            let rate = PI / self.lasts_s;
            let (sin, cos) = (rate * within_s).sin_cos();
            let square = (rate * lag_s).powi(2);
            0.5 * (1.0 + (cos + rate * lag_s * sin + square * decay) / (1.0 + square))
        } else {
            1.0 - (within_s - lag_s * (1.0 - decay)) / self.lasts_s
        };
        at_end * (-(since_s - within_s) / lag_s).exp()
    }
}

/// Way left `before_s` before the end, over the speed, s, and the speed over that of the move.
fn left_s(before_s: f64, ramp: Ramp) -> (f64, f64) {
    // an end is that of the command plus the lag
    let before_s = before_s - ramp.lag.0;
    let speed = ramp.speed(before_s);
    (ramp.commanded(before_s).0 + ramp.lag.0 * speed, speed)
}

/// Way left `before_s` before the end, mm, with its derivatives by `before_s`, by the speed, by the ramp and by the lag.
fn left(before_s: f64, speed: f64, ramp: Ramp) -> [f64; 5] {
    let (way_s, rate) = left_s(before_s, ramp);
    let step_s = 1e-2 * ramp.lasts_s;
    let longer = left_s(before_s, Ramp { lasts_s: ramp.lasts_s + step_s, ..ramp }).0;
    let lag_step_s = 5e-4;
    let later = left_s(before_s, Ramp { lag: Lag(ramp.lag.0 + lag_step_s), ..ramp }).0;
    [speed * way_s, speed * rate, way_s, speed * (longer - way_s) / step_s, speed * (later - way_s) / lag_step_s]
}

/// Parameters that all moves share: speed, ramp and lag.
const SHARED: usize = 3;

/// End and level of one move at a speed and a ramp, and the squares that are left.
fn ended(half: &SecondHalf, speed: f64, ramp: Ramp) -> (f64, f64, f64) {
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| mean(half.rows.iter().map(of)).unwrap_or(f64::NAN);
    let mut end_s = half.end_s + 0.5 * ramp.lasts_s;
    let mut level = mean(&|row| row.1 + half.sense * speed * left_s(end_s - row.0, ramp).0);
    for _ in 0..STEPS {
        let (mut aa, mut ab, mut bb, mut ar, mut br) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for &(time, value) in &half.rows {
            let (way_s, rate) = left_s(end_s - time, ramp);
            let (off, by_end) = (value - level + half.sense * speed * way_s, -half.sense * speed * rate);
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
        // beyond a ramp the readings know nothing of the slope
        let step = (aa * br - ab * ar) / determinant;
        end_s += step.clamp(-LONGEST_STEP_S, LONGEST_STEP_S);
        if step.abs() < SETTLED_S {
            break;
        }
    }
    let squares = half.rows.iter().map(|row| row.1 - level + half.sense * speed * left_s(end_s - row.0, ramp).0);
    (end_s, level, squares.map(|off| off * off).sum())
}

/// Minus twice the logarithm of a ramp's prior density, and the standard deviation of its logarithm there.
fn prior(ramp_s: f64) -> (f64, f64) {
    let [first, second] = KINDS.each_ref().map(|kind| kind.density(ramp_s));
    let likeliest = if first > second { KINDS[0].spread } else { KINDS[1].spread };
    (-2.0 * (first + second).max(f64::MIN_POSITIVE).ln(), likeliest)
}

/// Ends, speed and ramp of all moves of `move_mm`; `speed` is a first guess, mm/s, `sigma_mm` the noise of a reading. `None`
/// where the readings do not determine them.
pub(super) fn ends_of(halves: &[SecondHalf], move_mm: f64, speed: f64, sigma_mm: f64) -> Option<Moves> {
    let starts = [false, true].into_iter().flat_map(|smooth| {
        let of_ramp =
            move |lasts_s: f64| LAGS_S.map(|lag_s| Ramp { lasts_s, smooth, lag: Lag(lag_s), whole_s: f64::INFINITY });
        RAMPS_S.into_iter().flat_map(of_ramp)
    });
    ends_from(halves, move_mm, (speed, sigma_mm), starts)
}

/// The same of some of the moves, sought from what all of them told.
pub(super) fn ends_of_some(halves: &[SecondHalf], move_mm: f64, all: &Moves, sigma_mm: f64) -> Option<Moves> {
    ends_from(halves, move_mm, (all.speed, sigma_mm), std::iter::once(all.ramp))
}

fn ends_from(
    halves: &[SecondHalf],
    move_mm: f64,
    (speed, sigma_mm): (f64, f64),
    starts: impl Iterator<Item = Ramp>,
) -> Option<Moves> {
    let at = |x: &[f64; 3], ramp: Ramp| {
        let lag = LAG.off(ramp.lag, x[2]);
        let speed = speed * (0.1 * x[0]).exp();
        (speed, {
            let lasts_s = ramp.lasts_s * x[1].exp();
            Ramp { lasts_s, lag, whole_s: move_mm.abs() / speed + lasts_s, ..ramp }
        })
    };
    let cost = |x: &[f64; 3], ramp: Ramp| {
        let (speed, ramp) = at(x, ramp);
        let squares: f64 = halves.iter().map(|half| ended(half, speed, ramp).2).sum();
        squares / (sigma_mm * sigma_mm) + prior(ramp.lasts_s).0 + LAG.cost(ramp.lag)
    };
    let (ramp, x) = starts
        .map(|ramp| (ramp, minimise_few([0.0; 3], 0.2, |x| cost(x, ramp))))
        .min_by(|one, other| cost(&one.1, one.0).total_cmp(&cost(&other.1, other.0)))?;
    let (speed, ramp) = at(&x, ramp);
    let ramp_s = ramp.lasts_s;
    let solved: Vec<(f64, f64, f64)> = halves.iter().map(|half| ended(half, speed, ramp)).collect();
    let end_s: Vec<f64> = solved.iter().map(|(end, ..)| *end).collect();
    let rows: usize = halves.iter().map(|half| half.rows.len()).sum();
    let squares: f64 = solved.iter().map(|(.., squares)| squares).sum();
    // columns: ends, speed, ramp, lag, levels
    let ends = halves.len();
    let width = 2 * ends + SHARED;
    let mut normal = DMatrix::zeros(width, width);
    for (k, half) in halves.iter().enumerate() {
        for &(time, _) in &half.rows {
            let [_, slope, by_speed, by_ramp, by_lag] =
                left(end_s[k] - time, speed, ramp).map(|value| -half.sense * value);
            let columns =
                [(k, slope), (ends, by_speed), (ends + 1, by_ramp), (ends + 2, by_lag), (ends + SHARED + k, 1.0)];
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
    normal[(ends + 2, ends + 2)] += LAG.sigma_s.powi(-2);
    let covariance = normal.cholesky()?.inverse().view((0, 0), (ends + SHARED, ends + SHARED)).into_owned();
    let is_found = speed > 0.0 && end_s.iter().all(|end| end.is_finite());
    is_found.then_some(Moves { end_s, speed, ramp, covariance })
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
            .map(|time| (time, 7.0 - sense * left_s(end_s - time, ramp).0))
            .collect();
        SecondHalf { rows, sense, end_s: end_s - 0.5 * ramp.lasts_s + 0.003 }
    }

    #[test]
    fn slow_moves_end_when_the_machine_stands() {
        for (ramp_s, smooth, lag_s) in [
            (0.003, false, 0.0),
            (0.1, true, 0.0),
            (0.29, false, 0.0),
            (0.29, true, 0.0),
            (0.003, false, 0.03),
            (0.1, false, 0.05),
            (0.1, true, 0.02),
        ] {
            let lag = Lag(lag_s);
            for step_s in [0.002, 0.03] {
                let due = [1.0, 2.013, 9.38, 10.1];
                let halves: Vec<SecondHalf> = due
                    .iter()
                    .zip([1.0, -1.0, 1.0, -1.0])
                    .map(|(end, sense)| {
                        half(*end, sense, Ramp { lasts_s: ramp_s, smooth, lag, whole_s: 0.4 + ramp_s }, step_s)
                    })
                    .collect();
                let moves = ends_of(&halves, 0.4, 1.04, 2e-4).expect("determined");
                for (k, (end, due)) in moves.end_s.iter().zip(due).enumerate() {
                    let off = end - due;
                    assert!(off.abs() < 3.0 * moves.sigma(k, 0.0, 0.0) + 1e-4, "{ramp_s} {lag_s} {step_s}: {off}");
                    // a ramp that falls between two readings moves an end by half of it
                    let most = 2e-3 + 0.2 * step_s;
                    assert!(
                        moves.sigma(k, 0.0, 0.0) < most,
                        "{ramp_s} {lag_s} {step_s}: ± {}",
                        moves.sigma(k, 0.0, 0.0)
                    );
                }
                assert!((moves.speed - 1.0).abs() < 5e-3, "{}", moves.speed);
            }
        }
    }
}
