//! Rows in which nothing moves: axes that stand, a gauge that sticks or has reached the end of its stroke.

use std::cell::OnceCell;
use std::f64::consts::LN_2;
use std::ops::Range;

use super::rounded::rounded_step;
use super::same_rows::is_read;
use super::straight::longest_run;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, listed};
use crate::session::{Clock, Recording, Session, Test};
use crate::statistics::{median, noise_of_rows, probability_of};

/// Rows in a row from which axes stand still, and the share of a usual step below which they do.
const STANDING_ROWS: usize = 4;
const STANDING: f64 = 0.01;

/// Share of rows in which nothing moves from which rows stand twice: two of three, or every second one.
const DOUBLED: f64 = 0.2;

/// Share of rows with a reading below which a recording is none.
const LEAST_READ: f64 = 0.5;

/// Recordings most of whose readings are missing.
pub(super) fn missing(session: &Session) -> Option<DataFault> {
    // poses may be kept back from a fit on purpose
    let is_missing = |recording: &Recording| {
        recording.time_s().is_some() && (recording.readings() as f64) < LEAST_READ * recording.len() as f64
    };
    let test = session.tests.iter().find(|test| test.recording.as_ref().is_some_and(is_missing))?;
    let recording = test.recording.as_ref()?;
    let says = format!(
        "only {} of {} rows of {} have a reading: the gauge lost its contact or its connection; record the test again, or remove the rows without readings where they are none of the arc",
        recording.readings(),
        recording.len(),
        test.name
    );
    Some(DataFault::seen(FaultKind::ReadingsMissing, RECORDER, vec![test.name.clone()], says))
}

/// Recordings whose axes stand for some rows.
pub(super) fn standing(session: &Session) -> Option<DataFault> {
    session.tests.iter().find_map(|test| {
        let recording = test.recording.as_ref()?;
        let (from, to, share) = standing_rows(recording)?;
        if share > DOUBLED {
            return Some(doubled_or_rounded(session, test, recording, share));
        }
        if to + 1 - from < STANDING_ROWS {
            return None;
        }
        let says = format!(
            "the axes stand still in rows {} to {} of {}: a dwell was left in; keep only the rows of the arc",
            from + 1,
            to + 1,
            test.name
        );
        Some(DataFault::seen(FaultKind::Dwell, RECORDER, vec![test.name.clone()], says))
    })
}

/// Rows that stand several times, each as often as the others, or positions on a coarse grid, of which some have more rows than others.
fn doubled_or_rounded(session: &Session, test: &Test, recording: &Recording, share: f64) -> DataFault {
    let seen = format!("nothing moves in {:.0} % of the rows of {}", 100.0 * share, test.name);
    let rounded = (0..recording.axes.len())
        .filter(|&column| is_repeated_unevenly(&recording.positions[column]))
        .find_map(|column| Some((recording.axes[column], rounded_step(session, recording, column)?)));
    let (kind, says) = match rounded {
        Some((axis, step)) => {
            let axis = &session.machine.axes[axis];
            let (name, unit) = (&axis.name, axis.kind.position_unit());
            let says =
                format!("{seen}: positions of {name} were rounded to {step} {unit}; export them with all their digits");
            (FaultKind::ValuesRounded, says)
        }
        None => {
            let says = format!(
                "{seen}: rows stand twice, or lengths were read more often than positions; keep one row for each position"
            );
            (FaultKind::DoubledRows, says)
        }
    };
    DataFault::seen(kind, RECORDER, vec![test.name.clone()], says)
}

/// Whether equal values follow each other now more, now less often, the ends aside.
fn is_repeated_unevenly(column: &[f64]) -> bool {
    let runs: Vec<usize> = column.chunk_by(|one, next| one == next).map(<[f64]>::len).collect();
    runs.get(1..runs.len().saturating_sub(1)).is_some_and(|inner| inner.windows(2).any(|pair| pair[0] != pair[1]))
}

/// First and last row of the longest standstill, and the share of all rows in which nothing moves.
fn standing_rows(recording: &Recording) -> Option<(usize, usize, f64)> {
    recording.time_s()?;
    // each axis in its own usual steps: mm and angles are no sum
    let columns: Vec<Vec<f64>> = recording.positions.iter().filter_map(|column| in_usual_steps(column)).collect();
    let step = |row: usize| columns.iter().map(|column| column[row]).sum::<f64>();
    let steps: Vec<f64> = (0..recording.len().saturating_sub(1)).map(step).collect();
    let usual = median(steps.iter().copied().filter(|step| *step > 0.0))?;
    let stands = |step: f64| step < STANDING * usual;
    let (from, count) = longest_run(&steps, stands);
    let share = steps.iter().filter(|step| stands(**step)).count() as f64 / steps.len() as f64;
    Some((from, from + count, share))
}

/// Steps of a column from row to row, over the median of those that move; `None` where none does.
fn in_usual_steps(column: &[f64]) -> Option<Vec<f64>> {
    let steps: Vec<f64> = column.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let usual = median(steps.iter().copied().filter(|step| *step > 0.0))?;
    Some(steps.into_iter().map(|step| step / usual).collect())
}

/// Equal readings in a row from which a gauge stands, and the share of rows equal to the one before up to which a
/// recording has readings that could differ.
const STUCK_ROWS: usize = 12;
const RARELY_EQUAL: f64 = 0.5;

/// Expected number of runs of equal readings, in a session, that come as long by chance: 1 in so many sessions may have one.
const CHANCE_RUNS: f64 = 1e-3;
/// Share of the runs that are too short to say how long runs become.
const SHORT_RUNS: f64 = 0.9;

/// Steps without change from which a run of equal readings is no chance: where steps of the gauge are no smaller than its noise,
/// readings repeat by right. Lengths of runs fall off exponentially; the longest tenth of them tells how fast, by its median,
/// which a gauge that stuck here and there hardly moves.
fn chance_run<'s, R: Iterator<Item = &'s Recording>>(recordings: impl Fn() -> R) -> usize {
    let mut runs: Vec<usize> = recordings().flat_map(equal_runs).collect();
    runs.sort_unstable();
    let longest = &runs[(SHORT_RUNS * runs.len() as f64) as usize..];
    let Some(least) = longest.first() else { return 0 };
    let halving = (longest[longest.len() / 2] - least) as f64;
    let mean = (halving / LN_2).max(1.0);
    (*least as f64 + mean * (longest.len() as f64 / CHANCE_RUNS).ln()).ceil() as usize
}

/// Steps without change from each reading that differs from the one before to the next that does; most are none.
fn equal_runs(recording: &Recording) -> Vec<usize> {
    read_lengths(recording).chunk_by(|one, next| one == next).map(|run| run.len() - 1).collect()
}

/// Recordings whose readings stand for many rows, or that do not change at all where others do.
pub(super) fn stuck(session: &Session) -> Option<DataFault> {
    let is_timed = |recording: &&Recording| !matches!(recording.clock, Clock::Pose(_));
    let ends = StrokeEnds::of(session);
    let timed: Vec<(&Test, &Recording)> =
        session.tests.iter().filter_map(|test| Some((test, test.recording.as_ref().filter(is_timed)?))).collect();
    let moves: Vec<Recording> = timed.iter().map(|(test, recording)| ends.between(test, recording)).collect();
    if let Some(fault) = all_dead(&timed) {
        return Some(fault);
    }
    // computed lengths of a machine with few errors stand still by right
    if !moves.iter().any(|recording| is_read(&recording.length_mm)) {
        return None;
    }
    let longest_by_chance = OnceCell::new();
    timed.iter().find_map(|&(test, recording)| {
        if is_dead(recording) {
            let says = format!(
                "no reading of {} differs from the others: the gauge stuck or was not connected; record the test again",
                test.name
            );
            return Some(DataFault::seen(FaultKind::GaugeStuck, RECORDER, vec![test.name.clone()], says));
        }
        let (from, count) = equal_rows(recording);
        let lengths = read_lengths(recording);
        let held = *lengths.get(from)?;
        let others: Vec<f64> =
            read_lengths(&ends.between(test, recording)).into_iter().filter(|l| *l != held).collect();
        let equal = others.windows(2).filter(|pair| pair[0] == pair[1]).count();
        let by_chance =
            count + 1 < STUCK_ROWS || count < *longest_by_chance.get_or_init(|| chance_run(|| moves.iter()));
        if by_chance || equal as f64 > RARELY_EQUAL * others.len() as f64 {
            return None;
        }
        if is_smooth_top(&lengths, from, count + 1) {
            let says = format!(
                "{} readings of {} in a row are {held} mm where the curve turns: it was smoothed, or its deviations were divided or rounded; give the readings as the gauge took them",
                count + 1,
                test.name
            );
            return Some(DataFault::seen(FaultKind::ReadingsProcessed, RECORDER, vec![test.name.clone()], says));
        }
        // where the bar has its own length no stroke ends
        let is_middle = test.bar_length_mm.is_some_and(|bar| (held - bar).abs() < GAUGE_STEP_MM);
        let is_longest =
            lengths.iter().all(|length| *length <= held) || lengths.iter().all(|length| *length >= held);
        let is_end = is_longest && !is_middle;
        let is_last = from + count + 1 == lengths.len();
        let (kind, what, cure) = match (is_end, is_last) {
            (true, false) => (
                FaultKind::StrokeEnd,
                "the bar reached the end of its stroke",
                "bring the balls nearer to the bar's length and record the test again",
            ),
            (true, true) => (
                FaultKind::StrokeEnd,
                "the bar reached the end of its stroke, or the last reading was repeated to the end of the file",
                "bring the balls nearer to the bar's length, look after the program that wrote the file, and record the test again",
            ),
            (false, _) => (
                FaultKind::GaugeStuck,
                "the gauge stuck, or deviations were written in another unit",
                "look after gauge and magnets and record the test again",
            ),
        };
        let says = format!("{} readings of {} in a row are {held} mm: {what}; {cure}", count + 1, test.name);
        let fault = DataFault::seen(kind, RECORDER, vec![test.name.clone()], says);
        Some(if kind == FaultKind::GaugeStuck { or_stood(fault, recording, from..from + count + 1) } else { fault })
    })
}

/// A gauge that stuck, or an axis that stood there while its positions went on: whether the curve has gone on in the meantime says which.
///
/// With b the slope of the curve per row, b₀ before the n equal readings and b₁ behind them, the next reading is b off where the axis stood,
/// and (n + 1)·b where the gauge stuck, ± what the slopes leave open.
fn or_stood(stuck: DataFault, recording: &Recording, equal: Range<usize>) -> DataFault {
    let lengths = &read_lengths(recording)[..];
    let read: Vec<usize> = (0..recording.len()).filter(|&row| recording.length_mm[row].is_finite()).collect();
    let slope = |rows: Option<&[f64]>| {
        let rows = rows?;
        Some((rows.last()? - rows.first()?) / (rows.len() - 1) as f64)
    };
    let before = slope(equal.start.checked_sub(STUCK_ROWS).map(|row| &lengths[row..=equal.start]));
    let behind = slope(lengths.get(equal.end..=equal.end + STUCK_ROWS));
    let (Some(before), Some(behind)) = (before, behind) else { return stuck };
    let (noise_mm, rows) = (noise_of_rows(lengths).max(GAUGE_STEP_MM), equal.len() as f64);
    let (slope, step_mm) = (0.5 * (before + behind), lengths[equal.end] - lengths[equal.start]);
    // the slopes are known from two readings each
    let of_slope = noise_mm / STUCK_ROWS as f64;
    let log_of = |rows: f64| {
        let variance = 2.0 * noise_mm.powi(2) + rows.powi(2) * (of_slope.powi(2) + (behind - before).powi(2) / 12.0);
        -0.5 * ((step_mm - rows * slope).powi(2) / variance + variance.ln())
    };
    let stood = probability_of(log_of(1.0) - log_of(rows + 1.0));
    let says = format!(
        "the axis stood in rows {} to {} of {}, over which its positions go on: a dwell was left in, for the readings are equal there and go on \
         behind where they stopped; cut those rows and spread the positions over the others",
        read[equal.start] + 1,
        read[equal.end - 1] + 1,
        listed(&stuck.tests)
    );
    let other = DataFault::seen(FaultKind::Dwell, RECORDER, stuck.tests.clone(), says);
    if stood < 0.5 { stuck.or_other(1.0 - stood, other) } else { other.or_other(stood, stuck) }
}

/// Drop of a curve next to its top, in steps of the readings. The top is as wide as it stays within one step; a parabola falls
/// nine steps at one and a half times that width from its middle. As much again for rounding.
const SMOOTH_DROP: f64 = 18.0;

/// Whether readings that stay the same are the top or bottom of a curve that is read in steps: it falls off slowly on both sides.
fn is_smooth_top(lengths: &[f64], from: usize, count: usize) -> bool {
    let held = lengths[from];
    let step = lengths
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min);
    let (Some(before), Some(after)) =
        (from.checked_sub(count).map(|row| lengths[row]), lengths.get(from + 2 * count - 1))
    else {
        return false;
    };
    let [before, after] = [before - held, after - held];
    before * after > 0.0 && before.abs().max(after.abs()) <= SMOOTH_DROP * step
}

/// Whether no reading differs from the others.
fn is_dead(recording: &Recording) -> bool {
    let (_, count) = equal_rows(recording);
    recording.readings() > STUCK_ROWS && count + 1 == recording.readings()
}

/// Recordings from which on one figure in all of them is no machine without errors, but a gauge that was off.
const ALL_DEAD: usize = 2;

/// Steps in which gauges read, mm, and how far from a multiple a reading may be written: computed lengths have more digits.
const GAUGE_STEP_MM: f64 = 1e-5;
const ON_STEP_MM: f64 = 1e-8;

/// Sessions in which no reading of any recording differs from the others.
fn all_dead(timed: &[(&Test, &Recording)]) -> Option<DataFault> {
    let is_step = |length: &f64| ((length / GAUGE_STEP_MM).round() * GAUGE_STEP_MM - length).abs() < ON_STEP_MM;
    let is_read = |recording: &Recording| read_lengths(recording).first().is_some_and(is_step);
    let all = timed.len() >= ALL_DEAD && timed.iter().all(|(_, recording)| is_dead(recording) && is_read(recording));
    let says = "no reading differs from the others of its recording: the gauge stuck or was not connected; record the session again";
    all.then(|| DataFault::seen(FaultKind::GaugeStuck, RECORDER, Vec::new(), says.to_string()))
}

/// The shortest and the longest reading of each bar in a session: where a gauge at the end of its stroke stays.
struct StrokeEnds {
    by_bar: Vec<(Option<f64>, [f64; 2])>,
}

impl StrokeEnds {
    fn of(session: &Session) -> StrokeEnds {
        let mut by_bar: Vec<(Option<f64>, [f64; 2])> = Vec::new();
        for test in &session.tests {
            let Some(recording) = &test.recording else { continue };
            let finite = || recording.length_mm.iter().copied().filter(|length| length.is_finite());
            let (least, most) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
            match by_bar.iter_mut().find(|(bar, _)| *bar == test.bar_length_mm) {
                Some((_, ends)) => *ends = [ends[0].min(least), ends[1].max(most)],
                None => by_bar.push((test.bar_length_mm, [least, most])),
            }
        }
        StrokeEnds { by_bar }
    }

    /// A recording without the readings at either end.
    fn between(&self, test: &Test, recording: &Recording) -> Recording {
        let mut moves = recording.clone();
        let ends = self.by_bar.iter().find(|(bar, _)| *bar == test.bar_length_mm).map(|(_, ends)| *ends);
        let is_end = |length: f64| ends.is_some_and(|ends| ends.contains(&length));
        moves.length_mm.iter_mut().filter(|length| is_end(**length)).for_each(|length| *length = f64::NAN);
        moves
    }
}

/// Lengths that were read.
fn read_lengths(recording: &Recording) -> Vec<f64> {
    recording.length_mm.iter().copied().filter(|length| length.is_finite()).collect()
}

/// Place of the longest run of readings equal to the one before, and how many these are; missing readings are passed over.
fn equal_rows(recording: &Recording) -> (usize, usize) {
    let lengths = read_lengths(recording);
    let steps: Vec<f64> = lengths.windows(2).map(|pair| pair[1] - pair[0]).collect();
    longest_run(&steps, |step| step == 0.0)
}
