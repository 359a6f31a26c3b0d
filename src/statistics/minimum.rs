//! Least values of functions that are cheap but not smooth.

use nalgebra::{DMatrix, DVector, Dyn, SMatrix, SVector, SymmetricEigen};
use rayon::prelude::*;

/// Steps of the grid to either side.
const GRID: i32 = 40;

/// Halvings of the grid's step, from some mm down to less than a µm.
const HALVINGS: usize = 22;

/// Where a function is least, and how much it is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Least {
    pub at: f64,
    pub value: f64,
}

/// Where a function is least within 40 steps of zero.
pub fn least_along(of: &(impl Fn(f64) -> f64 + Sync), step: f64) -> Least {
    let at = |k: i32| f64::from(k) * step;
    let grid: Vec<(f64, f64)> = (-GRID..=GRID).into_par_iter().map(|k| (at(k), of(at(k)))).collect();
    // of equals the unmoved one
    let unmoved = grid[GRID as usize];
    let (mut best, mut least) = grid.into_iter().fold(unmoved, |best, next| if next.1 < best.1 { next } else { best });
    let mut width = step;
    for _ in 0..HALVINGS {
        width *= 0.5;
        for shift in [best - width, best + width] {
            let next = of(shift);
            if next < least {
                (best, least) = (shift, next);
            }
        }
    }
    Least { at: best, value: least }
}

/// Nelder–Mead in a few variables from `start` with first steps of `size`, restarted once to leave a collapsed simplex.
pub fn minimise_few<const N: usize>(start: [f64; N], size: f64, cost: impl Fn(&[f64; N]) -> f64) -> [f64; N] {
    let first = simplex(start, size, SETTLED_COST, &cost);
    simplex(first, size / 3.0, SETTLED_COST, &cost)
}

/// Difference of costs over a simplex that has settled: twice a log likelihood tells no finer.
const SETTLED_COST: f64 = 0.02;

/// One round of Nelder–Mead, until costs over the simplex differ by less than `settled`.
fn simplex<const N: usize>(start: [f64; N], size: f64, settled: f64, cost: &impl Fn(&[f64; N]) -> f64) -> [f64; N] {
    let mut simplex: Vec<([f64; N], f64)> = (0..=N)
        .map(|vertex| {
            let mut x = start;
            if vertex > 0 {
                x[vertex - 1] += size;
            }
            (x, cost(&x))
        })
        .collect();
    for _ in 0..22 * N + 2 {
        simplex.sort_by(|one, other| one.1.total_cmp(&other.1));
        if simplex[N].1 - simplex[0].1 < settled {
            break;
        }
        let centre: [f64; N] = std::array::from_fn(|k| simplex[..N].iter().map(|(x, _)| x[k]).sum::<f64>() / N as f64);
        let worst = simplex[N];
        let along = |t: f64| -> [f64; N] { std::array::from_fn(|k| centre[k] + t * (worst.0[k] - centre[k])) };
        let try_at = |t: f64| (along(t), cost(&along(t)));
        let reflected = try_at(-1.0);
        simplex[N] = if reflected.1 < simplex[0].1 {
            let expanded = try_at(-2.0);
            if expanded.1 < reflected.1 { expanded } else { reflected }
        } else if reflected.1 < simplex[N - 1].1 {
            reflected
        } else {
            let inside = try_at(if reflected.1 < worst.1 { -0.5 } else { 0.5 });
            if inside.1 < worst.1.min(reflected.1) {
                inside
            } else {
                let lead = simplex[0].0;
                for vertex in simplex.iter_mut().skip(1) {
                    let x: [f64; N] = std::array::from_fn(|k| lead[k] + 0.5 * (vertex.0[k] - lead[k]));
                    *vertex = (x, cost(&x));
                }
                continue;
            }
        };
    }
    simplex.sort_by(|one, other| one.1.total_cmp(&other.1));
    simplex[0].0
}

/// Step of a numerical slope, and of a curvature.
const SLOPE_OVER: f64 = 1e-5;
const CURVATURE_OVER: f64 = 1e-3;
/// Longest step in any variable, and the longest first one of a start that is near.
const LONGEST_STEP: f64 = 1.0;
const FIRST_STEP_NEAR: f64 = 0.3;
/// First steps of the simplex that leads there from a start that is far, and differences of costs over it that are near.
const FIRST_STEP_FAR: f64 = 0.5;
const NEAR_COSTS: f64 = 1.0;
/// Fall that is still worth a step: the cost is twice a log likelihood, where 0.01 is nothing.
const WORTH_A_STEP: f64 = 0.005;
/// Steps at most, and halvings of one that does not fall.
const MOST_STEPS: usize = 40;
const MOST_HALVINGS: usize = 6;
/// Least curvature that the first step counts with: a variable that says nothing would run off.
const LEAST_CURVATURE: f64 = 1.0;

/// Slopes and second derivatives of a function at a place.
struct Slopes<const N: usize> {
    gradient: SVector<f64, N>,
    second: SymmetricEigen<f64, Dyn>,
}

impl<const N: usize> Slopes<N> {
    fn of(cost: &impl Fn(&[f64; N]) -> f64, x: &[f64; N], there: f64) -> Slopes<N> {
        const H: f64 = CURVATURE_OVER;
        let ends: [[f64; 2]; N] = std::array::from_fn(|k| [H, -H].map(|by| cost(&moved(x, k, by))));
        let mut second = DMatrix::from_diagonal(&DVector::from_fn(N, |k, _| ends[k][0] - 2.0 * there + ends[k][1]));
        for i in 0..N {
            for j in 0..i {
                let both = cost(&moved(&moved(x, i, H), j, H)) - ends[i][0] - ends[j][0] + there;
                (second[(i, j)], second[(j, i)]) = (both, both);
            }
        }
        let gradient = SVector::from_fn(|k, _| 0.5 * (ends[k][0] - ends[k][1]) / H);
        Slopes { gradient, second: (second / (H * H)).symmetric_eigen() }
    }

    /// Inverse of the second derivatives where they curve upwards, and a guess of the like where they do not.
    fn inverse(&self) -> SMatrix<f64, N, N> {
        let scales = self.second.eigenvalues.map(|curvature| 1.0 / curvature.abs().max(LEAST_CURVATURE));
        let ways = &self.second.eigenvectors;
        let inverse = ways * DMatrix::from_diagonal(&scales) * ways.transpose();
        SMatrix::from_fn(|i, j| inverse[(i, j)])
    }
}

fn moved<const N: usize>(x: &[f64; N], variable: usize, by: f64) -> [f64; N] {
    std::array::from_fn(|k| if k == variable { x[k] + by } else { x[k] })
}

/// Least value of a smooth function of a few variables of order one, from `start`: a simplex where that is far, then steps by
/// second derivatives learnt on the way (BFGS).
pub fn minimise_smooth<const N: usize>(start: [f64; N], cost: impl Fn(&[f64; N]) -> f64) -> [f64; N] {
    let (mut x, mut least) = (start, cost(&start));
    let mut slopes = Slopes::of(&cost, &x, least);
    let is_near =
        slopes.second.eigenvalues.min() > 0.0 && (slopes.inverse() * slopes.gradient).amax() < FIRST_STEP_NEAR;
    if !is_near {
        x = simplex(start, FIRST_STEP_FAR, NEAR_COSTS, &cost);
        least = cost(&x);
        slopes = Slopes::of(&cost, &x, least);
    }
    let (mut gradient, mut inverse) = (slopes.gradient, slopes.inverse());
    for _ in 0..MOST_STEPS {
        let mut step = -inverse * gradient;
        step *= (LONGEST_STEP / step.amax().max(f64::MIN_POSITIVE)).min(1.0);
        let foretold = -step.dot(&gradient);
        if foretold < WORTH_A_STEP || !foretold.is_finite() {
            break;
        }
        let tried = (0..MOST_HALVINGS).find_map(|halving| {
            let share = 0.5f64.powi(halving as i32);
            let there: [f64; N] = std::array::from_fn(|k| x[k] + share * step[k]);
            let found = cost(&there);
            (found < least - 1e-4 * share * foretold).then_some((share, there, found))
        });
        let Some((share, there, found)) = tried else { break };
        let next = SVector::<f64, N>::from_fn(|k, _| (cost(&moved(&there, k, SLOPE_OVER)) - found) / SLOPE_OVER);
        let (way, turned) = (step * share, next - gradient);
        let along = way.dot(&turned);
        if along > 1e-10 * way.norm() * turned.norm() {
            let one = SMatrix::<f64, N, N>::identity();
            let side = one - way * turned.transpose() / along;
            inverse = side * inverse * side.transpose() + way * way.transpose() / along;
        }
        (x, gradient, least) = (there, next, found);
    }
    x
}
