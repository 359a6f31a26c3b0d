//! What of the axis lines and of the pivot length a fit determines, component by component.

use crate::identify::{AxisLine, Fit, Quantity, Unknown};
use crate::session::Session;

/// Weights below this are those of a direction that is no direction of R, rounded.
const SEEN: f64 = 1e-6;

/// What a number is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// Place of the line of the table axis nearest to the bed; beside a head from the spindle, with all axes at zero.
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

/// The vector from the last head axis to the spindle ball, across the axis: the ball's place as fitted, for the axis's own errors move the
/// line and the ball alike. Along the line it says nothing: of an inclined axis the part along it is taken out.
fn pivot(session: &Session, fit: &Fit) -> Vec<Number> {
    let machine = &session.machine;
    // a slide between the axis and the ball would be part of the vector
    let Some(axis) = machine.spindle_axis() else { return Vec::new() };
    // balls mounted anew are vectors of their own: the first is told
    let place = |k: usize| {
        let is_it = |unknown: &Unknown| unknown.quantity == Quantity::SpindleBall { setup: 0, coordinate: k };
        fit.unknowns.iter().position(is_it)
    };
    let [Some(x), Some(y), Some(z)] = [0, 1, 2].map(place) else { return Vec::new() };
    let places = [x, y, z];
    let along = machine.axes[axis].direction;
    let seat_mm = session.spread.spindle_ball_mm;
    let is_free = session.spread.pivot_length_mm > 0.0;
    let number = |component: usize| {
        let weight = |k: usize| f64::from(k == component) - along[component] * along[k];
        let weights: Vec<(usize, f64)> = (0..3).map(|k| (places[k], weight(k))).collect();
        let seen = || weights.iter().filter(|(_, weight)| weight.abs() > SEEN);
        let sum = fit.sum_of(&weights, seat_mm);
        let before: f64 = weights.iter().map(|&(k, weight)| (weight * fit.unknowns[k].prior_sigma).powi(2)).sum();
        let determined = sum.determined || seen().all(|&(k, _)| fit.estimates[k].determined);
        Number {
            axis,
            what: What::Pivot,
            component,
            change: weights.iter().map(|&(k, weight)| weight * fit.estimates[k].value).sum(),
            // the ball's own place in the spindle is no part of a vector that was fitted
            sigma: if is_free { sum.sigma.hypot(seat_mm) } else { sum.sigma },
            // of what only its spread holds the readings say nothing: half of the variance at most may be that
            determined: determined && 2.0 * sum.sigma.powi(2) < before,
        }
    };
    machine.axes[axis].across().map(number).collect()
}
