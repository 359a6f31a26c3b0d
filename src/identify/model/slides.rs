//! The linear axes' errors as unknowns with priors: squareness, and smooth displacements along each axis. It solves nothing.
//!
//! A carriage at q is off by `d(q) = q·g(q)` in each direction of R, g a Gaussian process of unit variance (times the
//! budget's standard deviation per length) with correlation `exp(−(q−q')²/2ℓ²)`. That is the sum over k of independent
//! standard normal numbers times `q·(q/ℓ)^k/√k!·exp(−q²/2ℓ²)`. Over the positions that a session visits few combinations
//! of these shapes move a ball at all (one, where an axis stands at zero and at one other place): those are the unknowns.

use nalgebra::DMatrix;

use super::unknowns::{Quantity, Unknown};
use crate::machine::{AxisKind, Component, ComponentError, ComponentForm, ErrorName, LinearAxes, Machine, squareness};
use crate::session::Motion;
use crate::statistics::principal;
use crate::units::Measure;

/// Length over which the shape of a guideway or screw changes, mm: a bow of half a metre is half a wave.
const CHANGES_OVER_MM: f64 = 250.0;
/// On long ways shapes are longer: at most so many lengths from the axis's zero.
const MOST_LENGTHS: f64 = 2.0;
/// Terms of the sum: with two lengths from zero they hold 0.999 of the variance.
const TERMS: usize = 12;
/// A shape that moves a ball less than this (one standard deviation) is left out, mm: a tenth of a recording's last digit.
const UNSEEN_MM: f64 = 1e-5;
/// Positions of a test's motion at which shapes are looked at.
const LOOKS: usize = 17;
/// Least distance of a position from zero that counts, mm.
const AT_ZERO_MM: f64 = 1e-9;

/// Shapes of displacements, by axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Slides {
    by_axis: Vec<AxisShapes>,
}

/// Shapes along one axis.
#[derive(Debug, Clone, Default, PartialEq)]
struct AxisShapes {
    /// Length over which shapes change, mm.
    length_mm: f64,
    /// Weights of the terms, by shape.
    weights: Vec<[f64; TERMS]>,
    /// Positions looked at, rising, mm.
    positions: Vec<f64>,
}

/// `q·(q/ℓ)^k/√k!·exp(−q²/2ℓ²)`, mm.
fn terms(q: f64, length_mm: f64) -> [f64; TERMS] {
    let u = q / length_mm;
    let mut value = q * (-0.5 * u * u).exp();
    std::array::from_fn(|k| {
        if k > 0 {
            value *= u / (k as f64).sqrt();
        }
        value
    })
}

impl AxisShapes {
    /// Shapes that show at `positions`, for a standard deviation per length.
    fn of(mut positions: Vec<f64>, per_length: f64) -> AxisShapes {
        positions.sort_by(f64::total_cmp);
        positions.dedup_by(|a, b| (*a - *b).abs() < AT_ZERO_MM);
        let farthest = positions.iter().fold(0.0f64, |far, q| far.max(q.abs()));
        let length_mm = CHANGES_OVER_MM.max(farthest / MOST_LENGTHS);
        let values = DMatrix::from_rows(
            &positions.iter().map(|&q| nalgebra::RowDVector::from_row_slice(&terms(q, length_mm))).collect::<Vec<_>>(),
        );
        let components = principal(&values).into_iter().map(|(_, way)| way);
        let shown = components.filter(|way| (&values * way).amax() * per_length > UNSEEN_MM);
        let weights = shown.map(|way| std::array::from_fn(|term| way[term])).collect();
        AxisShapes { length_mm, weights, positions }
    }

    fn at(&self, shape: usize, q: f64) -> f64 {
        let weights = self.weights.get(shape);
        weights.map_or(0.0, |w| terms(q, self.length_mm).iter().zip(w).map(|(term, w)| term * w).sum())
    }
}

impl Slides {
    /// Shapes for the motions of a session.
    pub fn of(machine: &Machine, budget: &LinearAxes, motions: &[&Motion]) -> Slides {
        let shapes = |axis: usize| {
            if machine.axes[axis].kind != AxisKind::Linear || budget.positioning.max(budget.straightness) <= 0.0 {
                return AxisShapes::default();
            }
            let positions: Vec<f64> = motions.iter().flat_map(|motion| looks(motion, axis)).collect();
            if positions.iter().all(|q| q.abs() < AT_ZERO_MM) {
                return AxisShapes::default();
            }
            AxisShapes::of(positions, budget.positioning.max(budget.straightness))
        };
        Slides { by_axis: (0..machine.axes.len()).map(shapes).collect() }
    }

    /// Displacement of a carriage at `q` per unit of the unknown, mm.
    pub fn at(&self, axis: usize, shape: usize, q: f64) -> f64 {
        self.by_axis.get(axis).map_or(0.0, |shapes| shapes.at(shape, q))
    }

    /// Squareness and displacements as unknowns; location errors in `free` are unknowns already.
    pub fn unknowns(&self, machine: &Machine, budget: &LinearAxes, free: &[Unknown]) -> Vec<Unknown> {
        let mut list = squareness_within(budget, machine, free);
        for (axis, shapes) in self.by_axis.iter().enumerate() {
            let per_length = budget.per_length(&machine.axes[axis].direction);
            for direction in (0..3).filter(|&k| per_length[k] > 0.0) {
                let name = ErrorName::motion(Component::ALL[direction], &machine.axes[axis].name);
                list.extend((0..shapes.weights.len()).map(|shape| Unknown {
                    quantity: Quantity::Slide { axis, direction, shape },
                    label: format!("{name}, shape {}", shape + 1),
                    measure: Measure::Strain,
                    prior_sigma: per_length[direction],
                    prior_mean: 0.0,
                }));
            }
        }
        list
    }

    /// Component errors of the machine that a fit's values of the unknowns stand for, by axis.
    pub fn component_errors(&self, fitted: &[(Quantity, f64)]) -> Vec<(usize, ComponentError)> {
        let mut list = Vec::new();
        for (axis, shapes) in self.by_axis.iter().enumerate() {
            for direction in 0..3 {
                let mine: Vec<(usize, f64)> = fitted
                    .iter()
                    .filter_map(|&(quantity, value)| match quantity {
                        Quantity::Slide { axis: of, direction: along, shape } if (of, along) == (axis, direction) => {
                            Some((shape, value))
                        }
                        _ => None,
                    })
                    .collect();
                if mine.is_empty() {
                    continue;
                }
                let at = |q: f64| mine.iter().map(|&(shape, value)| value * shapes.at(shape, q)).sum::<f64>();
                let position = shapes.nodes();
                let value = position.iter().map(|&q| at(q)).collect();
                let component = Component::ALL[direction];
                list.push((axis, ComponentError { component, form: ComponentForm::Table { position, value } }));
            }
        }
        list
    }
}

/// Most distance of a table's positions, mm: straight lines between them leave shapes by less than a nanometre.
const TABLE_STEP_MM: f64 = 10.0;

impl AxisShapes {
    /// Positions of a table: all that were looked at, zero, and steps between.
    fn nodes(&self) -> Vec<f64> {
        let ends = self.positions.iter().fold((0.0f64, 0.0f64), |(low, high), &q| (low.min(q), high.max(q)));
        let steps = ((ends.1 - ends.0) / TABLE_STEP_MM).ceil().clamp(1.0, 500.0);
        let mut nodes: Vec<f64> = self.positions.clone();
        nodes.push(0.0);
        nodes.extend((0..=steps as usize).map(|k| ends.0 + (ends.1 - ends.0) * k as f64 / steps));
        nodes.sort_by(f64::total_cmp);
        nodes.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
        nodes
    }
}

/// Positions of an axis in a motion: one where it stands, else some between its ends.
fn looks(motion: &Motion, axis: usize) -> Vec<f64> {
    let (low, high) = travel(motion, axis);
    if high - low < AT_ZERO_MM {
        return if high >= low { vec![low] } else { Vec::new() };
    }
    (0..LOOKS).map(|k| low + (high - low) * k as f64 / (LOOKS - 1) as f64).collect()
}

/// Lowest and highest position of an axis in a motion.
fn travel(motion: &Motion, axis: usize) -> (f64, f64) {
    motion.axis(axis).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q), high.max(q)))
}

/// Squareness of the linear axes as unknowns within their budget, but for those in `free`, which are unknowns already.
pub fn squareness_within(budget: &LinearAxes, machine: &Machine, free: &[Unknown]) -> Vec<Unknown> {
    let is_free = |quantity: &Quantity| free.iter().any(|unknown| unknown.quantity == *quantity);
    let as_unknown = |name: ErrorName| {
        let axis = machine.axis_index(&name.axis)?;
        let quantity = Quantity::Location { axis, component: name.component };
        (!is_free(&quantity)).then(|| Unknown {
            quantity,
            label: name.to_string(),
            measure: Measure::Angle,
            prior_sigma: budget.squareness_rad,
            prior_mean: machine.axes[axis].location_errors[name.component.index()],
        })
    };
    squareness(machine).into_iter().filter(|_| budget.squareness_rad > 0.0).filter_map(as_unknown).collect()
}
