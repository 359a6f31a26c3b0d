//! Compensation tables of single axes from component errors: what to add to the command at positions of the axis.

use super::backlash::{lag, own_sign};
use crate::machine::{AxisKind, ComponentForm, ErrorName, Machine};

/// Error of one component over its axis.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationTable {
    /// Axis index.
    pub axis: usize,
    /// ISO 230-1 name: `EXX`.
    pub error: String,
    /// It is the axis's own motion: a pitch table takes it; others need the cross compensation of a control.
    pub is_own: bool,
    /// Position (mm or rad) and actual minus commanded (mm or rad).
    pub rows: Vec<(f64, f64)>,
    /// Half width of the axis's lost motion, mm or rad: it lags so much either way. Only where it is the axis's own motion.
    pub lag: f64,
}

/// Steps of a table at first and at most.
const STEPS: (usize, usize) = (120, 15_360);
/// Share of a table's largest value that straight lines between its rows may leave.
const BENT: f64 = 0.02;
/// Rows that LinuxCNC's compensation files take.
pub const LINUXCNC_ROWS: usize = 256;

/// Tables of all component errors of a machine over the travel of its axes, as fine as their waves ask for.
pub fn tables(machine: &Machine) -> Vec<CompensationTable> {
    let mut list = Vec::new();
    for (index, axis) in machine.axes.iter().enumerate() {
        let Some((from, to)) = axis.range else { continue };
        let mut components: Vec<_> = axis.component_errors.iter().map(|error| error.component).collect();
        components.sort();
        components.dedup();
        for component in components {
            let forms: Vec<&ComponentForm> = axis
                .component_errors
                .iter()
                .filter(|error| error.component == component)
                .map(|error| &error.form)
                .collect();
            let value = |q: f64| forms.iter().map(|form| form.value(q)).sum::<f64>();
            let is_own = axis.own_component() == component && axis.coordinate_direction().is_some();
            // along the axis's own direction a positive error is a motion of the carried part; the command's sense decides
            let sign = if is_own { own_sign(machine, index) } else { 1.0 };
            list.push(CompensationTable {
                axis: index,
                error: ErrorName::motion(component, &axis.name).to_string(),
                is_own,
                rows: rows(&|q| sign * value(q), from, to),
                lag: if is_own { lag(machine, index) } else { 0.0 },
            });
        }
    }
    list
}

/// Rows of a curve, close enough that straight lines between them leave little of it.
fn rows(value: &dyn Fn(f64) -> f64, from: f64, to: f64) -> Vec<(f64, f64)> {
    let of = |steps: usize| -> Vec<(f64, f64)> {
        let at = |k: usize| from + (to - from) * k as f64 / steps as f64;
        (0..=steps).map(|k| (at(k), value(at(k)))).collect()
    };
    let mut steps = STEPS.0;
    loop {
        let [rows, finer] = [of(steps), of(2 * steps)];
        let largest = finer.iter().fold(0.0f64, |largest, (_, value)| largest.max(value.abs()));
        let leaves = |k: usize| (finer[2 * k + 1].1 - 0.5 * (rows[k].1 + rows[k + 1].1)).abs();
        let is_close = (0..steps).all(|k| leaves(k) <= BENT * largest);
        if is_close || steps >= STEPS.1 {
            return rows;
        }
        steps *= 2;
    }
}

impl CompensationTable {
    /// As LinuxCNC reads it (`COMP_FILE` of a joint, `COMP_FILE_TYPE = 0`): nominal position, actual position forward and
    /// backward, mm or deg. Only for an axis's own motion, and where so many rows are enough.
    pub fn linuxcnc(&self, machine: &Machine) -> Option<String> {
        let kind = machine.axes[self.axis].kind;
        let zero = machine.machine_zero[self.axis].unwrap_or(0.0);
        let line = |&(q, error): &(f64, f64)| {
            let [forward, backward] = [-self.lag, self.lag].map(|lag| kind.to_file_unit(q + error + lag) + zero);
            format!("{:.6} {forward:.6} {backward:.6}\n", kind.to_file_unit(q) + zero)
        };
        (self.is_own && self.rows.len() <= LINUXCNC_ROWS).then(|| self.rows.iter().map(line).collect())
    }

    /// As CSV: position, error in µm or arcsec, what a table adds to the command.
    pub fn csv(&self, machine: &Machine) -> String {
        let axis = &machine.axes[self.axis];
        let is_angle = ErrorName::parse(&self.error, &machine.axis_names()).is_ok_and(|name| name.component.is_angle());
        let (unit, factor) = match is_angle {
            true => ("arcsec", crate::units::ARCSEC_PER_RAD),
            false => ("um", crate::units::UM_PER_MM),
        };
        let position_unit = match axis.kind {
            AxisKind::Linear => "mm",
            AxisKind::Rotary => "deg",
        };
        let mut text = format!("{}_{position_unit},{}_{unit},to_add_{unit}\n", axis.name, self.error);
        for &(q, error) in &self.rows {
            text.push_str(&format!("{:.5},{:.4},{:.4}\n", axis.kind.to_file_unit(q), error * factor, -error * factor));
        }
        text
    }
}
