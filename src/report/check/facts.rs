//! What a check tells of a machine and a session, before it is text or JSON. Poses and medians come computed.

use serde::Serialize;

use crate::chain::Pose;
use crate::machine::{Axis, AxisKind, Component, ErrorName, Machine};
use crate::report::wording::number::position;

/// A link's transforms: bed from link, mm.
#[derive(Debug, Clone)]
pub struct LinkPose {
    pub name: String,
    pub nominal: Pose,
    /// With the location and component errors of the file.
    pub with_errors: Pose,
}

/// Transforms of all links at one set of positions (mm, rad, by axis index).
#[derive(Debug, Clone)]
pub struct Placement {
    pub positions: Vec<f64>,
    pub links: Vec<LinkPose>,
}

/// The sense of every axis in words, by axis index.
#[derive(Debug, Clone)]
pub struct Senses {
    pub as_read: Vec<String>,
    /// What it would be under `iso841`, where the file states no sense; else empty.
    pub else_iso841: Vec<String>,
}

/// What a session holds.
#[derive(Debug, Clone, Serialize)]
pub struct SessionCheck {
    pub name: String,
    pub tests: Vec<TestCheck>,
    pub pivots: Vec<String>,
    pub spindle_balls: Vec<String>,
    pub bars: Vec<String>,
}

/// How far an axis moves in a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingAxis {
    /// Its index in the machine.
    pub axis: usize,
    /// Lowest and highest position, mm or rad.
    pub lowest: f64,
    pub highest: f64,
}

/// One test of a session.
#[derive(Debug, Clone, Serialize)]
pub struct TestCheck {
    pub name: String,
    pub rows: usize,
    pub readings: usize,
    #[serde(skip)]
    pub moving: Vec<MovingAxis>,
    pub bar_length_mm: Option<f64>,
    /// Median of reading minus the length that the machine file predicts, mm.
    pub median_off_mm: Option<f64>,
}

/// Slots of an axis, its zero position and whatever else the file states.
pub fn shown_errors(axis: &Axis) -> impl Iterator<Item = Component> {
    let mut slots = axis.slots();
    slots.extend(axis.zero_position());
    Component::ALL.into_iter().filter(move |c| slots.contains(c) || axis.location_errors[c.index()] != 0.0)
}

/// Names of the component errors that the file states.
pub fn component_names(axis: &Axis) -> Vec<String> {
    let name = |component| ErrorName::motion(component, &axis.name).to_string();
    axis.component_errors.iter().map(|error| name(error.component)).collect()
}

/// `linear` or `rotary`.
pub fn kind_name(kind: AxisKind) -> &'static str {
    match kind {
        AxisKind::Linear => "linear",
        AxisKind::Rotary => "rotary",
    }
}

/// Positions by axis name, mm or deg.
pub fn named_positions(machine: &Machine, placement: &Placement) -> Vec<(String, f64)> {
    let axes = machine.axes.iter().zip(&placement.positions);
    axes.map(|(axis, &q)| (axis.name.clone(), position(axis.kind, q))).collect()
}

/// Rows of the 4 × 4 transform, mm.
pub fn rows(pose: &Pose) -> [[f64; 4]; 4] {
    let row = |k: usize| {
        let r = &pose.rotation;
        [r[(k, 0)], r[(k, 1)], r[(k, 2)], pose.translation_mm[k]].map(without_minus_zero)
    };
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// −0 is a zero to readers.
pub fn without_minus_zero(value: f64) -> f64 {
    value + 0.0
}
