//! What of the axis lines and of the pivot length a fit determines, component by component.

use crate::chain::{Branch, Chain};
use crate::identify::{AxisLine, Fit, Quantity};
use crate::machine::AxisKind;
use crate::session::Session;

/// What a number is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// Place of the line of the table axis nearest to the bed.
    TableCentre,
    /// Vector from the line of the carrying rotary axis (index) to the line of the axis.
    Vector { from: usize },
    /// Place of the line of the head axis nearest to the bed: a zero shift of the linear axes.
    ZeroShift,
    /// Vector from the line of the last head axis to the spindle ball.
    Pivot,
    /// Turn of the line about x, y, z.
    Direction,
}

/// One component of one number.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// Axis index.
    pub axis: usize,
    pub what: What,
    /// 0 x, 1 y, 2 z of R at the zero position.
    pub component: usize,
    /// Actual minus nominal, mm or rad.
    pub change: f64,
    pub sigma: f64,
    /// The recordings fix it.
    pub determined: bool,
}

/// Numbers of all rotary axes.
pub fn numbers(session: &Session, fit: &Fit, lines: &[AxisLine]) -> Vec<Number> {
    let machine = &session.machine;
    let mut list = Vec::new();
    for line in lines {
        let along = machine.axes[line.axis].coordinate_direction();
        let (what, value, sigma, determined) = match (line.carrier, line.is_head) {
            (Some(from), _) => {
                (What::Vector { from }, line.from_carrier_mm, line.from_carrier_sigma_mm, line.from_carrier_determined)
            }
            (None, false) => (What::TableCentre, line.shift_mm, line.shift_sigma_mm, line.shift_determined),
            (None, true) => (What::ZeroShift, line.shift_mm, line.shift_sigma_mm, line.shift_determined),
        };
        // a head's vector along its carrier's line turns with nothing: a zero shift of the slides
        let carrier_along = match what {
            What::Vector { from } if line.is_head => machine.axes[from].coordinate_direction(),
            _ => None,
        };
        for component in (0..3).filter(|&k| along != Some(k) && carrier_along != Some(k)) {
            list.push(Number {
                axis: line.axis,
                what,
                component,
                change: value[component],
                sigma: sigma[component],
                determined: determined[component],
            });
        }
        for component in (0..3).filter(|&k| along != Some(k)) {
            list.push(Number {
                axis: line.axis,
                what: What::Direction,
                component,
                change: line.tilt_rad[component],
                sigma: line.tilt_sigma_rad[component],
                determined: line.tilt_determined[component],
            });
        }
    }
    list.extend(pivot(session, fit));
    list
}

/// The vector from the last head axis to the spindle ball: the ball's place as fitted, for the axis's own errors move the
/// line and the ball alike.
fn pivot(session: &Session, fit: &Fit) -> Vec<Number> {
    let machine = &session.machine;
    let chain = Chain::of(machine);
    let head = chain.branch(Branch::Tool).iter().rev().copied();
    let Some(axis) = head.clone().find(|&axis| machine.axes[axis].kind == AxisKind::Rotary) else { return Vec::new() };
    // a slide between the axis and the ball would be part of the vector
    if head.clone().next() != Some(axis) {
        return Vec::new();
    }
    let balls = fit.unknowns.iter().zip(&fit.estimates).filter_map(|(unknown, estimate)| match unknown.quantity {
        // of what only its spread holds the readings say nothing: half of the variance at most may be that
        Quantity::SpindleBall { setup, coordinate } => {
            let determined = estimate.determined && 2.0 * estimate.sigma.powi(2) < unknown.prior_sigma.powi(2);
            Some((setup, coordinate, estimate, determined))
        }
        _ => None,
    });
    let along = machine.axes[axis].coordinate_direction();
    balls
        // balls mounted anew are vectors of their own: the first is told
        .filter(|&(setup, coordinate, ..)| setup == 0 && along != Some(coordinate))
        .map(|(_, component, estimate, determined)| Number {
            axis,
            what: What::Pivot,
            component,
            change: estimate.value,
            sigma: estimate.sigma,
            determined,
        })
        .collect()
}
