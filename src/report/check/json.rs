//! A check as JSON, see docs/json.md.

use serde::Serialize;

use super::facts::{Placement, Senses, SessionCheck, component_names, kind_name, named_positions, rows, shown_errors};
use crate::machine::{Directions, ErrorName, Machine};
use crate::report::wording::linear_axes::{LinearAxesJson, linear_axes_json};
use crate::report::wording::meetings::{BodyPairs, BodyPairsJson, body_pairs_json};
use crate::report::wording::number::position;

/// `fiveaxis check --json`.
#[derive(Debug, Clone, Serialize)]
pub struct CheckJson {
    pub name: String,
    pub code: String,
    /// `iso841` or `carried` as stated; null where the file states neither, which reads as `carried`.
    pub directions: Option<&'static str>,
    pub axes: Vec<AxisJson>,
    /// What the linear axes are taken to be; null without linear axes.
    pub linear_axes: Option<LinearAxesJson>,
    /// Further link names with the axis that carries them, `b` for the bed.
    pub links: Vec<(String, String)>,
    /// The zero position, then the one asked for.
    pub placements: Vec<PlacementJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<SessionCheck>,
    /// Pairs of bodies, where the file has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bodies: Option<BodyPairsJson>,
}

/// One axis.
#[derive(Debug, Clone, Serialize)]
pub struct AxisJson {
    pub name: String,
    /// `linear` or `rotary`.
    pub kind: &'static str,
    pub direction: [f64; 3],
    pub origin_mm: [f64; 3],
    /// In `position_unit`.
    pub range: Option<[f64; 2]>,
    /// `mm` or `deg`.
    pub position_unit: &'static str,
    pub reversed: bool,
    /// What a positive command does, in words.
    pub sense: String,
    /// What it would do under `iso841`, where the file states no sense.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sense_iso841: Option<String>,
    /// Location errors that the axis has, zero position included, with their values; others only when the file states them.
    pub location_errors: Vec<ErrorJson>,
    /// Names of component errors that the file states.
    pub component_errors: Vec<String>,
}

/// One location error.
#[derive(Debug, Clone, Serialize)]
pub struct ErrorJson {
    pub name: String,
    pub value: f64,
    /// `um` or `arcsec`.
    pub unit: &'static str,
}

/// Transforms at one set of positions.
#[derive(Debug, Clone, Serialize)]
pub struct PlacementJson {
    /// By axis name, mm or deg.
    pub positions: Vec<(String, f64)>,
    pub links: Vec<LinkJson>,
}

/// Rows of the 4 × 4 transform, bed from link, mm.
#[derive(Debug, Clone, Serialize)]
pub struct LinkJson {
    pub name: String,
    pub nominal: [[f64; 4]; 4],
    pub with_errors: [[f64; 4]; 4],
}

/// The JSON value of a check.
pub fn check_json(
    machine: &Machine,
    senses: &Senses,
    placements: &[Placement],
    session: Option<&SessionCheck>,
    bodies: Option<&BodyPairs>,
) -> CheckJson {
    let carrier = |axis: &Option<usize>| axis.map_or("b", |axis| &machine.axes[axis].name).to_string();
    CheckJson {
        name: machine.name.clone(),
        code: machine.code.to_string(),
        directions: machine.directions.map(Directions::name),
        axes: (0..machine.axes.len()).map(|axis| axis_json(machine, axis, senses)).collect(),
        linear_axes: linear_axes_json(machine),
        links: machine.link_names.iter().map(|(name, axis)| (name.clone(), carrier(axis))).collect(),
        placements: placements.iter().map(|placement| placement_json(machine, placement)).collect(),
        session: session.cloned(),
        bodies: bodies.map(|pairs| body_pairs_json(machine, pairs)),
    }
}

/// One axis with its range in units of files.
fn axis_json(machine: &Machine, index: usize, senses: &Senses) -> AxisJson {
    let axis = &machine.axes[index];
    AxisJson {
        name: axis.name.clone(),
        kind: kind_name(axis.kind),
        direction: axis.direction.into(),
        origin_mm: axis.origin.into(),
        range: axis.range.map(|(from, to)| [position(axis.kind, from), position(axis.kind, to)]),
        position_unit: axis.kind.position_unit(),
        reversed: axis.reversed,
        sense: senses.as_read.get(index).cloned().unwrap_or_default(),
        sense_iso841: senses.else_iso841.get(index).cloned(),
        location_errors: shown_errors(axis)
            .map(|component| ErrorJson {
                name: ErrorName::location(component, &axis.name).to_string(),
                value: component.measure().to_output(axis.location_errors[component.index()]),
                unit: component.measure().output_unit(),
            })
            .collect(),
        component_errors: component_names(axis),
    }
}

/// Transforms of all links at one set of positions.
fn placement_json(machine: &Machine, placement: &Placement) -> PlacementJson {
    PlacementJson {
        positions: named_positions(machine, placement),
        links: placement
            .links
            .iter()
            .map(|link| LinkJson {
                name: link.name.clone(),
                nominal: rows(&link.nominal),
                with_errors: rows(&link.with_errors),
            })
            .collect(),
    }
}
