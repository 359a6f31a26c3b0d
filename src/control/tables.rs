//! Compensation tables of single axes from component errors: what to add to the command at positions of the axis.

use super::backlash::{lag, own_sign};
use crate::chain::{Branch, Chain};
use crate::machine::{Axis, AxisKind, Component, ComponentForm, ErrorName, Machine};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

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
    /// Axis whose command takes the error out, and what is added to it per unit of the error. `None`: no single axis does.
    pub corrects: Option<(usize, f64)>,
}

/// Tables of less than this, mm and rad (0.05 µm and 0.05 arcsec), are of nothing.
const LEAST: [f64; 2] = [0.05e-3, 0.05 / crate::units::ARCSEC_PER_RAD];

/// Steps of a table at first and at most.
const STEPS: (usize, usize) = (120, 15_360);
/// Share of a table's largest value that straight lines between its rows may leave.
const MOST_BEND: f64 = 0.02;
/// Rows that LinuxCNC's compensation files take.
pub const LINUXCNC_ROWS: usize = 256;

/// Tables of all component errors of a machine over the travel of its axes or where they are known, as fine as their waves ask for.
pub fn tables(machine: &Machine) -> Vec<CompensationTable> {
    let mut list = Vec::new();
    for (index, axis) in machine.axes.iter().enumerate() {
        for (component, forms) in forms_by_component(axis) {
            let Some((from, to)) = measured(&forms, axis) else { continue };
            let value = |q: f64| forms.iter().map(|form| form.value(q)).sum::<f64>();
            let is_own = axis.own_component() == component && axis.coordinate_direction().is_some();
            // along the axis's own direction a positive error is a motion of the carried part; the command's sense decides
            let sign = if is_own { own_sign(machine, index) } else { 1.0 };
            let rows = rows(&|q| sign * value(q), from, to);
            if rows.iter().all(|(_, value)| value.abs() < LEAST[usize::from(component.is_angle())]) {
                continue;
            }
            list.push(CompensationTable {
                axis: index,
                error: ErrorName::motion(component, &axis.name).to_string(),
                is_own,
                rows,
                lag: if is_own { lag(machine, index) } else { 0.0 },
                corrects: if is_own { Some((index, -1.0)) } else { cross(machine, index, component) },
            });
        }
    }
    list
}

/// Names of component errors that get no table, for their axis states no range and they are no tables themselves.
pub fn without_travel(machine: &Machine) -> Vec<String> {
    let mut names = Vec::new();
    for axis in &machine.axes {
        let open = forms_by_component(axis).into_iter().filter(|(_, forms)| measured(forms, axis).is_none());
        names.extend(open.map(|(component, _)| ErrorName::motion(component, &axis.name).to_string()));
    }
    names.sort();
    names
}

/// Component errors of an axis, the forms of each, which add up.
fn forms_by_component(axis: &Axis) -> BTreeMap<Component, Vec<&ComponentForm>> {
    let mut forms: BTreeMap<Component, Vec<&ComponentForm>> = BTreeMap::new();
    axis.component_errors.iter().for_each(|error| forms.entry(error.component).or_default().push(&error.form));
    forms
}

/// Angles of slides against the others that are of something, rad, by ISO 230-1 name: their location errors, which no table holds.
pub fn squareness(machine: &Machine) -> Vec<(String, f64)> {
    let slides = machine.axes_of(AxisKind::Linear).map(|axis| &machine.axes[axis]);
    let angles = slides.flat_map(|axis| {
        Component::ALL.into_iter().filter(|component| component.is_angle()).map(move |component| {
            let name = ErrorName::location(component, &axis.name).to_string();
            (name, axis.location_errors[component.index()])
        })
    });
    angles.filter(|(_, rad)| rad.abs() > LEAST[1]).collect()
}

/// Positions at which a component is known, mm or rad: where all of its forms are tables, from the first row to the last, within the
/// travel; else all of it, which is a turn of a rotary axis that states none. `None` where neither says.
fn measured(forms: &[&ComponentForm], axis: &Axis) -> Option<(f64, f64)> {
    let ends = |form: &&ComponentForm| match form {
        ComponentForm::Table { position, .. } => Some((*position.first()?, *position.last()?)),
        _ => None,
    };
    let ends: Option<Vec<(f64, f64)>> = forms.iter().map(ends).collect();
    let Some(ends) = ends else {
        return axis.range.or_else(|| (axis.kind == AxisKind::Rotary).then_some((0.0, TAU)));
    };
    let (from, to) = ends.iter().fold((f64::MAX, f64::MIN), |(a, b), (from, to)| (a.min(*from), b.max(*to)));
    let Some((low, high)) = axis.range else { return Some((from, to)) };
    let (from, to) = (from.max(low), to.min(high));
    Some(if from < to { (from, to) } else { (low, high) })
}

/// The slide that takes a displacement of an axis's part out, and how much is added to its command per mm of it: both have to
/// keep their directions, so that no turning axis may carry them.
fn cross(machine: &Machine, axis: usize, component: Component) -> Option<(usize, f64)> {
    if component.is_angle() {
        return None;
    }
    let chain = Chain::of(machine);
    // the tool's side moves the tool, the other one the workpiece away from it
    let side = |axis: usize| match chain.carried_by(axis).branch {
        Branch::Tool => 1.0,
        Branch::Workpiece => -1.0,
    };
    let is_turned = |axis: usize| {
        let branch = chain.branch(chain.carried_by(axis).branch);
        branch.iter().take_while(|&&other| other != axis).any(|&other| machine.axes[other].kind == AxisKind::Rotary)
    };
    let is_along = |slide: &usize| {
        let own = &machine.axes[*slide];
        own.kind == AxisKind::Linear && own.coordinate_direction() == Some(component.index()) && !is_turned(*slide)
    };
    let slide = (0..machine.axes.len()).find(is_along).filter(|_| !is_turned(axis))?;
    Some((slide, -side(axis) * side(slide) * own_sign(machine, slide)))
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
        let is_close = (0..steps).all(|k| leaves(k) <= MOST_BEND * largest);
        if is_close || steps >= STEPS.1 {
            return rows;
        }
        steps *= 2;
    }
}

impl CompensationTable {
    /// As LinuxCNC reads it (`COMP_FILE` of a joint, `COMP_FILE_TYPE = 0`): nominal position, actual position forward and
    /// backward, mm or deg. Only for an axis's own motion, where so many rows are enough and the machine file states the machine
    /// coordinates of a slide.
    pub fn linuxcnc(&self, machine: &Machine) -> Option<String> {
        let kind = machine.axes[self.axis].kind;
        let zero = match kind {
            AxisKind::Linear => machine.machine_zero[self.axis]?,
            AxisKind::Rotary => machine.machine_zero[self.axis].unwrap_or(0.0),
        };
        let line = |&(q, error): &(f64, f64)| {
            let [forward, backward] = [-self.lag, self.lag].map(|lag| kind.to_file_unit(q + error + lag) + zero);
            format!("{:.6} {forward:.6} {backward:.6}\n", kind.to_file_unit(q) + zero)
        };
        (self.is_own && self.rows.len() <= LINUXCNC_ROWS).then(|| self.rows.iter().map(line).collect())
    }

    /// As CSV: position, error in µm or arcsec, and what a table adds to the command of the axis that it names.
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
        let mut text = format!("{}_{position_unit},{}_{unit}", axis.name, self.error);
        if let Some((slide, _)) = self.corrects {
            text.push_str(&format!(",to_add_to_{}_{unit}", machine.axes[slide].name));
        }
        text.push('\n');
        for &(q, error) in &self.rows {
            text.push_str(&format!("{:.5},{:.4}", axis.kind.to_file_unit(q), plain(error * factor)));
            if let Some((_, share)) = self.corrects {
                text.push_str(&format!(",{:.4}", plain(share * error * factor)));
            }
            text.push('\n');
        }
        text
    }
}

/// Without the sign of a zero.
fn plain(value: f64) -> f64 {
    if value.abs() < 5e-5 { 0.0 } else { value }
}
