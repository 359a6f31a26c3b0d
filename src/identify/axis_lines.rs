//! Where the lines of the rotary axes stand by a fit, with all axes at zero: what a control is told. It solves nothing.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::estimate::{Fit, FreeLocation};
use super::model::unknowns::Quantity;
use crate::chain::{Branch, Chain, Composition, Geometry};
use crate::machine::{AxisKind, Machine};
use crate::session::Session;

/// The line of a rotary axis in R with all axes at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisLine {
    /// Axis index.
    pub axis: usize,
    /// The axis belongs to the spindle's branch.
    pub is_head: bool,
    /// The rotary axis that carries it, if any.
    pub carrier: Option<usize>,
    /// Where the line stands off its nominal place, across its direction, mm; of a table axis beside a head as seen from the spindle.
    pub shift_mm: Vector3<f64>,
    pub shift_sigma_mm: Vector3<f64>,
    /// The same relative to the carrier's line; equal to `shift_mm` without a carrier.
    pub from_carrier_mm: Vector3<f64>,
    pub from_carrier_sigma_mm: Vector3<f64>,
    /// Unit vector of the line.
    pub direction: Vector3<f64>,
    /// Turn of the line about x, y, z, rad; the part about its own direction is zero.
    pub tilt_rad: Vector3<f64>,
    pub tilt_sigma_rad: Vector3<f64>,
    /// Positions that bring the spindle's zero point over the line: machine coordinate of a linear axis (mm, index), or
    /// distance from its zero when the machine file does not state `machine_zero`; `None` for heads and inclined axes.
    pub centre_at: Vec<CentreReading>,
    /// The line depends on free errors, and each of them is determined by the data.
    pub determined: bool,
    /// The same for each component (x, y, z) of shift, shift from the carrier and tilt.
    pub shift_determined: [bool; 3],
    pub from_carrier_determined: [bool; 3],
    pub tilt_determined: [bool; 3],
}

/// What a linear axis reads when the spindle stands over the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentreReading {
    /// Linear axis, by index.
    pub axis: usize,
    pub reading_mm: f64,
    pub sigma_mm: f64,
    /// The reading is a machine coordinate; else it counts from the axis's zero in the session.
    pub is_machine_coordinate: bool,
    /// The axis reads less where the spindle stands farther along R's direction over the table.
    pub counts_against: bool,
}

/// Step of the differences by which uncertainties travel, mm and rad; places are nearly linear in errors.
const STEP: f64 = 1e-4;

/// A component depends on an error whose millimetre or radian moves it by this, mm or rad: what errors do to each other in
/// second order is left out.
const LEAST_DEPENDENCE: f64 = 1e-2;

/// Lines of all rotary axes, in the order of the structural code.
pub fn axis_lines(session: &Session, fit: &Fit) -> Vec<AxisLine> {
    let machine = &session.machine;
    let chain = Chain::of(machine);
    let (free, covariance) = fit.location_covariance();
    let errors = fitted_errors(machine, fit, &free);
    let rotary = machine.axes_of(AxisKind::Rotary);
    rotary
        .map(|axis| {
            let quantities = |errors: &[[f64; 6]]| line_quantities(&chain, axis, errors);
            let at = quantities(&errors);
            let mut jacobian = DMatrix::zeros(at.len(), free.len());
            for (column, one) in free.iter().enumerate() {
                let [more, less] = to_both_sides(&errors, one);
                for (row, (up, down)) in quantities(&more).iter().zip(quantities(&less)).enumerate() {
                    jacobian[(row, column)] = (up - down) / (2.0 * STEP);
                }
            }
            let spread = &jacobian * &covariance * jacobian.transpose();
            let sigma = |from: usize| Vector3::from_fn(|k, _| spread[(from + k, from + k)].max(0.0).sqrt());
            let value = |from: usize| Vector3::from_fn(|k, _| at[from + k]);
            // what no free error moves was not fitted
            let all_determined = |moves: &dyn Fn(usize) -> bool| {
                let mut moving = free.iter().enumerate().filter(|(column, _)| moves(*column)).peekable();
                moving.peek().is_some() && moving.all(|(_, one)| fit.estimates[one.unknown].determined)
            };
            let determined = all_determined(&|column| jacobian.column(column).amax() >= 1e-9);
            // steps of one error move some components and others not
            let is_determined =
                |row: usize| all_determined(&|column| jacobian[(row, column)].abs() >= LEAST_DEPENDENCE);
            let determined_from = |from: usize| [0, 1, 2].map(|k| is_determined(from + k));
            let line = AxisLine {
                axis,
                is_head: chain.carried_by(axis).branch == Branch::Tool,
                carrier: carrier(&chain, axis),
                shift_mm: value(0),
                shift_sigma_mm: sigma(0),
                from_carrier_mm: value(6),
                from_carrier_sigma_mm: sigma(6),
                direction: chain.joint(axis).direction + value(3).cross(&chain.joint(axis).direction),
                tilt_rad: value(3),
                tilt_sigma_rad: sigma(3),
                centre_at: Vec::new(),
                determined,
                shift_determined: determined_from(0),
                tilt_determined: determined_from(3),
                from_carrier_determined: determined_from(6),
            };
            let is_nearest_to_bed = !line.is_head && line.carrier.is_none();
            let line = match is_nearest_to_bed.then(|| from_spindle(session, fit, axis)).flatten() {
                Some(shift) => with_shift(line, &shift),
                None => line,
            };
            AxisLine { centre_at: centre_at(session, &chain, &line), direction: line.direction.normalize(), ..line }
        })
        .collect()
}

/// Location errors of all axes, the free ones as fitted.
fn fitted_errors(machine: &Machine, fit: &Fit, free: &[FreeLocation]) -> Vec<[f64; 6]> {
    let mut errors = machine.location_errors();
    for one in free {
        errors[one.axis][one.component] = fit.estimates[one.unknown].value;
    }
    errors
}

/// Errors with one of them a step more, and a step less.
fn to_both_sides(errors: &[[f64; 6]], one: &FreeLocation) -> [Vec<[f64; 6]>; 2] {
    [STEP, -STEP].map(|step| {
        let mut moved = errors.to_vec();
        moved[one.axis][one.component] += step;
        moved
    })
}

/// The same line with its shift told from the spindle.
fn with_shift(line: AxisLine, shift: &Shift) -> AxisLine {
    AxisLine {
        shift_mm: shift.value,
        shift_sigma_mm: shift.sigma,
        shift_determined: shift.determined,
        from_carrier_mm: shift.value,
        from_carrier_sigma_mm: shift.sigma,
        from_carrier_determined: shift.determined,
        ..line
    }
}

/// Shift, tilt and shift from the carrier of an axis's line: nine numbers.
fn line_quantities(chain: &Chain, axis: usize, errors: &[[f64; 6]]) -> [f64; 9] {
    let geometry = Geometry::new(chain, errors, Composition::Exact);
    let zero = vec![0.0; chain.axis_count()];
    let joint = chain.joint(axis);
    let across = |vector: Vector3<f64>| vector - joint.direction * joint.direction.dot(&vector);
    let pose = geometry.pose(chain.carried_by(axis), &zero, None);
    let shift = across(pose.point(&joint.origin) - joint.origin);
    let tilt = joint.direction.cross(&(pose.rotation * joint.direction));
    let from_carrier = match carrier(chain, axis) {
        None => shift,
        Some(carrier) => {
            let pose = geometry.pose(chain.carried_by(carrier), &zero, None);
            // where the carrier would have brought the line, had it no error of its own
            shift - across(pose.point(&joint.origin) - joint.origin)
        }
    };
    let mut list = [0.0; 9];
    for (part, vector) in [shift, tilt, from_carrier].iter().enumerate() {
        list[3 * part..3 * part + 3].copy_from_slice(vector.as_slice());
    }
    list
}

/// A shift of a line, mm, by component.
struct Shift {
    value: Vector3<f64>,
    sigma: Vector3<f64>,
    determined: [bool; 3],
}

/// Where a table axis's line stands from the spindle, of a machine whose spindle is carried by a rotary axis; `None` of others.
///
/// The line of the table axis less that of the head axis less the spindle ball's own place from there, of the first ball in the spindle, across
/// the table's axis. Only this difference is seen, and only this one matters: a head that stands elsewhere as a whole is a zero shift of the slides.
fn from_spindle(session: &Session, fit: &Fit, axis: usize) -> Option<Shift> {
    let machine = &session.machine;
    let head = machine.spindle_axis()?;
    let chain = Chain::of(machine);
    let (free, _) = fit.location_covariance();
    let errors = fitted_errors(machine, fit, &free);
    let along = chain.joint(axis).direction;
    let across = Matrix3::identity() - along * along.transpose();
    let zero = vec![0.0; chain.axis_count()];
    let apart = |errors: &[[f64; 6]]| {
        let geometry = Geometry::new(&chain, errors, Composition::Exact);
        let moved = |axis: usize| {
            let origin = chain.joint(axis).origin;
            geometry.pose(chain.carried_by(axis), &zero, None).point(&origin) - origin
        };
        across * (moved(axis) - moved(head))
    };
    let mut weights: Vec<(usize, Vector3<f64>)> = free
        .iter()
        .map(|one| {
            let [more, less] = to_both_sides(&errors, one);
            (one.unknown, (apart(&more) - apart(&less)) / (2.0 * STEP))
        })
        .collect();
    let mut value = apart(&errors);
    for (k, unknown) in fit.unknowns.iter().enumerate() {
        if let Quantity::SpindleBall { setup: 0, coordinate } = unknown.quantity {
            let moves = -across.column(coordinate).into_owned();
            value += moves * fit.estimates[k].value;
            weights.push((k, moves));
        }
    }
    let seat_mm = session.spread.spindle_ball_mm;
    let of = |row: usize| -> Vec<(usize, f64)> { weights.iter().map(|(k, moves)| (*k, moves[row])).collect() };
    let sums = [0, 1, 2].map(|row| fit.sum_of(&of(row), seat_mm));
    Some(Shift {
        value,
        // with a ball that sits in the spindle to within its spread
        sigma: Vector3::from_fn(|row, _| sums[row].sigma.hypot(seat_mm * across[(row, row)].max(0.0).sqrt())),
        determined: sums.map(|sum| sum.determined),
    })
}

/// The nearest rotary axis towards the bed.
fn carrier(chain: &Chain, axis: usize) -> Option<usize> {
    let path = chain.path(chain.carried_by(axis));
    let place = path.iter().position(|&other| other == axis)?;
    path[..place].iter().rev().copied().find(|&other| chain.joint(other).kind == AxisKind::Rotary)
}

/// Readings of the linear axes that bring the spindle over a table axis's line.
fn centre_at(session: &Session, chain: &Chain, line: &AxisLine) -> Vec<CentreReading> {
    let machine = &session.machine;
    if line.is_head || machine.axes[line.axis].coordinate_direction().is_none() {
        return Vec::new();
    }
    let joint = chain.joint(line.axis);
    let mut linear: Vec<usize> = machine.axes_of(AxisKind::Linear).collect();
    linear.sort_by_key(|&axis| machine.axes[axis].coordinate_direction());
    linear
        .into_iter()
        .filter_map(|axis| {
            let k = machine.axes[axis].coordinate_direction()?;
            // along the line itself there is no centre
            if joint.direction[k].abs() > 0.5 {
                return None;
            }
            let place = joint.origin[k] + line.shift_mm[k];
            let along = machine.tool_sign(axis) * machine.axes[axis].direction[k];
            let zero = machine.machine_zero[axis];
            Some(CentreReading {
                axis,
                reading_mm: zero.unwrap_or(0.0) + place / along,
                sigma_mm: line.shift_sigma_mm[k],
                is_machine_coordinate: zero.is_some(),
                counts_against: along < 0.0,
            })
        })
        .collect()
}
