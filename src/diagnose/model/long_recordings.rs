//! Averages the rows of very long recordings before they are diagnosed: time and memory of a search grow with the rows.

use std::ops::Range;
use std::sync::Arc;

use super::decimate::odd;
use crate::session::{Clock, Path, Recording, Session, Test};
use crate::statistics::mean;

/// Rows of a session that are searched in full. Each takes about 9 kB and 0.2 ms; sessions of usual gauges have a tenth.
pub const MOST_ROWS: usize = 60_000;
/// Part of a group's readings left out at each end: single wrong ones and bursts do not move the mean of the others.
const TRIMMED: f64 = 0.25;

/// A recording whose rows were averaged.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Averaged {
    pub test: String,
    /// Rows of the recording.
    pub rows: usize,
    /// Rows of each mean.
    pub group: usize,
}

/// The session with neighbouring rows averaged and which recordings that changed; `None` where it has at most [`MOST_ROWS`].
/// The longest are shortened, static poses stay as they are. Positions and times are means over the group, so a sweep keeps
/// its places; what is faster than a group is lost.
pub fn lean(session: &Session) -> Option<(Session, Vec<Averaged>)> {
    let most = most_rows_each(session.tests.iter().map(Test::rows).collect())?;
    let (mut session, mut averaged) = (session.clone(), Vec::new());
    for test in &mut session.tests {
        let Some(recording) = &mut test.recording else { continue };
        let rows = recording.len();
        if rows <= most || matches!(recording.clock, Clock::Pose(_)) {
            continue;
        }
        // groups of odd size have a middle row
        let group = odd(rows.div_ceil(most) + 1).max(3);
        let whole = rows / group;
        if let (Clock::Absent, Some(path)) = (&recording.clock, &test.path) {
            test.path = Some(middles(path, rows, group, whole));
        }
        average(recording, group, whole);
        averaged.push(Averaged { test: test.name.clone(), rows, group });
    }
    Some((session, averaged))
}

/// The path from the middle of the first group to that of the last, for rows that are uniform along it.
fn middles(path: &Path, rows: usize, size: usize, groups: usize) -> Path {
    let samples = path.samples();
    let (Some(from), Some(to)) = (samples.first(), samples.last()) else { return path.clone() };
    let at = |group: usize| from + (to - from) * (group * size + size / 2) as f64 / (rows - 1) as f64;
    path.between(at(0), at(groups - 1))
}

/// Rows that each recording may keep for all together to stay within [`MOST_ROWS`]; `None` where they do.
fn most_rows_each(mut rows: Vec<usize>) -> Option<usize> {
    rows.sort_unstable();
    let mut left = MOST_ROWS;
    for (index, &own) in rows.iter().enumerate() {
        let share = left / (rows.len() - index);
        if own > share {
            return Some(share.max(1));
        }
        left -= own;
    }
    None
}

/// Means over the first whole groups; the rows behind them, fewer than a group, are left out.
fn average(recording: &mut Recording, size: usize, whole: usize) {
    let groups: Vec<Range<usize>> = (0..whole).map(|group| group * size..(group + 1) * size).collect();
    let read: Vec<bool> = recording.length_mm.iter().map(|length| length.is_finite()).collect();
    // places of the rows that were read: others would shift the mean place against the mean length
    let means = |column: &[f64]| -> Vec<f64> {
        let mean_of = |group: &Range<usize>| {
            let some = group.clone().any(|row| read[row]);
            mean(group.clone().filter(|&row| read[row] || !some).map(|row| column[row])).unwrap_or(f64::NAN)
        };
        groups.iter().map(mean_of).collect()
    };
    if let Clock::TimeS(time) = &recording.clock {
        recording.clock = Clock::TimeS(means(time));
    }
    recording.positions = recording.positions.iter().map(|column| means(column)).collect();
    let trimmed = |column: &[f64]| -> Vec<f64> {
        groups.iter().map(|group| trimmed_mean(column[group.clone()].to_vec())).collect()
    };
    recording.channels = recording.channels.iter().map(|(name, column)| (name.clone(), trimmed(column))).collect();
    recording.length_mm = trimmed(&recording.length_mm);
    recording.leading_texts = Arc::default();
}

/// Mean of the finite values without those at both ends; NaN of none.
fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let left_out = (TRIMMED * values.len() as f64) as usize;
    mean(values[left_out..values.len() - left_out].iter().copied()).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_are_shortened_to_the_limit_together() {
        assert_eq!(most_rows_each(vec![10, MOST_ROWS - 10]), None);
        let rows = vec![1_000, 1_000_000, 50_000, 500];
        let most = most_rows_each(rows.clone()).unwrap();
        let kept: usize = rows.iter().map(|&own| own.min(most)).sum();
        assert!(kept <= MOST_ROWS && kept > MOST_ROWS - rows.len(), "{kept}");
    }

    #[test]
    fn single_wrong_readings_do_not_move_a_mean() {
        assert_eq!(trimmed_mean(vec![1.0, 2.0, 3.0, 4.0, 1e9]), 3.0);
        assert_eq!(trimmed_mean(vec![f64::NAN, 2.0]), 2.0);
        assert!(trimmed_mean(vec![f64::NAN]).is_nan());
    }
}
