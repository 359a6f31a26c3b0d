//! Positions that scatter from row to row as no axis moves, and do not show in the readings: the even motion of the axis takes
//! their place. It knows times, positions and readings of one axis that moves alone, no geometry.
//!
//! Through positions and readings of the same few rows parabolas in time are laid. What they leave of the positions, `q − q̂`,
//! would move a reading by `x = (q − q̂)·L'/q'` if the axis had been there. Readings follow by the share `β = Σ x (L − L̂) / Σ x²`:
//! all of it where the axis moved so, or where only the time is read late; none where the angle was read wrongly. A position with
//! noise flattens what is fitted over it (errors in variables: Fuller, Measurement Error Models, 1987).

use super::recording::{Recording, Scatter};
use super::test::Test;
use crate::statistics::{Local, Neighbours, parabolas, robust_sigma, third_differences};

/// Time before and after a row over which a motion is even, s: about what an axis takes to its speed.
const EVEN: Neighbours = Neighbours::Within(0.5);
/// Rows before and after a row within which readings are a parabola even where the axis is fast.
const NEAR: Neighbours = Neighbours::Rows(6);
/// Share of the scatter that readings follow, with three of its standard deviations, below which it is noise: nearer to none than
/// to all.
const HALF_FOLLOWED: f64 = 0.5;
/// Third differences of positions, of the steps from row to row, below which positions are even.
const LEAST_OF_STEP: f64 = 0.1;
/// Standard deviations of the readings beyond which a row does not count: a corner of the motion, a spike of the gauge.
const MOST_SIGMAS: f64 = 4.0;
/// Speeds below this share of the usual one say nothing of what a position does to a reading.
const LEAST_SPEED: f64 = 0.2;

/// Puts the even motion in the place of positions that scatter without the readings following. Tests of one file, one after the
/// other, decide together.
pub(crate) fn even_out(tests: &mut [Test]) {
    let is_of_one_file =
        |one: &Test, other: &Test| one.recording_file.is_some() && one.recording_file == other.recording_file;
    for group in tests.chunk_by_mut(is_of_one_file) {
        even_out_file(group);
    }
}

fn even_out_file(tests: &mut [Test]) {
    let Some((column, even)) = tests[0].recording.as_ref().and_then(even_motion) else { return };
    let recordings = || tests.iter().filter_map(|test| test.recording.as_ref());
    let followed =
        recordings().map(|recording| followed(recording, column, &even)).fold(Followed::default(), |sum, next| {
            Followed {
                products: sum.products + next.products,
                squares: sum.squares + next.squares,
                shown: sum.shown + next.shown,
                rows: sum.rows + next.rows,
            }
        });
    if !followed.is_noise() {
        return;
    }
    for recording in tests.iter_mut().filter_map(|test| test.recording.as_mut()) {
        let off = recording.positions[column].iter().zip(&even).map(|(q, local)| (q - local.value).powi(2));
        let by = (off.sum::<f64>() / even.len() as f64).sqrt();
        recording.scatter = Some(Scatter { axis: recording.axes[column], by });
        recording.positions[column] = even.iter().map(|local| local.value).collect();
    }
}

/// The column that alone moves, where its positions scatter, and its even motion.
fn even_motion(recording: &Recording) -> Option<(usize, Vec<Local>)> {
    let time_s = recording.time_s()?;
    let moves = |column: &usize| recording.positions[*column].windows(2).any(|pair| pair[0] != pair[1]);
    let mut moving = (0..recording.positions.len()).filter(moves);
    let (Some(column), None) = (moving.next(), moving.next()) else { return None };
    let positions = &recording.positions[column];
    // most rows of a commanded path leave nothing
    let steps = robust_sigma(positions.windows(2).map(|pair| pair[1] - pair[0]));
    if robust_sigma(third_differences(positions)) < LEAST_OF_STEP * steps {
        return None;
    }
    Some((column, parabolas(time_s, positions, EVEN).into_iter().collect::<Option<_>>()?))
}

/// What readings say of the scatter of positions: sums over rows, in units of the readings' noise.
#[derive(Default)]
struct Followed {
    /// `Σ x (L − L̂)`.
    products: f64,
    /// `Σ x²`.
    squares: f64,
    /// The same of what is left of the even motion.
    shown: f64,
    rows: usize,
}

impl Followed {
    /// Whether the scatter would show above the noise of the readings, and does not.
    fn is_noise(&self) -> bool {
        let would_show = self.shown > self.rows as f64;
        would_show && self.products / self.squares + 3.0 / self.squares.sqrt() < HALF_FOLLOWED
    }
}

/// Sums over the rows of a recording.
fn followed(recording: &Recording, column: usize, even: &[Local]) -> Followed {
    let (positions, lengths) = (&recording.positions[column], &recording.length_mm);
    let near = |values: &[f64]| recording.time_s().map_or_else(Vec::new, |time_s| parabolas(time_s, values, NEAR));
    let left = |value: f64, near: &Option<Local>| near.map_or(f64::NAN, |local| value - local.value);
    let readings = near(lengths);
    let off_mm: Vec<f64> = lengths.iter().zip(&readings).map(|(length, near)| left(*length, near)).collect();
    let sigma_mm = robust_sigma(off_mm.iter().copied());
    let usual_speed = robust_sigma(even.iter().map(|local| local.slope));
    let mut sum = Followed::default();
    for (row, (position, even)) in near(positions).iter().zip(even).enumerate() {
        let off = left(positions[row], position);
        let counts = off_mm[row].abs() < MOST_SIGMAS * sigma_mm && even.slope.abs() > LEAST_SPEED * usual_speed;
        let Some(reading) = readings[row].filter(|_| counts && off.is_finite()) else { continue };
        let moves = reading.slope / even.slope / sigma_mm;
        sum.products += off * moves * off_mm[row] / sigma_mm;
        sum.squares += (off * moves).powi(2);
        sum.shown += ((positions[row] - even.value) * moves).powi(2);
        sum.rows += 1;
    }
    sum
}
