//! Each error of a machine alone: what it does to the volume.

use super::figures::{Figures, pose_errors};
use crate::chain::Chain;
use crate::inverse::Tool;
use crate::machine::{Component, ErrorName, Machine};

/// One error alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Cause {
    /// ISO 230-1 name: `EX0C`, `EXX`.
    pub name: String,
    /// Value of a location error, mm or rad; `None` for an error over position.
    pub value: Option<f64>,
    pub component: Component,
    /// Axis index.
    pub axis: usize,
    pub figures: Figures,
}

/// Causes with what each does alone, the largest 95 % position error first.
pub fn causes(machine: &Machine, tool: Tool, poses: &[Vec<f64>]) -> Vec<Cause> {
    let mut list = Vec::new();
    let chain = Chain::of(machine);
    let clean = machine.as_drawn();
    for (index, axis) in machine.axes.iter().enumerate() {
        for component in Component::ALL {
            let value = axis.location_errors[component.index()];
            if value != 0.0 {
                let mut alone = clean.clone();
                alone.axes[index].location_errors[component.index()] = value;
                let figures = Figures::of(&pose_errors(&alone, &chain, tool, poses));
                let name = ErrorName::location(component, &axis.name).to_string();
                list.push(Cause { name, value: Some(value), component, axis: index, figures });
            }
            let forms: Vec<_> = axis.component_errors.iter().filter(|error| error.component == component).collect();
            if !forms.is_empty() {
                let mut alone = clean.clone();
                alone.axes[index].component_errors = forms.into_iter().cloned().collect();
                let figures = Figures::of(&pose_errors(&alone, &chain, tool, poses));
                let name = ErrorName::motion(component, &axis.name).to_string();
                list.push(Cause { name, value: None, component, axis: index, figures });
            }
        }
    }
    list.sort_by(|a, b| b.figures.position_mm.p95.total_cmp(&a.figures.position_mm.p95));
    list
}
