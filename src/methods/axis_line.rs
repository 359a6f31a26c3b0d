//! An axis as a line through two centres, with scatter, and what an outer axis's errors do to the line of an inner one.

use nalgebra::Vector3;

use super::runs::{Runs, Scatter};
use super::thesis_value::ThesisValue;
use crate::machine::{Component, ErrorName, Machine};

/// Place or direction of an axis.
#[derive(Clone, Copy, PartialEq)]
pub enum Part {
    Place,
    Turn,
}

/// An axis as a line: displacement at its origin and turn, each with its scatter; R's directions.
#[derive(Clone)]
pub struct AxisLine {
    direction: Vector3<f64>,
    origin: Vector3<f64>,
    /// mm.
    place: Vector3<f64>,
    place_scatter: [Scatter; 3],
    /// rad.
    turn: Vector3<f64>,
    turn_scatter: [Scatter; 3],
}

impl AxisLine {
    /// The line through two centres.
    pub fn through(machine: &Machine, axis: usize, runs: [&Runs; 2]) -> AxisLine {
        let axis = &machine.axes[axis];
        let along = axis.coordinate_direction().unwrap_or(2);
        // s grows along the axis's direction, which may be the negative coordinate
        let distance_mm = runs[1].at_mm - runs[0].at_mm;
        let weight = runs[0].at_mm / distance_mm;
        let mut line = AxisLine {
            direction: axis.direction,
            origin: axis.origin,
            place: Vector3::zeros(),
            place_scatter: [Scatter::NONE; 3],
            turn: Vector3::zeros(),
            turn_scatter: [Scatter::NONE; 3],
        };
        for k in 0..2 {
            let coordinate = (along + 1 + k) % 3;
            let (near, far) = (runs[0].centre_mm[k], runs[1].centre_mm[k]);
            let (near_scatter, far_scatter) = (runs[0].centre_scatter[k], runs[1].centre_scatter[k]);
            let slope = (far - near) / distance_mm;
            line.place[coordinate] = near - slope * runs[0].at_mm;
            line.place_scatter[coordinate] = Scatter::combined(&[(1.0 + weight, near_scatter), (-weight, far_scatter)]);
            // ε = d × slope: the first coordinate's slope turns about the second and the other way round
            let unit = Vector3::from_fn(|row, _| if row == coordinate { 1.0 } else { 0.0 });
            let about = axis.direction.cross(&unit);
            let turned = about.iamax();
            line.turn[turned] = slope.atan() * about[turned];
            line.turn_scatter[turned] =
                Scatter::combined(&[(1.0 / distance_mm, near_scatter), (1.0 / distance_mm, far_scatter)]);
        }
        line
    }

    /// What this outer axis's place or turn does to the line of an axis that it carries, across that axis.
    pub fn carried(&self, part: Part, inner: &AxisLine) -> AxisLine {
        let lever = inner.origin - self.origin;
        let (place, turn) = match part {
            Part::Place => (self.place, Vector3::zeros()),
            Part::Turn => (self.turn.cross(&lever), self.turn),
        };
        let across = |vector: Vector3<f64>| vector - inner.direction * inner.direction.dot(&vector);
        let (place_scatter, turn_scatter) = match part {
            Part::Place => (self.place_scatter, [Scatter::NONE; 3]),
            Part::Turn => {
                let levered = [0, 1, 2].map(|k| {
                    let (next, last) = ((k + 1) % 3, (k + 2) % 3);
                    Scatter::combined(&[
                        (lever[last], self.turn_scatter[next]),
                        (-lever[next], self.turn_scatter[last]),
                    ])
                });
                (levered, self.turn_scatter)
            }
        };
        AxisLine { place: across(place), turn: across(turn), place_scatter, turn_scatter, ..inner.clone() }
    }

    pub fn less(&self, other: &AxisLine) -> AxisLine {
        let both =
            |a: [Scatter; 3], b: [Scatter; 3]| [0, 1, 2].map(|k| Scatter::combined(&[(1.0, a[k]), (-1.0, b[k])]));
        AxisLine {
            place: self.place - other.place,
            turn: self.turn - other.turn,
            place_scatter: both(self.place_scatter, other.place_scatter),
            turn_scatter: both(self.turn_scatter, other.turn_scatter),
            ..self.clone()
        }
    }

    /// Location errors of the axis's slots.
    pub fn values(&self, machine: &Machine, axis: usize) -> Vec<ThesisValue> {
        let value = |component: Component| {
            let k = component.direction_index();
            let (value, scatter) = match component.is_angle() {
                false => (self.place[k], self.place_scatter[k]),
                true => (self.turn[k], self.turn_scatter[k]),
            };
            ThesisValue {
                name: ErrorName::location(component, &machine.axes[axis].name),
                value,
                run_deviation: scatter.of_one_run.map(f64::sqrt),
                mean_deviation: scatter.of_mean.map(f64::sqrt),
                left_in: None,
            }
        };
        machine.axes[axis].slots().into_iter().map(value).collect()
    }
}
