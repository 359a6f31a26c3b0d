//! How much of a trace the location errors and setup cannot absorb: a Jacobian by differences and an orthogonal basis.

use super::kinematics::{AXES, Disturbance, Setup, distance};
use super::nuisance::slots;
use super::plan::{Plan, Test};

/// Step of the central differences, mm or rad × 100 mm.
const STEP: f64 = 1e-3;
/// A column whose remainder after the others is below this share adds no direction.
const DEPENDENT: f64 = 1e-6;

/// Orthonormal basis of everything the nuisance parameters can produce over the session's rows.
pub struct Absorbed {
    basis: Vec<Vec<f64>>,
}

/// One nuisance parameter.
#[derive(Clone, Copy)]
enum Parameter {
    Slot(usize, usize),
    Pivot(usize, usize),
    Ball(usize, usize),
    Bar(usize),
}

fn nominal(plan: &Plan, test: &Test) -> Setup {
    Setup { pivot: plan.pivot(test), pivot_offset: [0.0; 3], ball: plan.ball(test), ball_offset: [0.0; 3] }
}

/// True ball places of a test.
pub fn setup(plan: &Plan, test: &Test) -> Setup {
    Setup {
        pivot: plan.pivot(test),
        pivot_offset: plan.pivots[test.pivot].offset_mm,
        ball: plan.ball(test),
        ball_offset: plan.balls[test.ball].offset_mm,
    }
}

impl Absorbed {
    /// Derivatives are taken at the nominal machine, where what is degenerate is so exactly.
    pub fn of(plan: &Plan) -> Self {
        Self::at(plan, &|i, row| {
            let test = &plan.tests[i];
            plan.axes_at(test, row as f64 * test.step_s)
        })
    }

    /// The same for whoever believes the axes stood at `positions` (test, row).
    pub fn at(plan: &Plan, positions: &dyn Fn(usize, usize) -> [f64; AXES]) -> Self {
        let mut parameters: Vec<Parameter> =
            slots(&plan.machine).into_iter().map(|(j, c)| Parameter::Slot(j, c)).collect();
        parameters.extend((0..plan.pivots.len()).flat_map(|i| (0..3).map(move |c| Parameter::Pivot(i, c))));
        parameters.extend((0..plan.balls.len()).flat_map(|i| (0..3).map(move |c| Parameter::Ball(i, c))));
        parameters.extend((0..plan.bars.len()).map(Parameter::Bar));
        let mut basis: Vec<Vec<f64>> = vec![];
        for p in parameters {
            let mut column = column(plan, p, positions);
            let before = norm(&column);
            if before == 0.0 {
                continue;
            }
            // twice is enough
            for _ in 0..2 {
                subtract(&mut column, &basis);
            }
            let left = norm(&column);
            if left > DEPENDENT * before {
                column.iter_mut().for_each(|x| *x /= left);
                basis.push(column);
            }
        }
        Absorbed { basis }
    }

    pub fn rank(&self) -> usize {
        self.basis.len()
    }

    /// What is left of a trace over all rows.
    pub fn remainder(&self, trace: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut flat: Vec<f64> = trace.iter().flatten().copied().collect();
        subtract(&mut flat, &self.basis);
        let mut left = flat.as_slice();
        trace
            .iter()
            .map(|rows| {
                let (head, tail) = left.split_at(rows.len());
                left = tail;
                head.to_vec()
            })
            .collect()
    }
}

fn subtract(column: &mut [f64], basis: &[Vec<f64>]) {
    for b in basis {
        let share: f64 = b.iter().zip(column.iter()).map(|(x, y)| x * y).sum();
        column.iter_mut().zip(b).for_each(|(y, x)| *y -= share * x);
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn column(plan: &Plan, p: Parameter, positions: &dyn Fn(usize, usize) -> [f64; AXES]) -> Vec<f64> {
    let still = Disturbance::default();
    let mut out = vec![];
    for (i, test) in plan.tests.iter().enumerate() {
        let touched = match p {
            Parameter::Slot(..) => true,
            Parameter::Pivot(k, _) => k == test.pivot,
            Parameter::Ball(k, _) => k == test.ball,
            Parameter::Bar(k) => k == test.bar,
        };
        for row in 0..test.rows {
            if !touched {
                out.push(0.0);
                continue;
            }
            if let Parameter::Bar(_) = p {
                out.push(1.0);
                continue;
            }
            let q = positions(i, row);
            let at = |sign: f64| {
                let (mut e, mut s) = ([[0.0; 6]; AXES], nominal(plan, test));
                match p {
                    Parameter::Slot(j, c) if c < 3 => e[j][c] += sign * STEP,
                    Parameter::Slot(j, c) => e[j][c] += sign * STEP / 100.0,
                    Parameter::Pivot(_, c) => s.pivot_offset[c] += sign * STEP,
                    Parameter::Ball(_, c) => s.ball_offset[c] += sign * STEP,
                    Parameter::Bar(_) => {}
                }
                distance(&plan.machine, &e, &s, &q, &still)
            };
            out.push((at(1.0) - at(-1.0)) / (2.0 * STEP));
        }
    }
    out
}

/// Root mean square over all rows of a session.
pub fn rms(trace: &[Vec<f64>]) -> f64 {
    let count: usize = trace.iter().map(Vec::len).sum();
    (trace.iter().flatten().map(|x| x * x).sum::<f64>() / count.max(1) as f64).sqrt()
}
