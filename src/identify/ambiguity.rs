//! Directions that the recordings cannot tell apart, and in words what would separate them.

use crate::statistics::NoiseModel;
use nalgebra::{Cholesky, DMatrix, Dyn, SymmetricEigen};

use super::candidates::{Candidate, candidate_circles, candidate_tests};
use super::solve::Solution;
use crate::chain::Sensitivity;
use crate::identify::model::problem::Problem;
use crate::identify::model::unknowns::{Quantity, Unknown, is_arm, moves_spindle_ball};
use crate::machine::AxisKind;
use crate::units::Measure;

/// A combination of unknowns of which the data see only one sum.
#[derive(Debug, Clone, PartialEq)]
pub struct Ambiguity {
    /// Indices of the unknowns with their weight in the direction that the data do not see, largest 1.
    pub members: Vec<(usize, f64)>,
    /// What is not seen, in words.
    pub fact: String,
    /// What would separate them, in words.
    pub remedy: String,
}

impl Ambiguity {
    /// Fact and remedy in one sentence.
    pub fn says(&self) -> String {
        format!("{}; {}", self.fact, self.remedy)
    }
}

/// A direction is open when the data leave it this uncertain: 10 µm, or the 10 arcsec that move a ball as far at 200 mm.
pub(super) const OPEN_LENGTH_MM: f64 = 10e-3;
pub(super) const OPEN_ANGLE_RAD: f64 = 10.0 / crate::units::ARCSEC_PER_RAD;
/// Members with less than this share of the largest weight are left out of the words.
const SMALL_WEIGHT: f64 = 0.03;
/// Independent readings that one candidate test is worth: real sweeps of some 700 samples have about so many.
const EFFECTIVE_READINGS: f64 = 30.0;

/// The directions that the data leave open and that touch a free location error, with the linear axes taken as exact.
pub fn ambiguities(problem: &Problem, solution: &Solution, noise: &[NoiseModel]) -> Vec<Ambiguity> {
    let unknowns = &problem.unknowns[..problem.asked];
    let count = unknowns.len();
    let scale: Vec<f64> = unknowns
        .iter()
        .map(|unknown| match unknown.measure {
            Measure::Angle => OPEN_ANGLE_RAD / unknown.prior_sigma,
            _ => OPEN_LENGTH_MM / unknown.prior_sigma,
        })
        .collect();
    let information = DMatrix::from_fn(count, count, |i, j| solution.information[(i, j)] * scale[i] * scale[j]);
    if count == 0 || information.iter().any(|value| !value.is_finite()) {
        return Vec::new();
    }
    let eigen = SymmetricEigen::new(information);
    let open: Vec<usize> = (0..count).filter(|&k| eigen.eigenvalues[k] < 1.0).collect();
    let rows: Vec<Vec<f64>> = open.iter().map(|&k| eigen.eigenvectors.column(k).iter().copied().collect()).collect();
    let directions = sparse_directions(rows, unknowns);
    if directions.is_empty() {
        return Vec::new();
    }
    let mut candidates = candidate_tests(problem.session, problem.chain);
    let machine = &problem.session.machine;
    let is_square = |unknown: &Unknown| {
        matches!(unknown.quantity, Quantity::Location { axis, component }
            if machine.axes[axis].kind == AxisKind::Linear && component.is_angle())
    };
    if unknowns.iter().any(is_square) {
        candidates.extend(candidate_circles(problem.session, problem.chain));
    }
    let separators = Separators::new(problem, solution, noise, &candidates);
    directions
        .into_iter()
        .map(|members| {
            let (fact, remedy) = (fact(problem, &members), remedy(problem, &members, &separators));
            Ambiguity { members, fact, remedy }
        })
        .collect()
}

/// A basis of the open space in which every direction has few members and leads with one location error (Gauss–Jordan).
fn sparse_directions(mut rows: Vec<Vec<f64>>, unknowns: &[Unknown]) -> Vec<Vec<(usize, f64)>> {
    let mut directions = Vec::new();
    let columns: Vec<usize> = (0..unknowns.len()).collect();
    let (location, setup): (Vec<usize>, Vec<usize>) = columns.iter().partition(|&&k| !unknowns[k].quantity.is_setup());
    let mut done = 0;
    for group in [location, setup] {
        let mut left = group;
        while done < rows.len() {
            let best = left
                .iter()
                .flat_map(|&column| (done..rows.len()).map(move |row| (row, column)))
                .max_by(|a, b| rows[a.0][a.1].abs().total_cmp(&rows[b.0][b.1].abs()));
            let Some((row, column)) = best.filter(|&(row, column)| rows[row][column].abs() > 0.1) else { break };
            rows.swap(done, row);
            let pivot = rows[done][column];
            rows[done].iter_mut().for_each(|value| *value /= pivot);
            let lead = rows[done].clone();
            for (other, values) in rows.iter_mut().enumerate() {
                if other != done {
                    let factor = values[column];
                    values.iter_mut().zip(&lead).for_each(|(value, lead)| *value -= factor * lead);
                }
            }
            left.retain(|&k| k != column);
            done += 1;
        }
    }
    for row in &rows[..done] {
        let largest = row.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
        let mut members: Vec<(usize, f64)> = row
            .iter()
            .enumerate()
            .map(|(k, value)| (k, value / largest))
            .filter(|(_, value)| value.abs() > SMALL_WEIGHT)
            .collect();
        members.sort_by_key(|member| member.0);
        if members.iter().any(|(k, _)| !unknowns[*k].quantity.is_setup()) {
            directions.push(members);
        }
    }
    // in the order of the errors: pivots of equal size would else come in an order of rounding
    directions.sort_by_key(|members| members.iter().map(|(k, _)| *k).find(|&k| !unknowns[k].quantity.is_setup()));
    directions
}

/// What candidate tests would add to the fit.
struct Separators<'a> {
    candidates: &'a [Candidate],
    /// Covariance now, in units of the priors.
    covariance: DMatrix<f64>,
    /// By candidate.
    seen: Vec<Seen>,
}

/// What a candidate's readings would say.
struct Seen {
    /// Covariance of its readings, in units of their noise, with the unknowns.
    with_unknowns: DMatrix<f64>,
    /// The factor of that of its readings with each other; `None` where they tell nothing.
    factor: Option<Cholesky<f64, Dyn>>,
}

impl<'a> Separators<'a> {
    fn new(
        problem: &Problem,
        solution: &Solution,
        noise: &[NoiseModel],
        candidates: &'a [Candidate],
    ) -> Separators<'a> {
        let count = problem.asked;
        let with_prior = solution.information_of(count) + DMatrix::identity(count, count);
        let covariance = inverse(&with_prior);
        let seen = candidates
            .iter()
            .map(|candidate| {
                let rows = candidate_columns(problem, solution, candidate);
                let reading_mm = noise[candidate.like].rms_mm() * (rows.nrows() as f64 / EFFECTIVE_READINGS).sqrt();
                let columns = rows / reading_mm;
                let with_unknowns = &columns * &covariance;
                let noise = DMatrix::identity(columns.nrows(), columns.nrows());
                let factor = Cholesky::new(&with_unknowns * columns.transpose() + noise);
                Seen { with_unknowns, factor }
            })
            .collect();
        Separators { candidates, covariance, seen }
    }

    /// The candidate that best fixes an unknown, with the factor by which its sigma shrinks.
    fn best_for(&self, unknown: usize) -> Option<(&Candidate, f64)> {
        let now = self.covariance[(unknown, unknown)];
        let after = (0..self.candidates.len()).map(|candidate| self.after(candidate, unknown));
        let (best, after) = after.enumerate().min_by(|(_, one), (_, other)| one.total_cmp(other))?;
        Some((&self.candidates[best], (after / now).sqrt()))
    }

    /// Variance of an unknown with the readings of a candidate: `C_kk − c'(1 + RCR')⁻¹c` with `c = RC e_k`, R its columns.
    fn after(&self, candidate: usize, unknown: usize) -> f64 {
        let Seen { with_unknowns, factor } = &self.seen[candidate];
        let of_unknown = with_unknowns.column(unknown).into_owned();
        let told = factor.as_ref().map_or(0.0, |factor| of_unknown.dot(&factor.solve(&of_unknown)));
        (self.covariance[(unknown, unknown)] - told).max(0.0)
    }
}

fn inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    Cholesky::new(matrix.clone())
        .map_or_else(|| DMatrix::identity(matrix.nrows(), matrix.nrows()), |factor| factor.inverse())
}

/// Derivatives of a candidate's readings by all unknowns, in units of the priors.
fn candidate_columns(problem: &Problem, solution: &Solution, candidate: &Candidate) -> DMatrix<f64> {
    let geometry = problem.geometry(&solution.values);
    let like = candidate.like;
    let links = problem.tests[like].links;
    let (pivot, spindle, _) = problem.setup_of(like, &solution.values);
    let mut s = Sensitivity::zeros(problem.chain.axis_count());
    let rows = candidate.motion.rows();
    let unknowns = &problem.unknowns[..problem.asked];
    let mut columns = DMatrix::zeros(rows, unknowns.len());
    for row in 0..rows {
        geometry.sensitivity((links.0, &pivot), (links.1, &spindle), candidate.motion.row(row), None, &mut s);
        for (k, unknown) in unknowns.iter().enumerate() {
            let derivative = match unknown.quantity {
                Quantity::Location { axis, component } => s.location[axis][component.index()],
                Quantity::Pivot { setup, coordinate } if problem.setups.pivot_of[like] == setup => s.pivot[coordinate],
                Quantity::SpindleBall { setup, coordinate }
                    if moves_spindle_ball(
                        problem.session,
                        (setup, coordinate),
                        like,
                        problem.setups.spindle_ball_of[like],
                    ) =>
                {
                    problem.session.tests[like].spindle_ball.sign(coordinate) * s.spindle[coordinate]
                }
                Quantity::Bar { setup } if problem.setups.bar_of[like] == Some(setup) => 1.0,
                _ => 0.0,
            };
            columns[(row, k)] = derivative * unknown.prior_sigma;
        }
    }
    columns
}

/// The ambiguity in words.
fn fact(problem: &Problem, members: &[(usize, f64)]) -> String {
    let name = |k: usize| problem.unknowns[k].label.clone();
    let is_setup = |k: usize| problem.unknowns[k].quantity.is_setup();
    match members {
        [(only, _)] => format!("{} is not seen at all", name(*only)),
        [(a, wa), (b, wb)] => {
            let same_unit = problem.unknowns[*a].measure == problem.unknowns[*b].measure;
            let equal = same_unit && (wa.abs() - wb.abs()).abs() < 0.05;
            match (equal, wa * wb < 0.0) {
                (true, true) => format!("{} and {} only as a sum", name(*a), name(*b)),
                (true, false) => format!("{} and {} only as a difference", name(*a), name(*b)),
                _ => format!("{} and {} only in one fixed combination", name(*a), name(*b)),
            }
        }
        more => {
            let (places, errors): (Vec<usize>, Vec<usize>) = more.iter().map(|(k, _)| *k).partition(|&k| is_setup(k));
            let errors: Vec<String> = errors.into_iter().map(name).collect();
            let places: Vec<String> = places.into_iter().map(name).collect();
            match places.len() {
                0 => format!("{} only in combination", errors.join(", ")),
                1..=3 => format!("{} and {} only in combination", errors.join(", "), places.join("; ")),
                count => format!("{} and {count} ball coordinates only in combination", errors.join(", ")),
            }
        }
    }
}

/// What would separate the members.
fn remedy(problem: &Problem, members: &[(usize, f64)], separators: &Separators) -> String {
    let lead =
        members.iter().find(|(k, _)| !problem.unknowns[*k].quantity.is_setup()).map_or(members[0].0, |(k, _)| *k);
    let has = |wanted: fn(&Quantity) -> bool| members.iter().any(|(k, _)| wanted(&problem.unknowns[*k].quantity));
    let with_spindle_ball = has(|quantity| matches!(quantity, Quantity::SpindleBall { .. }));
    let with_pivot = has(|quantity| matches!(quantity, Quantity::Pivot { .. }));
    match separators.best_for(lead) {
        Some((candidate, shrink)) if shrink < 0.5 => format!("a test of {} would separate them", candidate.says),
        _ if is_arm(&problem.session.machine) && (with_spindle_ball || with_pivot) => {
            "they move the balls and the arm alike, so a prediction for these balls does not depend on them; measure the places of the balls on base and flange, or hold some of these errors (--free names the others)".to_string()
        }
        _ if with_spindle_ball => {
            "only the place of the spindle ball itself separates them: index the spindle by 0° and 180° (across the spindle axis) or measure the gauge length (along it)".to_string()
        }
        _ if with_pivot => {
            "no sweep with these balls separates them; mount a ball at another place".to_string()
        }
        _ => "no sweep with these balls separates them; mount a ball at another place or calibrate the bar".to_string(),
    }
}
