//! The line of a trace in an SVG plot; of a long one the lowest and highest reading of every few rows, so that peaks stay.

use std::fmt::Write as _;
use std::ops::Range;

/// Groups of rows of a long trace: more than the plots have pixels across.
const GROUPS: usize = 1200;

/// Path data through the rows that have a value; `place` is a row's place in the picture. The pen lifts where none has.
pub(crate) fn path_data(
    rows: usize,
    value: impl Fn(usize) -> Option<f64>,
    place: impl Fn(usize, f64) -> (f64, f64),
) -> String {
    let mut path = String::new();
    let mut pen = 'M';
    for (row, value) in shown_rows(rows, value) {
        let Some(value) = value else {
            pen = 'M';
            continue;
        };
        let (x, y) = place(row, value);
        let _ = write!(path, "{pen}{x:.1} {y:.1}");
        pen = 'L';
    }
    path
}

/// Rows of a trace that are drawn, with their values: all of a short one, of a long one the lowest and the highest of every few. Where none
/// of these has a value, one stands without.
pub(crate) fn shown_rows(rows: usize, value: impl Fn(usize) -> Option<f64>) -> Vec<(usize, Option<f64>)> {
    let every = if rows > 2 * GROUPS { rows.div_ceil(GROUPS) } else { 1 };
    let mut shown = Vec::new();
    for from in (0..rows).step_by(every) {
        let ends = lowest_and_highest(from..(from + every).min(rows), &value);
        if ends.is_empty() {
            shown.push((from, None));
        }
        shown.extend(ends.into_iter().map(|(row, value)| (row, Some(value))));
    }
    shown
}

/// The rows of the least and the greatest value in their order; one where they are the same, none where no row has a value.
fn lowest_and_highest(rows: Range<usize>, value: impl Fn(usize) -> Option<f64>) -> Vec<(usize, f64)> {
    let valued = || rows.clone().filter_map(|row| Some((row, value(row)?)));
    let lowest = valued().min_by(|a, b| a.1.total_cmp(&b.1));
    let highest = valued().max_by(|a, b| a.1.total_cmp(&b.1));
    let mut ends: Vec<(usize, f64)> = lowest.into_iter().chain(highest).collect();
    ends.sort_by_key(|(row, _)| *row);
    ends.dedup_by_key(|(row, _)| *row);
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_traces_keep_their_peaks_and_short_ones_every_row() {
        let peak = |row: usize| if row == 777_777 { 9.0 } else { (row % 2) as f64 };
        let long = path_data(1_000_000, |row| Some(peak(row)), |row, value| (row as f64 / 1e4, value));
        assert!(long.contains("L77.8 9.0") && long.matches(['M', 'L']).count() <= 2 * GROUPS, "{}", long.len());
        let short = path_data(5, |row| (row != 2).then_some(1.0), |row, value| (row as f64, value));
        assert_eq!(short, "M0.0 1.0L1.0 1.0M3.0 1.0L4.0 1.0");
    }
}
