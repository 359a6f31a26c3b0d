//! What a real control commanded, millisecond by millisecond, in place of the tests' own control.

use std::path::Path;

use fiveaxis::machine::Machine;

/// A recorded run of a program.
pub struct Trace {
    time_s: Vec<f64>,
    /// Positions of all axes, mm and rad, by row.
    rows: Vec<Vec<f64>>,
}

impl Trace {
    /// Reads a table of time, axes (`X_mm`, `A_deg`) and further columns.
    pub fn read(file: &Path, machine: &Machine) -> Trace {
        let text = std::fs::read_to_string(file).unwrap_or_else(|why| panic!("{}: {why}", file.display()));
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().expect("head").split(',').collect();
        let axes: Vec<Option<usize>> =
            head.iter().map(|name| machine.axis_index(name.split('_').next().expect("a name"))).collect();
        let (mut time_s, mut rows) = (Vec::new(), Vec::new());
        for line in lines {
            let values: Vec<f64> = line.split(',').map(|value| value.parse().expect("a number")).collect();
            let mut q = vec![0.0; machine.axes.len()];
            for (axis, value) in axes.iter().zip(&values) {
                if let Some(axis) = axis {
                    q[*axis] = machine.axes[*axis].kind.from_file_unit(*value);
                }
            }
            time_s.push(values[0]);
            rows.push(q);
        }
        Trace { time_s, rows }
    }

    /// Positions at a time.
    pub fn at(&self, time_s: f64) -> Vec<f64> {
        let k = self.time_s.partition_point(|time| *time <= time_s).clamp(1, self.time_s.len() - 1);
        let part = ((time_s - self.time_s[k - 1]) / (self.time_s[k] - self.time_s[k - 1])).clamp(0.0, 1.0);
        self.rows[k - 1].iter().zip(&self.rows[k]).map(|(a, b)| a + (b - a) * part).collect()
    }

    /// The longest stretch in which the bar fits, begun and ended where all axes stand for a second; `off_mm` is the bar's
    /// deviation at some positions.
    pub fn with_bar(&self, stroke_mm: f64, off_mm: impl Fn(&[f64]) -> f64) -> (f64, f64) {
        let fits: Vec<bool> = self.rows.iter().map(|row| off_mm(row).abs() < stroke_mm).collect();
        let (mut best, mut from) = ((0, 0), 0);
        for k in 0..=fits.len() {
            if k == fits.len() || !fits[k] {
                if k - from > best.1 - best.0 {
                    best = (from, k);
                }
                from = k + 1;
            }
        }
        let stands = |k: usize| self.time_s.get(k + 1000).is_some_and(|_| self.rows[k] == self.rows[k + 1000]);
        let first = (best.0..best.1).find(|&k| stands(k)).expect("a rest");
        let last = (best.0..best.1.saturating_sub(1000)).rev().find(|&k| stands(k)).expect("a rest") + 1000;
        (self.time_s[first], self.time_s[last])
    }
}
