//! Which errors a plan wants, and what a test tells of them: rows of derivatives. First order, no files; `posterior` puts tests together.
//!
//! Unknowns are the location errors of the rotary axes (wanted), the pivot length where it is wanted (`EY0S`: the vector from the last head axis to
//! the spindle S, which every ball in the spindle follows), those of the linear axes (known to their squareness
//! spread), every placement (pivot, spindle ball), bar error, and the misplacement of the linear axes at each place where
//! they stand, growing with the distance from where the spindle ball was set up; where they move, what they go too far about
//! the middle of their motion. A test adds rows `δL = H·x + ε`.

use nalgebra::{DMatrix, Matrix3, RowVector3, SMatrix, SymmetricEigen, Vector3};

use super::block::{BLOCK_ROWS, Block, HELD, LOOSE, Nuisance, Part, place_in_arc};
use super::uncertainty::Uncertainty;
use crate::chain::{Geometry, LinkId, Sensitivity};
use crate::machine::{AxisKind, Component, ErrorName, LinearAxes, Machine, is_by_choice_of_r};

/// The two balls of a test and the bar between them.
#[derive(Debug, Clone, Copy)]
pub struct Balls<'a> {
    /// Link, its name and the place on it.
    pub pivot: (LinkId, &'a str, &'a Vector3<f64>),
    pub spindle: (LinkId, &'a Vector3<f64>),
    pub bar_mm: f64,
}

/// Which errors are unknown, and their priors.
#[derive(Debug, Clone)]
pub struct Unknowns {
    /// Axis index, component index, name; the wanted ones first.
    pub errors: Vec<(usize, usize, ErrorName)>,
    /// Number of wanted errors.
    pub wanted: usize,
    /// Of the pivot length, which follows the rotary axes' errors: directions across the last head axis, whose index those errors have.
    pivot_length: Vec<Vector3<f64>>,
    /// Place of the first of them among the errors.
    first_of_pivot: usize,
    pub(crate) prior_variance: Vec<f64>,
    /// Of inclined rotary axes that carry the workpiece: a shift along the own line, and a turn about it, as parts of the errors. No reading
    /// shows them, so the errors are counted without.
    pub(super) along_own_lines: Vec<Vec<(usize, f64)>>,
    uncertainty: Uncertainty,
    /// What the linear axes may be off, by the machine file.
    linear: LinearAxes,
}

/// Name of the spindle in those of its location errors, by ISO 230-1.
const SPINDLE: &str = "S";

/// Two unit vectors across a line, along coordinate directions where these are across it, each with the component that its name has: of the
/// largest part, which is positive, the last of equal ones.
fn across(along: &Vector3<f64>) -> [(usize, Vector3<f64>); 2] {
    let least = along.iamin();
    let first = Vector3::ith(least, 1.0);
    let first = (first - along * along.dot(&first)).normalize();
    [first, along.cross(&first)].map(|direction| {
        // to the nanometre per metre: rounding makes no part the larger one
        let size = |k: usize| (direction[k].abs() * 1e9).round();
        let component = (0..3).max_by(|&one, &other| size(one).total_cmp(&size(other))).unwrap_or(least);
        (component, direction * direction[component].signum())
    })
}

/// A ball's place to the nanometre, so that balls at one place are one.
pub(crate) fn key(at: &Vector3<f64>) -> [i64; 3] {
    [0, 1, 2].map(|k| (at[k] * 1e6).round() as i64)
}

impl Unknowns {
    /// Location errors of the rotary axes as wanted, those of the linear axes as spread.
    pub fn of(machine: &Machine, uncertainty: Uncertainty) -> Unknowns {
        let linear = machine.linear_axes;
        let mut unknowns = Unknowns {
            errors: Vec::new(),
            wanted: 0,
            pivot_length: Vec::new(),
            first_of_pivot: 0,
            prior_variance: Vec::new(),
            along_own_lines: Vec::new(),
            uncertainty,
            linear,
        };
        unknowns.push(machine, AxisKind::Rotary, |component| match component.is_angle() {
            false => uncertainty.wanted_mm,
            true => uncertainty.wanted_rad,
        });
        unknowns.find_own_lines(machine);
        unknowns.first_of_pivot = unknowns.errors.len();
        unknowns.push_pivot_length(machine);
        unknowns.wanted = unknowns.errors.len();
        unknowns.push(machine, AxisKind::Linear, |_| linear.squareness_rad);
        unknowns
    }

    /// Location errors of the rotary axes and the squareness of the linear axes, all wanted.
    ///
    /// EB0X, EC0X and EA0Y are no unknowns then: R's x runs along X and its x–y plane contains Y.
    pub fn with_squareness(machine: &Machine, uncertainty: Uncertainty) -> Unknowns {
        let mut unknowns = Unknowns::of(machine, uncertainty);
        for k in (unknowns.wanted..unknowns.errors.len()).rev() {
            let (axis, component, _) = &unknowns.errors[k];
            if is_by_choice_of_r(&machine.axes[*axis], Component::ALL[*component]) {
                unknowns.errors.remove(k);
                unknowns.prior_variance.remove(k);
            } else {
                unknowns.prior_variance[k] = uncertainty.wanted_rad.powi(2);
            }
        }
        unknowns.wanted = unknowns.errors.len();
        unknowns
    }

    fn push(&mut self, machine: &Machine, kind: AxisKind, sigma: impl Fn(Component) -> f64) {
        for (axis, entry) in machine.axes.iter().enumerate().filter(|(_, entry)| entry.kind == kind) {
            for component in entry.slots() {
                self.errors.push((axis, component.index(), ErrorName::location(component, &entry.name)));
                self.prior_variance.push(sigma(component).powi(2));
            }
        }
    }

    /// Shifts along and turns about the own lines of inclined rotary axes that carry the workpiece, among the errors so far. What a bar tells
    /// of a head's place are sums with the table's, whatever is held.
    fn find_own_lines(&mut self, machine: &Machine) {
        for axis in machine.inclined_table_axes() {
            let direction = &machine.axes[axis].direction;
            for of_turns in [false, true] {
                let own =
                    self.errors.iter().enumerate().filter(|(_, (of, component, _))| {
                        *of == axis && Component::ALL[*component].is_angle() == of_turns
                    });
                let parts = |(place, (_, component, _)): (usize, &(usize, usize, ErrorName))| {
                    (place, direction[Component::ALL[*component].direction_index()])
                };
                self.along_own_lines.push(own.map(parts).collect());
            }
        }
    }

    /// The vector from the last head axis to the spindle, across the axis, where its spread says that it is not known.
    fn push_pivot_length(&mut self, machine: &Machine) {
        let length_mm = self.uncertainty.spread.pivot_length_mm;
        let Some(axis) = machine.spindle_axis().filter(|_| length_mm > 0.0) else { return };
        for (component, direction) in across(&machine.axes[axis].direction) {
            self.errors.push((axis, component, ErrorName::location(Component::ALL[component], SPINDLE)));
            self.prior_variance.push(length_mm.powi(2));
            self.pivot_length.push(direction);
        }
    }

    /// Spreads and noise that the forecast takes.
    pub fn uncertainty(&self) -> Uncertainty {
        self.uncertainty
    }

    /// What the linear axes may be off.
    pub fn linear_axes(&self) -> LinearAxes {
        self.linear
    }

    /// Prior standard deviation of an error, mm or rad; of an inclined axis that of its part across the own line.
    pub fn prior(&self, error: usize) -> f64 {
        let along = self.along_own_lines.iter().flatten().filter(|(place, _)| *place == error);
        let across: f64 = 1.0 - along.map(|(_, part)| part * part).sum::<f64>();
        (self.prior_variance[error] * across).sqrt()
    }

    /// The same with the linear axes known exactly: square, and standing where they are told to.
    pub fn with_exact_linear_axes(&self) -> Unknowns {
        let mut exact = self.clone();
        exact.prior_variance[self.wanted..].iter_mut().for_each(|variance| *variance *= HELD);
        exact
    }

    /// Rows of a test that visits `poses`, evenly over its sweep; `arc_rad` is the length of that.
    pub fn block(&self, geometry: &Geometry, balls: Balls, poses: &[Vec<f64>], arc_rad: f64) -> Block {
        let block = self.rows(geometry, balls, poses, self.row_variance(poses.len(), arc_rad));
        let turned = self.seen_rows(&block);
        block.with_rows(&turned)
    }

    /// The same for an axis that turns alone, which asks for three poses only.
    ///
    /// One ball stands still and the other goes round a circle, so every derivative is `c₀ + c₁·cos φ + c₂·sin φ`. Three
    /// places a third of a turn apart tell c, wherever the arc lies; over the poses of the arc the rows are `V·c` with
    /// `V = [1 cos φ sin φ]`, and with `V = Q·R` the three rows `R·c` tell all that they do.
    pub fn turn_block(
        &self,
        geometry: &Geometry,
        balls: Balls,
        pose: impl Fn(f64) -> Vec<f64>,
        (from, to): (f64, f64),
    ) -> Block {
        let third = std::f64::consts::TAU / 3.0;
        let thirds = [0.0, third, 2.0 * third];
        let block = self.rows(geometry, balls, &thirds.map(pose), self.row_variance(BLOCK_ROWS, to - from));
        let of_values = Matrix3::from_rows(&[
            RowVector3::repeat(1.0 / 3.0),
            RowVector3::from(thirds.map(|angle| 2.0 / 3.0 * angle.cos())),
            RowVector3::from(thirds.map(|angle| 2.0 / 3.0 * angle.sin())),
        ]);
        let over_arc = SMatrix::<f64, BLOCK_ROWS, 3>::from_fn(|row, column| {
            let angle = place_in_arc(from, to, row);
            [1.0, angle.cos(), angle.sin()][column]
        });
        let turned = over_arc.qr().r() * of_values;
        block.with_rows(&DMatrix::from_column_slice(3, 3, turned.as_slice()))
    }

    /// Variance of each of some rows over an arc, mm².
    fn row_variance(&self, rows: usize, arc_rad: f64) -> f64 {
        // both directions are run: twice the samples
        let samples = (2.0 * self.uncertainty.samples_per_turn * arc_rad / std::f64::consts::TAU).max(6.0);
        self.uncertainty.noise_mm.powi(2) * rows as f64 / samples
    }

    /// A row for each pose.
    fn rows(&self, geometry: &Geometry, balls: Balls, poses: &[Vec<f64>], row_variance: f64) -> Block {
        let Balls { pivot, spindle, bar_mm } = balls;
        let chain = geometry.chain();
        let rows = poses.len();
        let mut errors = DMatrix::zeros(rows, self.errors.len());
        let [mut at_pivot, mut at_spindle, mut stand] = [(); 3].map(|()| DMatrix::zeros(rows, 3));
        let mut by_position = DMatrix::zeros(rows, chain.axis_count());
        let mut derivatives = Sensitivity::zeros(chain.axis_count());
        for (row, positions) in poses.iter().enumerate() {
            geometry.sensitivity((pivot.0, pivot.2), (spindle.0, spindle.1), positions, None, &mut derivatives);
            for (column, &(axis, component, _)) in self.errors.iter().enumerate() {
                let of_pivot = column.checked_sub(self.first_of_pivot).and_then(|k| self.pivot_length.get(k));
                errors[(row, column)] = match of_pivot {
                    Some(direction) => (0..3).map(|k| direction[k] * derivatives.spindle[k]).sum(),
                    None => derivatives.location[axis][component],
                };
            }
            derivatives.position.iter().enumerate().for_each(|(k, value)| by_position[(row, k)] = *value);
            for k in 0..3 {
                at_pivot[(row, k)] = derivatives.pivot[k];
                at_spindle[(row, k)] = derivatives.spindle[k];
                stand[(row, k)] = derivatives.direction[k];
            }
        }
        let u = &self.uncertainty;
        let is_linear = |axis: &usize| chain.joint(*axis).kind == AxisKind::Linear;
        let slides: Vec<usize> = (0..chain.axis_count()).filter(is_linear).collect();
        let middle = |axis: usize| poses.iter().map(|q| q[axis]).sum::<f64>() / rows.max(1) as f64;
        let linear: Vec<f64> = slides.iter().map(|&axis| middle(axis)).collect();
        // in each direction of R what the axes get wrong together, each along or across its way
        let moved_to = slides.iter().zip(&linear).fold(Vector3::zeros(), |sum: Vector3<f64>, (&axis, q)| {
            sum + self.linear.per_length(&chain.joint(axis).direction).map(|sigma| (sigma * q).powi(2))
        });
        let stand_variance = moved_to.max();
        let place: Vec<i64> = linear.iter().map(|q| (q * 1e6).round() as i64).collect();
        let from_middle = |row: usize, k: usize| match poses[row][slides[k]] - linear[k] {
            // rounding of a mean is no motion
            off if off.abs() < 1e-6 => 0.0,
            off => off,
        };
        let scale = DMatrix::from_fn(rows, slides.len(), |row, k| by_position[(row, slides[k])] * from_middle(row, k));
        let mut nuisances = vec![
            Part::new(Nuisance::Pivot(pivot.1.to_string(), key(pivot.2)), at_pivot, u.spread.pivot_mm.powi(2)),
            Part::new(Nuisance::SpindleBall(key(spindle.1)), at_spindle, u.spread.spindle_ball_mm.powi(2)),
            Part::new(
                Nuisance::Bar((bar_mm * 1e6).round() as i64),
                DMatrix::from_element(rows, 1, 1.0),
                u.zero.spread_mm(u.spread.bar_length_mm).powi(2),
            ),
        ];
        if stand_variance > 0.0 && linear.iter().any(|q| q.abs() > 1e-6) {
            (0..3).for_each(|k| stand.column_mut(k).scale_mut((moved_to[k] / stand_variance).sqrt()));
            nuisances.push(Part::new(Nuisance::Stand(place.clone()), stand, stand_variance));
        }
        if scale.amax() > 0.0 && self.linear.positioning > 0.0 {
            nuisances.push(Part::new(Nuisance::Scale(place), scale, self.linear.positioning.powi(2)));
        }
        Block { errors, nuisances, row_variance }
    }

    /// Orthonormal combinations of a block's rows that carry more than noise. White noise stays white in them, so they tell
    /// what all rows tell.
    fn seen_rows(&self, block: &Block) -> DMatrix<f64> {
        let mut products = SMatrix::<f64, BLOCK_ROWS, BLOCK_ROWS>::zeros();
        let mut add = |column: nalgebra::DVectorView<f64>, variance: f64| {
            for i in 0..BLOCK_ROWS {
                for j in 0..=i {
                    products[(i, j)] += variance * column[i] * column[j];
                }
            }
        };
        self.prior_variance.iter().enumerate().for_each(|(k, variance)| add(block.errors.column(k), *variance));
        for Part { of, columns, variance, .. } in &block.nuisances {
            let factor = if of.is_fitted() { LOOSE } else { 1.0 };
            columns.column_iter().for_each(|column| add(column, variance * factor));
        }
        products.fill_upper_triangle_with_lower_triangle();
        let eigen = SymmetricEigen::new(products);
        let seen: Vec<usize> =
            (0..BLOCK_ROWS).filter(|&k| eigen.eigenvalues[k] > UNSEEN * block.row_variance).collect();
        DMatrix::from_fn(seen.len(), BLOCK_ROWS, |row, column| eigen.eigenvectors[(column, seen[row])])
    }
}

/// Share of a row's noise variance below which a combination of rows tells nothing.
const UNSEEN: f64 = 1e-3;
