//! Compensation tables of single axes from component errors: what to add to the command at positions of the axis.

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
}

/// Rows of a table: LinuxCNC's compensation files take 256 at most.
const ROWS: usize = 121;

/// Tables of all component errors of a machine over the travel of its axes.
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
            let at = |k: usize| from + (to - from) * k as f64 / (ROWS - 1) as f64;
            let is_own = axis.own_component() == component && axis.coordinate_direction().is_some();
            // along the axis's own direction a positive error is a motion of the carried part; the command's sense decides
            let sign = if is_own { machine.motion_sign(index) * axis.direction.sum().signum() } else { 1.0 };
            list.push(CompensationTable {
                axis: index,
                error: ErrorName::motion(component, &axis.name).to_string(),
                is_own,
                rows: (0..ROWS).map(|k| (at(k), sign * value(at(k)))).collect(),
            });
        }
    }
    list
}

impl CompensationTable {
    /// As LinuxCNC reads it (`COMP_FILE` of a joint, `COMP_FILE_TYPE = 0`): nominal position, actual position forward and
    /// backward, mm or deg. Only for an axis's own motion.
    pub fn linuxcnc(&self, machine: &Machine) -> Option<String> {
        let kind = machine.axes[self.axis].kind;
        let zero = machine.machine_zero[self.axis].unwrap_or(0.0);
        let line = |&(q, error): &(f64, f64)| {
            let actual = kind.to_file_unit(q + error) + zero;
            format!("{:.5} {actual:.6} {actual:.6}\n", kind.to_file_unit(q) + zero)
        };
        self.is_own.then(|| self.rows.iter().map(line).collect())
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
